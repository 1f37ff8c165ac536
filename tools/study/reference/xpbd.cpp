// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/xpbd.h"

namespace malha::study {

void xpbd_step(const SpringSystem& system, double h, int iterations, State& state) {
  const Vector before = state.x;
  for (int i = 0; i < system.count(); ++i) {
    if (system.pinned[i]) continue;
    state.v.segment<3>(3 * i) += h * system.gravity;
    state.x.segment<3>(3 * i) += h * state.v.segment<3>(3 * i);
  }
  std::vector<double> lambda(system.springs.size(), 0.0);
  for (int iteration = 0; iteration < iterations; ++iteration)
    for (std::size_t k = 0; k < lambda.size(); ++k) {
      const Spring& s = system.springs[k];
      const double wi = system.pinned[s.i] ? 0 : 1 / system.mass[s.i];
      const double wj = system.pinned[s.j] ? 0 : 1 / system.mass[s.j];
      const Eigen::Vector3d d = state.x.segment<3>(3 * s.i) - state.x.segment<3>(3 * s.j);
      const double length = d.norm(), alpha = 1 / s.stiffness / (h * h);
      const double change = (s.rest - length - alpha * lambda[k]) / (wi + wj + alpha);
      lambda[k] += change;
      state.x.segment<3>(3 * s.i) += wi * change / length * d;
      state.x.segment<3>(3 * s.j) -= wj * change / length * d;
    }
  state.v = (state.x - before) / h;
}

SpringSystem chain_system(const std::vector<double>& mass, double spacing, double stiffness,
                          const Eigen::Vector3d& direction, const Eigen::Vector3d& gravity) {
  SpringSystem system;
  const int n = static_cast<int>(mass.size());
  system.mass = mass, system.gravity = gravity;
  system.pinned.assign(n, false);
  system.pinned[0] = true;
  system.start = {Vector::Zero(3 * n), Vector::Zero(3 * n)};
  for (int i = 0; i < n; ++i) system.start.x.segment<3>(3 * i) = i * spacing * direction;
  for (int i = 1; i < n; ++i) system.springs.push_back({i - 1, i, stiffness, spacing});
  return system;
}

Eigen::Vector3d support_force(const System& system, const State& before, const State& after, double h) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (int i = 0; i < system.count(); ++i)
    if (!system.pinned[i]) force += system.mass[i] * ((after.v - before.v).segment<3>(3 * i) / h - system.gravity);
  return force;
}

}  // namespace malha::study
