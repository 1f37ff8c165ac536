// The momenta of a free body under Desbrun's filter: two reductions, a 3 x 3 solve, one pass.
#pragma once
#include "host/scene.h"
#include "host/solver/damping.h"
#include "kernels/corrector.h"

namespace malha {

/// Takes the mean, and as `corrector` says the torque, from the accelerations that internal forces gave a free body.
/// `particles`: their x those of the substep's start; the velocities are not looked at.
template <class Executor, class R>
void correct(const Executor& executor, Particles<R> particles, const Points<R>& acceleration, const int* list,
             int count, Corrector corrector) {
  const Listed members{list};
  particles.v = acceleration;
  const MassSum mass = parallel_reduce<MassSum>(executor, count, SumMass<R, Listed>{particles, members});
  const double per = 1 / mass.m;
  const Vector3<double> centre{mass.x[0] * per, mass.x[1] * per, mass.x[2] * per};
  const Vector3<R> at = rounded<R>(centre), mean{R(mass.v[0] * per), R(mass.v[1] * per), R(mass.v[2] * per)};
  SpinSum spin;
  if (corrector != Corrector::Off)
    spin = parallel_reduce<SpinSum>(executor, count, SumSpin<R, Listed>{particles, members, centre});
  if (corrector == Corrector::Paper) {
    const Vector3<double> torque{spin.L[0], spin.L[1], spin.L[2]};
    parallel_for(executor, count, RemoveAsPublished<R>{particles, acceleration, members, at, mean, rounded<R>(torque)});
  } else {
    const Vector3<double> alpha = corrector == Corrector::Off ? Vector3<double>{0, 0, 0} : angular_velocity(spin);
    parallel_for(executor, count, RemoveRigid<R>{particles, acceleration, members, at, mean, rounded<R>(alpha)});
  }
}

}  // namespace malha
