// SPDX-License-Identifier: Apache-2.0
// What makes a constraint of a material: its compliance times the material's rigidity, from the mesh at rest, so that
// the same rigidity is the same cloth however fine its mesh is.
#pragma once
#include <array>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// The area of a face, m^2; of a quad the mean of its two splits.
double face_area(const Mesh& mesh, const Quad& face);

/// Of edges (both ends): length^2 / area, with the whole area of neighbouring triangles (Van Gelder 1998) and half that
/// of neighbouring quads, whose other half is their other sides'; rigidity is then Young's modulus times thickness,
/// N/m. Of edges without a face: length; rigidity is then Young's modulus times cross-section, N.
/// `shear`: the rigidity of the diagonals of quads over that of the edges. On rectangles a b diagonals of shear modulus
/// G pull along a like G a^2 / b^2, and a square's like G: sides a then have Y + G (1 - a^2 / b^2), and the sheet is
/// that of squares. Beyond a = b sqrt(1 + Y / G) they would have to push: there they keep a twentieth of Y.
std::vector<double> edge_softness(const Mesh& mesh, const std::vector<Edge>& edges, double shear = 0);

/// Of both diagonals of every quad, as shear(mesh) lists them: twice the area / length^2; rigidity: shear modulus times
/// thickness, N/m.
std::vector<double> shear_softness(const Mesh& mesh);

/// {a, b, c, d} as hinges() for every side that two faces share, with a quad's corners taken in turn as wings, so that
/// no diagonal is preferred. Quads' own diagonals do not bend. Between quads wings lie crosswise, which resists twist;
/// where that would be more twist than a plate's, on cells that are not square, a part of the hinge has its wings side
/// by side.
struct PlateHinges {
  std::vector<std::array<int, 4>> list;
  /// The area of both triangles / length^2, over the part of its side's bending that each stands for. Rigidity:
  /// flexural, N m (Seung, Nelson 1988). Of a triangle all of whose corners are held nothing counts: it does not bend,
  /// and a clamp of two rows acts in the second. Grids of rectangles and equilateral triangles bend alike in all
  /// directions; right-angled triangles whose diagonals all run alike do not, up to three times as stiff across them as
  /// along.
  std::vector<double> softness;
  int crowded = 0;  // edges of more than two faces, where nothing bends
};

/// `held`: of each point, for good.
PlateHinges plate_hinges(const Mesh& mesh, const std::vector<bool>& held);

/// What a curvature H of the sheet folds a hinge by, in the frame whose x runs along its edge and y to its first wing:
/// xx Hxx + yy Hyy + xy Hxy, m.
struct FoldByCurvature {
  double xx, yy, xy;
  /// The largest fold by a curvature of size 1, squared.
  double most2() const { return xx * xx + yy * yy + xy * xy / 2; }
};
/// Of a hinge, unfolded; all 0 where a triangle has no area.
FoldByCurvature fold_by_curvature(const Mesh& mesh, const std::array<int, 4>& hinge);

}  // namespace malha
