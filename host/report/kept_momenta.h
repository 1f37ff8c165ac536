// Whether free bodies still have the momenta with which they set out: nothing but rounding and the order of projections
// can change them.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/simulation.h"

namespace malha {

/// A body's rigid motion.
struct RigidState {
  double mass = 0;         // kg
  Vec3 momentum{};         // kg m/s
  Vec3 spin{};             // kg m^2/s, about its centre of mass
  double inertia[6] = {};  // kg m^2 about it: xx, yy, zz, xy, xz, yz
  double radius = 0;       // m: of the farthest particle from it
  double speed = 0;        // m/s, the fastest particle's
};

/// Looks at free bodies when it is made and when it is asked, and costs nothing between: without a corrector of
/// inertia, where no wind, collision, sleep or tears, and of a body no pins or attachments, could change its momenta.
/// Gravity turns none.
class KeptMomenta {
 public:
  /// From the simulation's state now.
  explicit KeptMomenta(const Simulation& simulation);
  /// A warning for each momentum of a body that changed: the angular one by over a tenth of what there was, and by more
  /// than turns the body by a tenth of a radian in that time; the linear one, without gravity, by over a hundredth of
  /// the body's speed, or where it has none, of its fastest particle's. As measured, not estimated.
  std::vector<std::string> broken(const Simulation& simulation) const;

 private:
  double time_;                                   // s
  std::vector<std::optional<RigidState>> start_;  // of each body; none: something can change its momenta
};

}  // namespace malha
