// SPDX-License-Identifier: Apache-2.0
#include "host/self_collision/rigid_momentum_fit.h"

#include <algorithm>
#include <cmath>

namespace malha {

namespace {

using Vector = Vector3<double>;

Vector mean(const double (&sum)[3], double mass) { return {sum[0] / mass, sum[1] / mass, sum[2] / mass}; }

/// Angular momentum about the centre of mass.
Vector spin_of(const MotionSums& sums) {
  const Vector x = mean(sums.x, sums.mass), v = mean(sums.v, sums.mass);
  return Vector{sums.L[0], sums.L[1], sums.L[2]} - cross(x, v) * sums.mass;
}
/// Kinetic energy relative to the centre of mass, J.
double energy_of(const MotionSums& sums) {
  const Vector v = mean(sums.v, sums.mass);
  return (sums.square - sums.mass * dot(v, v)) / 2;
}

}  // namespace

RigidCorrection fit_rigid_momentum(const TruncationSums& sums) {
  const double m = sums.after.mass;
  RigidCorrection correction;
  if (!(m > 0)) return correction;
  const Vector c = correction.centre = mean(sums.after.x, m);
  const auto omega_of = [&](const Vector& L) {
    SpinSum spin{{L.x, L.y, L.z}};
    std::copy_n(sums.I, 6, spin.I), centre_inertia(spin.I, m, c);
    return angular_velocity(spin);
  };
  const Vector wanted_spin = spin_of(sums.before), spin = spin_of(sums.after);
  const Vector wanted_omega = omega_of(wanted_spin), omega = omega_of(spin);
  const double max_energy = std::max(energy_of(sums.before), 0.0), rotation_energy = dot(wanted_spin, wanted_omega) / 2;
  const double rest = std::max(energy_of(sums.after) - dot(spin, omega) / 2, 0.0);
  double scale = 1;
  if (rotation_energy > max_energy)
    correction.kept = 0, scale = std::sqrt(max_energy / rotation_energy);
  else if (rest > max_energy - rotation_energy)
    correction.kept = std::sqrt((max_energy - rotation_energy) / rest);
  correction.velocity = mean(sums.before.v, m) - mean(sums.after.v, m) * correction.kept;
  correction.omega = wanted_omega * scale - omega * correction.kept;
  return correction;
}

}  // namespace malha
