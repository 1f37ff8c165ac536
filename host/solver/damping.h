// Rigid-motion-preserving damping of one connected body: two reductions, a 3 x 3 solve, one pass.
#pragma once
#include "host/solver/angular_velocity.h"
#include "kernels/damping.h"

namespace malha {

/// `k` in [0, 1], for this call. Particles first .. first + count - 1; pinned ones neither count nor move.
template <class Executor, class R>
void damp(const Executor& executor, const Particles<R>& particles, int first, int count, double k) {
  const MassSum mass = parallel_reduce<MassSum>(executor, count, SumMass<R, Consecutive>{particles, {first}});
  if (!(mass.m > 0)) return;
  const double per = 1 / mass.m;
  const Vector3<double> centre{mass.x[0] * per, mass.x[1] * per, mass.x[2] * per};
  const SpinSum spin = parallel_reduce<SpinSum>(executor, count, SumSpin<R, Consecutive>{particles, {first}, centre});
  const Vector3<double> omega = angular_velocity(spin);
  parallel_for(executor, count,
               DampTowardsRigid<R>{particles,
                                   {first},
                                   R(k),
                                   rounded<R>(centre),
                                   {R(mass.v[0] * per), R(mass.v[1] * per), R(mass.v[2] * per)},
                                   rounded<R>(omega)});
}

}  // namespace malha
