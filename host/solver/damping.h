// Rigid-motion-preserving damping of one connected body: two reductions, a 3 x 3 solve, one pass.
#pragma once
#include <Eigen/Dense>

#include "kernels/damping.h"

namespace malha {

/// omega = I^-1 L. A body whose particles lie on one line or point has no inertia about some axis: the least-norm
/// solution leaves that rotation at zero.
inline Vector3<double> angular_velocity(const SpinSum& spin) {
  Eigen::Matrix3d I;
  I << spin.I[0], spin.I[3], spin.I[4], spin.I[3], spin.I[1], spin.I[5], spin.I[4], spin.I[5], spin.I[2];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(I);
  const double smallest = 1e-7 * eigen.eigenvalues()[2];  // float's rounding of the positions, with room
  Eigen::Vector3d L = eigen.eigenvectors().transpose() * Eigen::Vector3d(spin.L[0], spin.L[1], spin.L[2]);
  for (int k = 0; k < 3; ++k) L[k] = eigen.eigenvalues()[k] > smallest ? L[k] / eigen.eigenvalues()[k] : 0;
  const Eigen::Vector3d omega = eigen.eigenvectors() * L;
  return {omega[0], omega[1], omega[2]};
}

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
