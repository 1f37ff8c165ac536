// SPDX-License-Identifier: Apache-2.0
// Static stretch of suspended bodies under their own weight.
#pragma once
#include <array>
#include <vector>

#include "host/model/tangent.h"

namespace malha {

/// Particles, and how they hang together.
struct SuspendedBody {
  const std::vector<Vector>& x;            // m, at rest
  const std::vector<double>& mass;         // kg, of what is not held
  const std::vector<int>& graph_distance;  // links to what is held; 0: held, -1: nothing holds it
  const std::vector<int>& part;            // connected part of each particle
  double gravity;                          // m/s^2
};

struct Spring {
  int a, b;
  double length, alpha;  // m; m/N
};

/// A triangle of an elastic sheet.
struct SheetPiece {
  std::array<int, 3> corner;
  double Y;  // Young's modulus times thickness, N/m
};

/// Of each particle sqrt(e) n: the body there is longer by a strain of e along the unit vector n, which leads away from
/// what is held. e is the weight of all that is more links away from there, over the stiffness of the cut in between.
/// Of strips and sheets that hang by a row this is their stretch to some percent; of what hangs by points it is that of
/// rings around them. Its own loads (wind, a swing) stretch a body further.
std::vector<Vector> stretch_by_weight(const SuspendedBody& body, const std::vector<Spring>& springs,
                                      const std::vector<SheetPiece>& sheet);

}  // namespace malha
