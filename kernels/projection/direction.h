// SPDX-License-Identifier: Apache-2.0
// The direction of a projection: the gradient at the start of the substep, as long as the total correction of the
// constraint in the substep is small beside the element, and the current gradient for the rest.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// The largest total correction of a constraint in a substep that goes along the gradient at the start of the substep,
/// as a part of the element's size. Of a larger total only that share goes along it, and the rest along the current
/// gradient: a jump from one to the other would throw a body at rest back and forth.
///
/// A fixed direction does not respond to the constraint's own force: transverse motion then has a spring of stiffness
/// lambda / (dt^2 l) that is integrated explicitly, and eight of them at a particle become unstable from
/// lambda w / l = 1 / 8 on. Taut sheets did so, at metres a second, the faster the more substeps; along the current
/// gradient they come to rest. Torn or crushed bodies, too, would keep all their energy. Hanging, falling and turning
/// bodies do not reach this bound where the substeps resolve them: hung sheets of 16 and 46 edges have the same errors
/// with twice as much; with half as much, those that hang by a corner begin to turn by themselves.
inline constexpr double kMaxStartStep = 0.04;
/// The same for a set of constraints. Pressure acts along its gradient at the start of the substep: tension along
/// another direction is not in equilibrium with it, and makes the body roll. Bodies with pressure therefore have a
/// larger bound, but a smaller one with several iterations, whose multipliers carry the whole tension: with 0.35, eight
/// of them threw a skin of 1.5 times its volume about at 30 m/s.
constexpr double max_start_step_of(bool pressed, int iterations) {
  return !pressed ? kMaxStartStep : iterations > 1 ? 0.2 : 0.35;
}
/// The largest single correction along the direction at the start, over the distance, for constraints that are not
/// projected in batches.
inline constexpr double kMaxStartCorrection = 0.25;
/// The cosine, in the metric of the masses, of the largest angle (26 degrees) between both gradients.
inline constexpr double kMinTurnCosine = 0.9;

/// The size of an element, squared: the largest distance of its particles from the first.
template <class S, int n>
KERNEL S size2_of(const Vector3<S> (&x)[n]) {
  S size2 = dot(x[1] - x[0], x[1] - x[0]);
  for (int j = 2; j < n; ++j) size2 = max(size2, dot(x[j] - x[0], x[j] - x[0]));
  return size2;
}

/// The largest displacement w |along| of a particle, squared.
template <class S, int n>
KERNEL S max_displacement2(const S (&w)[n], const Vector3<S> (&along)[n]) {
  S way2 = w[0] * w[0] * dot(along[0], along[0]);
  for (int j = 1; j < n; ++j) way2 = max(way2, w[j] * w[j] * dot(along[j], along[j]));
  return way2;
}

/// sum of w a . b. With two particles the gradients are opposite.
template <class S, int n>
KERNEL S weighted_dot(const S (&w)[n], const Vector3<S> (&a)[n], const Vector3<S> (&b)[n]) {
  if constexpr (n == 2) {
    return (w[0] + w[1]) * dot(a[0], b[0]);
  } else {
    S sum = w[0] * dot(a[0], b[0]);
    for (int j = 1; j < n; ++j) sum = sum + w[j] * dot(a[j], b[j]);
    return sum;
  }
}

/// Tells whether applied / per times `along` moves no particle farther than `most` times the element's size at x. With
/// two particles `along` is as long as the element.
template <class S, int n>
KERNEL auto moves_within(const S& most, const S& applied, const S& per, const S (&w)[n], const Vector3<S> (&along)[n],
                         const Vector3<S> (&x)[n]) {
  if constexpr (n == 2)
    return applied * max(w[0], w[1]) <= most * per;
  else
    return applied * applied * max_displacement2(w, along) <= most * most * size2_of(x) * per * per;
}

/// The share of that correction that does not exceed it, where the whole does.
template <class S, int n>
KERNEL S share_within(const S& most, const S& applied, const S& per, const S (&w)[n], const Vector3<S> (&along)[n],
                      const Vector3<S> (&x)[n]) {
  const S zero(typename RealOf<S>::type(0)), one(typename RealOf<S>::type(1));
  S way;
  if constexpr (n == 2)
    way = applied * max(w[0], w[1]);
  else
    way = applied * sqrt(max_displacement2(w, along));
  S size = one;
  if constexpr (n > 2) size = sqrt(size2_of(x));
  return select(way > zero, most * per * size / select(way > zero, way, one), one);
}

/// Tells whether the angle between both gradients is below that of this cosine; cross: w grad . along.
template <class S, int n>
KERNEL auto is_aligned(double cosine, const S (&w)[n], const Vector3<S> (&grad)[n], const Vector3<S> (&along)[n],
                       const S& cross) {
  using R = typename RealOf<S>::type;
  return S(R(cosine * cosine)) * weighted_dot(w, grad, grad) * weighted_dot(w, along, along) <= cross * cross;
}

/// Tells whether a sum of w grad^2 exceeds the rounding error of the largest gradient.
template <class S, int n>
KERNEL auto exceeds_rounding(const S& sum, const S (&w)[n], const Vector3<S> (&grad)[n]) {
  using R = typename RealOf<S>::type;
  constexpr double rounding = sizeof(R) == 4 ? 0x1p-19 : 0x1p-48;  // 16 spacings at 1
  S most_w = w[0], most2 = dot(grad[0], grad[0]);
  for (int j = 1; j < n; ++j) most_w = max(most_w, w[j]), most2 = max(most2, dot(grad[j], grad[j]));
  return sum > S(R(rounding * rounding)) * most_w * most2;
}

/// Replaces the correction `move` of several simultaneous constraints, which is along their current gradients, by
/// `along`, the same along those at the start of the substep, if both are nearly parallel: the corrections were solved
/// for with the current ones. `relative2`: total displacement in the substep over the element's size, squared. Beyond
/// `most` only a share goes along.
template <class S, int n>
KERNEL void blend_with_start(const S& most, const S& relative2, const S (&w)[n], const Vector3<S> (&along)[n],
                             Vector3<S> (&move)[n]) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1)), cross = weighted_dot(w, move, along);
  const auto near = (zero <= cross) & is_aligned(kMinTurnCosine, w, move, along, cross);
  const auto whole = near & (relative2 <= most * most);
  if (movemask(near) != movemask(whole)) {  // rare
    const S share = select(whole, one, most / sqrt(select(whole, one, relative2))), other = one - share;
    for (int j = 0; j < n; ++j)
      move[j] = either(whole, along[j], either(near, along[j] * share + move[j] * other, move[j]));
  } else {
    for (int j = 0; j < n; ++j) move[j] = either(whole, along[j], move[j]);
  }
}

/// `relative2` of elements that have no better measure: the largest displacement of a particle over the size at x.
template <class S, int n>
KERNEL S relative_displacement2(const S (&w)[n], const Vector3<S> (&total)[n], const Vector3<S> (&x)[n]) {
  using R = typename RealOf<S>::type;
  const S zero(R(0)), one(R(1)), size2 = size2_of(x);
  return max_displacement2(w, total) / select(size2 > zero, size2, one);
}

}  // namespace malha
