// How fast a body turns as a whole. Apart from what uses it: Eigen takes compilers long, and those of devices longer.
#pragma once
#include "kernels/damping.h"

namespace malha {

/// omega = I^-1 L. A body whose particles lie on one line or point has no inertia about some axis: the least-norm
/// solution leaves that rotation at zero.
Vector3<double> angular_velocity(const SpinSum& spin);

}  // namespace malha
