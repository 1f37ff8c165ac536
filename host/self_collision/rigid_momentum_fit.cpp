// SPDX-License-Identifier: Apache-2.0
#include "host/self_collision/rigid_momentum_fit.h"

#include <algorithm>
#include <cmath>

namespace malha {

namespace {

using Vector = Vector3<double>;

Vector mean(const double (&sum)[3], double mass) { return {sum[0] / mass, sum[1] / mass, sum[2] / mass}; }

/// About the centre of mass.
Vector spin_of(const MotionSums& sums) {
  const Vector x = mean(sums.x, sums.mass), v = mean(sums.v, sums.mass);
  return Vector{sums.L[0], sums.L[1], sums.L[2]} - cross(x, v) * sums.mass;
}
/// Beside the motion of the centre of mass, J.
double energy_of(const MotionSums& sums) {
  const Vector v = mean(sums.v, sums.mass);
  return (sums.square - sums.mass * dot(v, v)) / 2;
}

}  // namespace

RigidCorrection fit_rigid_momentum(const TruncationSums& sums) {
  const double m = sums.after.mass;
  RigidCorrection gain;
  if (!(m > 0)) return gain;
  const Vector c = gain.centre = mean(sums.after.x, m);
  const auto omega_of = [&](const Vector& L) {
    SpinSum spin{{L.x, L.y, L.z}};
    std::copy_n(sums.I, 6, spin.I), centre_inertia(spin.I, m, c);
    return angular_velocity(spin);
  };
  const Vector min_distance = spin_of(sums.before), found = spin_of(sums.after);
  const Vector turn = omega_of(min_distance), turned = omega_of(found);
  const double allowed = std::max(energy_of(sums.before), 0.0), of_turn = dot(min_distance, turn) / 2;
  const double rest = std::max(energy_of(sums.after) - dot(found, turned) / 2, 0.0);
  double turns = 1;
  if (of_turn > allowed)
    gain.kept = 0, turns = std::sqrt(allowed / of_turn);
  else if (rest > allowed - of_turn)
    gain.kept = std::sqrt((allowed - of_turn) / rest);
  gain.velocity = mean(sums.before.v, m) - mean(sums.after.v, m) * gain.kept;
  gain.omega = turn * turns - turned * gain.kept;
  return gain;
}

}  // namespace malha
