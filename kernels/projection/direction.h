// SPDX-License-Identifier: Apache-2.0
// The direction in which a projection moves its particles: the gradient where the substep began, as far as
// all that the constraint applies in the substep is small beside the element, and for the rest the gradient now.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// The largest part of an element's size by which corrections of a substep take its particles along the gradient where
/// the substep began. Of a correction beyond it only so large a share goes there, and the others along the gradient
/// where particles are: without a jump, or what rests there would be thrown from one to the other.
///
/// A direction that stays does not answer to what a constraint carries: across it is a spring of stiffness
/// lambda / (dt^2 l) that is integrated explicitly, and eight of them that cross at a particle shake from
/// lambda w / l = 1 / 8 on. So did taut sheets, at metres a second, the faster the more substeps; along the gradient
/// where they are they come to rest. And what is torn or crushed would keep all its energy. What hangs, falls and turns
/// does not come near it where the substeps resolve it: hung sheets of 16 and 46 edges have the same errors with twice
/// as much, and with half as much those that hang by a corner begin to turn by themselves.
inline constexpr double kTaut = 0.04;
/// The same for a set of constraints. The direction of pressure is that where the substep began: tension along another
/// one is not in balance with it, and rolls the body away. So bodies with pressure keep theirs longer, by less with
/// several iterations, which carry the tension in full: with 0.35, eight of them threw a skin of 1.5 times its volume
/// about at 30 m/s.
constexpr double taut_of(bool pressed, int iterations) { return !pressed ? kTaut : iterations > 1 ? 0.2 : 0.35; }
/// For constraints that are not projected in batches, the largest correction along the direction of the start.
inline constexpr double kSmall = 0.25;
/// The cosine in the metric of the masses, of 25 degrees.
inline constexpr double kTurned = 0.9;

/// The size of an element, squared: how far its particles are from the first.
template <class S, int n>
KERNEL S size2_of(const Vector3<S> (&x)[n]) {
  S size2 = dot(x[1] - x[0], x[1] - x[0]);
  for (int j = 2; j < n; ++j) size2 = max(size2, dot(x[j] - x[0], x[j] - x[0]));
  return size2;
}

/// The largest of w |along|, squared.
template <class S, int n>
KERNEL S most_way2(const S (&w)[n], const Vector3<S> (&along)[n]) {
  S way2 = w[0] * w[0] * dot(along[0], along[0]);
  for (int j = 1; j < n; ++j) way2 = max(way2, w[j] * w[j] * dot(along[j], along[j]));
  return way2;
}

/// sum of w a . b. Of two particles gradients are opposite.
template <class S, int n>
KERNEL S product(const S (&w)[n], const Vector3<S> (&a)[n], const Vector3<S> (&b)[n]) {
  if constexpr (n == 2) {
    return (w[0] + w[1]) * dot(a[0], b[0]);
  } else {
    S sum = w[0] * dot(a[0], b[0]);
    for (int j = 1; j < n; ++j) sum = sum + w[j] * dot(a[j], b[j]);
    return sum;
  }
}

/// Whether applied / per times `along` takes no particle farther than `most` of the element's size at x. Of two
/// particles `along` is as long as the element.
template <class S, int n>
KERNEL auto goes_within(const S& most, const S& applied, const S& per, const S (&w)[n], const Vector3<S> (&along)[n],
                        const Vector3<S> (&x)[n]) {
  if constexpr (n == 2)
    return applied * max(w[0], w[1]) <= most * per;
  else
    return applied * applied * most_way2(w, along) <= most * most * size2_of(x) * per * per;
}

/// The part of it that does, where it goes farther.
template <class S, int n>
KERNEL S share_within(const S& most, const S& applied, const S& per, const S (&w)[n], const Vector3<S> (&along)[n],
                      const Vector3<S> (&x)[n]) {
  const S zero(typename RealOf<S>::type(0)), one(typename RealOf<S>::type(1));
  S way;
  if constexpr (n == 2)
    way = applied * max(w[0], w[1]);
  else
    way = applied * sqrt(most_way2(w, along));
  S size = one;
  if constexpr (n > 2) size = sqrt(size2_of(x));
  return select(way > zero, most * per * size / select(way > zero, way, one), one);
}

/// Whether the gradient has turned by less than the angle of this cosine; cross: w grad . along.
template <class S, int n>
KERNEL auto has_hardly_turned(double cosine, const S (&w)[n], const Vector3<S> (&grad)[n], const Vector3<S> (&along)[n],
                              const S& cross) {
  using R = typename RealOf<S>::type;
  return S(R(cosine * cosine)) * product(w, grad, grad) * product(w, along, along) <= cross * cross;
}

/// Whether a sum of w grad^2 is more than what rounding makes of the largest gradient.
template <class S, int n>
KERNEL auto is_told(const S& sum, const S (&w)[n], const Vector3<S> (&grad)[n]) {
  using R = typename RealOf<S>::type;
  constexpr double rounding = sizeof(R) == 4 ? 0x1p-19 : 0x1p-48;  // 16 spacings at 1
  S most_w = w[0], most2 = dot(grad[0], grad[0]);
  for (int j = 1; j < n; ++j) most_w = max(most_w, w[j]), most2 = max(most2, dot(grad[j], grad[j]));
  return sum > S(R(rounding * rounding)) * most_w * most2;
}

/// What several constraints at once make of their particles: `move` along their gradients now becomes `along`, the same
/// of those where the substep began, if it has hardly turned: all of what they were solved for hangs on it. `far2`: how
/// far all that they have applied in the substep takes them over the element's size, squared. Beyond `most` a share
/// goes along.
template <class S, int n>
KERNEL void go_along(const S& most, const S& far2, const S (&w)[n], const Vector3<S> (&along)[n],
                     Vector3<S> (&move)[n]) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1)), cross = product(w, move, along);
  const auto near = (zero <= cross) & has_hardly_turned(kTurned, w, move, along, cross);
  const auto whole = near & (far2 <= most * most);
  if (movemask(near) != movemask(whole)) {  // seldom
    const S share = select(whole, one, most / sqrt(select(whole, one, far2))), other = one - share;
    for (int j = 0; j < n; ++j)
      move[j] = either(whole, along[j], either(near, along[j] * share + move[j] * other, move[j]));
  } else {
    for (int j = 0; j < n; ++j) move[j] = either(whole, along[j], move[j]);
  }
}

/// The squared measure of those whose elements have no better one: the way of the farthest particle over the size at x.
template <class S, int n>
KERNEL S far2_of(const S (&w)[n], const Vector3<S> (&carried)[n], const Vector3<S> (&x)[n]) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1)), size2 = size2_of(x);
  return most_way2(w, carried) / select(size2 > zero, size2, one);
}

}  // namespace malha
