// SPDX-License-Identifier: Apache-2.0
// Static stretch of suspended bodies under their own weight.
#pragma once
#include <array>
#include <vector>

#include "host/model/tangent.h"

namespace malha {

/// Particles of suspended bodies, and their graph distances to the pins.
struct SuspendedBody {
  const std::vector<Vector>& x;            // m, at rest
  const std::vector<double>& mass;         // kg, 0 for pinned particles
  const std::vector<int>& graph_distance;  // links to the nearest pin; 0: pinned, -1: not connected with a pin
  const std::vector<int>& part;            // connected component of each particle
  double gravity;                          // m/s^2
};

struct Spring {
  int a, b;
  double length, alpha;  // m; m/N
};

/// A triangle of an elastic sheet.
struct SheetTriangle {
  std::array<int, 3> corner;
  double Y;  // Young's modulus times thickness, N/m
};

/// Returns sqrt(e) n for each particle, where e is the static strain along the unit vector n, which points away from
/// the pins. e is the weight of all particles with a larger graph distance over the stiffness of the cross-section
/// between. For strips and sheets that hang by a row this is accurate to some percent. For bodies that hang by points
/// it is the stretch of rings around these. Other loads (wind, swinging) are not included.
std::vector<Vector> stretch_by_weight(const SuspendedBody& body, const std::vector<Spring>& springs,
                                      const std::vector<SheetTriangle>& sheet);

}  // namespace malha
