// SPDX-License-Identifier: Apache-2.0
// Whether free bodies still have the angular momentum with which they set out. Projections along the gradients where
// the substep began keep it to rounding; those too large for that, and Desbrun's filter, do not.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha {

/// How a body turns as a whole.
struct Turning {
  Vec3 spin{};             // kg m^2/s, about its centre of mass
  double inertia[6] = {};  // kg m^2 about it: xx, yy, zz, xy, xz, yz
  double radius = 0;       // m: of the farthest particle from it
};

/// Looks at free bodies when it is made and when it is asked, and costs nothing between: without a corrector of
/// inertia, where no wind, collision, sleep or tears, and of a body no pins or attachments, could change its angular
/// momentum. Gravity turns none. Of linear momentum float keeps all but 5e-4 a minute, 100 km from the origin too.
class KeptMomenta {
 public:
  /// From the simulation's state now.
  explicit KeptMomenta(const Simulation& simulation);
  /// A warning for each body whose angular momentum changed by over a tenth of what there was, and by more than turns
  /// the body by a tenth of a radian in that time. As measured, not estimated.
  std::vector<std::string> broken(const Simulation& simulation) const;

 private:
  double time_;                                // s
  std::vector<std::optional<Turning>> start_;  // of each body; none: something can change it
};

}  // namespace malha
