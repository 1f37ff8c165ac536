// SPDX-License-Identifier: Apache-2.0
// Directional stiffness of a mesh of springs or hinges with a rigidity, relative to the isotropic sheet of that
// rigidity.
#pragma once
#include <array>
#include <vector>

#include "malha/mesh.h"

namespace malha {

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
