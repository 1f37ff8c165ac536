// SPDX-License-Identifier: Apache-2.0
// Drift of the angular momentum of free bodies during a run. Projections along the gradients at the start of the
// substep conserve it to rounding; too large ones, and Desbrun's filter, do not.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha {

/// Rotation of a body as a whole.
struct BodyRotation {
  Vec3 spin{};             // kg m^2/s, angular momentum about its centre of mass
  double inertia[6] = {};  // kg m^2, moments of inertia about it: xx, yy, zz, xy, xz, yz
  double radius = 0;       // m, distance of the farthest particle from it
};

/// Measures the angular momenta of free bodies at construction and in warnings(), and costs nothing in between. It
/// covers scenes without a corrector of inertia, wind, collision, sleep and tears, and bodies without pins and
/// attachments, because these may change an angular momentum. Gravity does not. Linear momentum needs no check: float
/// conserves all but 5e-4 of it a minute, 100 km from the origin too.
class MomentumDrift {
 public:
  /// Measures the present state.
  explicit MomentumDrift(const Simulation& simulation);
  /// Returns a warning for each body whose angular momentum changed by more than a tenth, and by more than rotates the
  /// body by a tenth of a radian in that time. The change is measured, not estimated.
  std::vector<std::string> warnings(const Simulation& simulation) const;

 private:
  double time_;                                     // s
  std::vector<std::optional<BodyRotation>> start_;  // by body; none where forces can change it
};

}  // namespace malha
