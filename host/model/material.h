// What makes a constraint of a material: its compliance times the material's rigidity, from the mesh at rest, so that
// the same rigidity is the same cloth however fine its mesh is.
#pragma once
#include <vector>

#include "host/mesh.h"

namespace malha {

/// Of edges (both ends): length^2 / area, with the whole area of neighbouring triangles (Van Gelder 1998) and half that
/// of neighbouring quads, whose other half is their other sides'; rigidity is then Young's modulus times thickness,
/// N/m. Of edges without a face: length; rigidity is then Young's modulus times cross-section, N.
std::vector<double> edge_softness(const Mesh& mesh, const std::vector<Edge>& edges);

/// Of both diagonals of every quad, as shear(mesh) lists them: twice the area / length^2; rigidity: shear modulus times
/// thickness, N/m.
std::vector<double> shear_softness(const Mesh& mesh);

/// Of plate_hinges(mesh) with their shares: the area of both triangles / length^2 / share. Rigidity: flexural, N m
/// (Seung, Nelson 1988). Grids of quads and equilateral triangles bend alike in all directions; right-angled triangles
/// whose diagonals all run alike do not, up to three times as stiff across them as along.
std::vector<double> hinge_softness(const Mesh& mesh, const std::vector<std::array<int, 4>>& hinges,
                                   const std::vector<double>& shares);

}  // namespace malha
