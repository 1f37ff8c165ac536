#include "host/solver/angular_velocity.h"

#include <Eigen/Dense>

namespace malha {

Vector3<double> angular_velocity(const SpinSum& spin) {
  Eigen::Matrix3d I;
  I << spin.I[0], spin.I[3], spin.I[4], spin.I[3], spin.I[1], spin.I[5], spin.I[4], spin.I[5], spin.I[2];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(I);
  const double smallest = 1e-7 * eigen.eigenvalues()[2];  // float's rounding of the positions, with room
  Eigen::Vector3d L = eigen.eigenvectors().transpose() * Eigen::Vector3d(spin.L[0], spin.L[1], spin.L[2]);
  for (int k = 0; k < 3; ++k) L[k] = eigen.eigenvalues()[k] > smallest ? L[k] / eigen.eigenvalues()[k] : 0;
  const Eigen::Vector3d omega = eigen.eigenvectors() * L;
  return {omega[0], omega[1], omega[2]};
}

}  // namespace malha
