// SPDX-License-Identifier: Apache-2.0
// Contact frame and division plane of a pair of primitives (a particle and a triangle, or two edges): the extent of
// both sides along its normal, and the gap that must stay open between them. Self-collision and contacts with edges of
// the environment use it.
#pragma once
#include "kernels/geometry/closest_point.h"

namespace malha {

/// Extent of the sides of a pair along the normal of its plane, which points from the second side to the first: the
/// lowest point of the first side and the highest of the second.
template <class S>
struct ContactSides {
  S low = S(INFINITY), high = -S(INFINITY);
  /// Adds particle j at coordinate `at` along the normal; the first `first` particles are the first side.
  KERNEL void add(int j, int first, S at) {
    if (j < first)
      low = min(low, at);
    else
      high = max(high, at);
  }
};

/// The gap (m) that a pair with this gap at the start of the substep must keep at its end: a tenth of it, but at least
/// `least`, unless the gap is smaller than that already.
template <class S>
KERNEL S required_gap(const S& gap, typename RealOf<S>::type least) {
  using R = typename RealOf<S>::type;
  return min(gap, max(gap * S(R(0.1)), S(least)));
}

/// Contact frame of one pair, computed in double.
template <class R>
struct ContactFrameDouble {
  Vector3<R> n{R(0), R(0), R(0)};
  R w[4] = {}, distance = R(0), gap = R(INFINITY);  // the defaults hold where the sides touch

  /// `at`: positions of the particles, of which `first_of` are the one side.
  KERNEL ContactFrameDouble(const Vector3<double> (&at)[4], int first_of) : first(first_of) {
    for (int j = 0; j < 4; ++j) x[j] = at[j];
    double weight[4];
    closest_weights(first, x, weight);
    const Vector3<double> apart = closest_offset(x, weight);
    const double exact = sqrt(dot(apart, apart));
    if (!(exact > 0)) return;
    set_frame(apart, weight);
    distance = R(exact), gap = R(gap_of(x));
  }

  /// Turns n to the normal at the end of the motion, or halfway there, if along it the sides are apart at the start and
  /// at the end by half of their distance or of the minimum distance. The distance is then that along n.
  KERNEL void turn(const Vector3<double> (&motion)[4], R min_distance) {
    const double enough = 0.5 * min(double(distance), double(min_distance));
    const ContactFrameDouble before = *this;
    Vector3<double> end[4];
    double weight[4];
    for (int j = 0; j < 4; ++j) end[j] = x[j] + motion[j];
    closest_weights(first, end, weight);
    const Vector3<double> end_normal = unit(closest_offset(end, weight));
    set_frame(end_normal, weight);
    if (!(gap_of(x) > enough)) {
      for (int j = 0; j < 4; ++j) weight[j] = double(before.w[j]);
      set_frame(unit(end_normal + in_double(before.n)), weight);
      if (!(min(gap_of(x), gap_of(end)) > enough)) {
        *this = before;
        return;
      }
    }
    gap = R(gap_of(x)), distance = R(dot(in_double(n), closest_offset(x, weight)));
  }

 private:
  KERNEL void set_frame(const Vector3<double>& along, const double* weight) {
    n = rounded<R>(unit(along));
    for (int j = 0; j < 4; ++j) w[j] = R(weight[j]);
  }
  /// The gap between the planes of normal n (as stored) that separate the sides.
  KERNEL double gap_of(const Vector3<double>* at) const {
    ContactSides<double> sides;
    for (int j = 0; j < 4; ++j) sides.add(j, first, dot(in_double(n), at[j] - at[0]));
    return sides.low - sides.high;
  }
  KERNEL static Vector3<double> unit(const Vector3<double>& a) { return a * (1 / sqrt(dot(a, a))); }

  int first;
  Vector3<double> x[4];
};

}  // namespace malha
