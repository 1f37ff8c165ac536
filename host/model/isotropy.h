// SPDX-License-Identifier: Apache-2.0
// The directional stiffness that a rigidity gives a mesh of springs or hinges, compared with the sheet that it names.
#pragma once
#include <array>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// How stiffly a sheet resists one and the same strain, or curvature, along each of its directions, over how stiffly it
/// should: in the softest direction and in the stiffest, on average over the vertices inside. A vertex has half of each
/// of its edges and hinges: what is left to chance about it evens out, what runs alike does not.
struct Isotropy {
  double least = 1, most = 1;
};

/// Of springs by their edges and what each has for a rigidity of 1 (1 / softness); of edges Y and diagonals G (N/m). On
/// triangles they should be the sheet of Young's modulus times thickness Y and Poisson's ratio 1/3, all that springs
/// can be; on quads that of squares, which these springs are exactly.
Isotropy isotropy_of_springs(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<double>& stiffness,
                             double Y, double G);

/// Of hinges with their softness: they should be a plate of rigidity 1.
Isotropy isotropy_of_hinges(const Mesh& mesh, const std::vector<std::array<int, 4>>& hinges,
                            const std::vector<double>& softness);

}  // namespace malha
