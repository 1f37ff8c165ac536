// SPDX-License-Identifier: Apache-2.0
// Softness of constraints of a material: compliance times rigidity, computed from the mesh at rest, so that a rigidity
// describes the same cloth on meshes of any resolution; and the directional stiffness of such a mesh, relative to the
// isotropic sheet of that rigidity.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "host/mesh/rest_shape.h"
#include "kernels/projection/constraint_kind.h"
#include "malha/mesh.h"
#include "malha/scene.h"

namespace malha {

/// The area of a face, m^2. For a quad it is the mean over its two triangulations.
double face_area(const Mesh& mesh, const Quad& face);

/// Softness of edges. For edges of faces it is length^2 / area, with the whole area of adjacent triangles (Van Gelder
/// 1998) and half of that of adjacent quads, whose other half belongs to their other sides; rigidity is then Young's
/// modulus times thickness, N/m. For edges without a face it is the length; rigidity is then Young's modulus times
/// cross-section, N. `shear` is the rigidity of the diagonals of quads over that of the edges. On rectangles a x b,
/// diagonals of shear modulus G act along a like G a^2 / b^2, on squares like G. Sides a therefore get Y + G (1 - a^2 /
/// b^2), so that the sheet equals that of squares. Beyond a = b sqrt(1 + Y / G) this would be negative: there a
/// twentieth of Y is kept.
std::vector<double> edge_softness(const RestShape& shape, const std::vector<Edge>& edges, double shear = 0);

/// Softness of both diagonals of every quad, in the order of shear(mesh): twice the area / length^2; rigidity is the
/// shear modulus times thickness, N/m.
std::vector<double> shear_softness(const Mesh& mesh);

/// Hinges {a, b, c, d}, as those of hinges(), at every side that two faces share, and at both diagonals of each quad.
/// Each corner of a quad is the wing of a hinge of its own, so that no diagonal is preferred. At a side between quads
/// both wings are on the same side, next to one end: these hinges do not resist twist, which those of the diagonals do.
/// Wings that are diagonally opposite would resist it too, but not a checkerboard of lifts.
struct PlateHinges {
  std::vector<std::array<int, 4>> list;
  /// The area of both triangles / length^2, times the number of hinges at a side; of diagonals their length^2 over the
  /// area of the quad. Rigidity is flexural, N m (Seung, Nelson 1988). A triangle at a side whose corners are all
  /// pinned does not bend and does not count, so that a clamp of two rows acts in the second. Grids of rectangles and
  /// equilateral triangles are isotropic. Right-angled triangles whose diagonals are all parallel are not: they are up
  /// to three times as stiff across them as along.
  std::vector<double> softness;
  int non_manifold = 0;  // number of edges with more than two faces, which have no hinge
};

/// `pinned`: whether each point is pinned permanently.
PlateHinges plate_hinges(const RestShape& shape, const std::vector<bool>& pinned);

/// The fold of a hinge by a curvature H of the sheet, xx Hxx + yy Hyy + xy Hxy (m), in the frame whose x axis runs
/// along the edge and whose y axis points to the first wing.
struct FoldByCurvature {
  double xx, yy, xy;
  /// The square of the largest fold by a curvature of norm 1.
  double most2() const { return xx * xx + yy * yy + xy * xy / 2; }
};
/// Of an unfolded hinge; all 0 if one of its triangles has no area.
FoldByCurvature fold_by_curvature(const RestShape& shape, const std::array<int, 4>& hinge);

/// The constants of the material of a constraint with two moduli; none for one that is isotropic. A shear modulus or
/// twisting rigidity that is not given is Huber's (1923): with nu^2 = nu_12 nu_21 it is sqrt(E_1 E_2) / (2 (1 + nu)) or
/// sqrt(D_1 D_2) (1 - nu) / 2, which of equal moduli is that of the isotropic material.
std::optional<Orthotropic> orthotropic_of(const ConstraintSpec& spec);

/// The rigidity of a plate against the fold of a hinge, over that along.
double rigidity_across(const RestShape& shape, const std::array<int, 4>& hinge, const Orthotropic& material);

/// Triangles with their three neighbours, the elements of `plate` (kernels/constraints/plate.h).
struct WingedTriangles {
  // The corners 0 .. 2 of each triangle; 3 + i is the far corner of the neighbour across from corner i.
  std::vector<std::array<int, 6>> list;
  /// Area of each triangle over the area that it represents: its own, and a share of that of nearby triangles that have
  /// fewer than three neighbours or whose six points do not determine a curvature. Triangles whose corners are all
  /// pinned do not bend.
  std::vector<double> softness;
  /// Hinges of the sides at which no winged triangle lies, in the form of hinges(mesh), and their softness: the area of
  /// both triangles over the edge's length^2. A hinge represents a third of both triangles.
  std::vector<std::array<int, 4>> hinges;
  std::vector<double> hinge_softness;
  int non_manifold = 0;  // number of edges with more than two triangles, which do not bend
};

/// The winged triangles of triangles(shape.mesh()). `pinned`: whether each point is pinned permanently.
WingedTriangles winged_triangles(const RestShape& shape, const std::vector<bool>& pinned);

/// Stiffness against a strain or curvature along a direction, relative to the isotropic sheet: in the softest and in
/// the stiffest direction, as means over the interior vertices. Each vertex has half of each of its edges and hinges,
/// so that random orientations average out and common ones do not.
struct Isotropy {
  double softest = 1, stiffest = 1;
};

/// Isotropy of springs with the given edges and stiffnesses (N/m), of a material with rigidity Y of edges and G of
/// diagonals (N/m). On triangles the reference is the sheet with Young's modulus times thickness Y and Poisson's ratio
/// 1/3, the only ratio that springs have; on quads it is the sheet of squares, which these springs represent exactly.
Isotropy isotropy_of_springs(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<double>& stiffness,
                             double Y, double G);

/// Isotropy of hinges with the given softness; the reference is a plate of rigidity 1.
Isotropy isotropy_of_hinges(const Mesh& mesh, const std::vector<std::array<int, 4>>& hinges,
                            const std::vector<double>& softness);

}  // namespace malha
