// SPDX-License-Identifier: Apache-2.0
// The direction of a projection: the gradient at the start of the substep, as long as the total correction of the
// constraint in the substep is small beside the element, and the current gradient for the rest.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// The largest total correction of a constraint in a substep that goes along the gradient at the start of the substep,
/// as a part of the element's size. Of a larger total, only the share within this bound goes along that gradient, and
/// the rest along the current one. Replacing the whole direction at once would throw a body at rest back and forth.
///
/// The bound is needed because the gradient at the start does not turn while a constraint moves its particles. The
/// constraint's tension then acts on transverse motion as a spring of stiffness lambda / (h^2 l), with the substep h,
/// that is integrated explicitly. Eight such constraints at a particle are unstable from lambda w / l = 1 / 8 on.
/// Without the bound, taut sheets moved by themselves at metres a second, the faster the more substeps; along the
/// current gradient they come to rest. Torn or crushed bodies, too, would keep all their energy.
///
/// Hanging, falling and turning bodies do not reach the bound where the substeps resolve their motion. With half of it,
/// sheets that hang by a corner begin to turn by themselves.
inline constexpr double kMaxStartStep = 0.04;
/// The same for a length under compression. Along the current gradient, which is implicit, tension takes energy from
/// transverse motion, but compression gives it: the spring's stiffness is negative. A cloth that pins stretch shrinks
/// across, and with the bound of tension for its compressed edges it flapped at up to 50 m/s for ever. Without a bound,
/// crushed meshes with several iterations do.
inline constexpr double kMaxCompressedStartStep = 0.12;
/// The same for a set of constraints. Pressure acts along its gradient at the start of the substep: tension along
/// another direction is not in equilibrium with it, and makes the body roll. Bodies with pressure therefore have a
/// larger bound, but a smaller one with several iterations, whose multipliers carry the whole tension: with 0.35, eight
/// of them threw a skin of 1.5 times its volume about at 30 m/s.
constexpr double max_start_step_of(bool pressed, int iterations) {
  return !pressed ? kMaxStartStep : iterations > 1 ? 0.2 : 0.35;
}
constexpr double max_compressed_start_step_of(bool pressed, int iterations) {
  return pressed ? max_start_step_of(true, iterations) : kMaxCompressedStartStep;
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
  S largest2 = w[0] * w[0] * dot(along[0], along[0]);
  for (int j = 1; j < n; ++j) largest2 = max(largest2, w[j] * w[j] * dot(along[j], along[j]));
  return largest2;
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

/// The bound of a length whose particles the total multiplier pushes apart (`push` > 0) or draws together.
template <class S>
KERNEL S bound_of_length(const S& max_start_step, const S& max_compressed_start_step, const S& push) {
  return select(push > S(0), max_compressed_start_step, max_start_step);
}

/// The bound of a constraint whose total multiplier has the sign of `multiplier`. Only of lengths does the sign tell
/// whether the force is a tension or a compression.
template <class S, int n>
KERNEL S start_step_bound(const S& max_start_step, const S& max_compressed_start_step, const S& multiplier,
                          const Vector3<S> (&along)[n], const Vector3<S> (&x)[n]) {
  if constexpr (n == 2)
    return bound_of_length(max_start_step, max_compressed_start_step, multiplier * dot(along[1], x[1] - x[0]));
  else
    return max_start_step;
}

/// Tells whether applied / denominator times `along` moves no particle farther than `max_start_step` times the
/// element's size at x. With two particles `along` is as long as the element.
template <class S, int n>
KERNEL auto moves_within(const S& max_start_step, const S& applied, const S& denominator, const S (&w)[n],
                         const Vector3<S> (&along)[n], const Vector3<S> (&x)[n]) {
  if constexpr (n == 2)
    return applied * max(w[0], w[1]) <= max_start_step * denominator;
  else
    return applied * applied * max_displacement2(w, along) <=
           max_start_step * max_start_step * size2_of(x) * denominator * denominator;
}

/// The share of a displacement that is as long as `bound`; 1 of no displacement.
template <class S>
KERNEL S share_of(const S& bound, const S& displacement) {
  const S zero(0), one(1);
  return select(displacement > zero, bound / select(displacement > zero, displacement, one), one);
}

/// The share of applied / denominator times `along` that moves no particle farther than that.
template <class S, int n>
KERNEL S share_within(const S& max_start_step, const S& applied, const S& denominator, const S (&w)[n],
                      const Vector3<S> (&along)[n], const Vector3<S> (&x)[n]) {
  if constexpr (n == 2)
    return share_of(max_start_step * denominator, applied * max(w[0], w[1]));
  else
    return share_of(max_start_step * denominator * sqrt(size2_of(x)), applied * sqrt(max_displacement2(w, along)));
}

/// Tells whether the angle between both gradients is below that of this cosine. `grad_dot_along`: their weighted_dot().
template <class S, int n>
KERNEL auto is_aligned(double cosine, const S (&w)[n], const Vector3<S> (&grad)[n], const Vector3<S> (&along)[n],
                       const S& grad_dot_along) {
  using R = typename RealOf<S>::type;
  return S(R(cosine * cosine)) * weighted_dot(w, grad, grad) * weighted_dot(w, along, along) <=
         grad_dot_along * grad_dot_along;
}

/// Tells whether a sum of w grad^2 exceeds the rounding error of the largest gradient.
template <class S, int n>
KERNEL auto exceeds_rounding(const S& sum, const S (&w)[n], const Vector3<S> (&grad)[n]) {
  using R = typename RealOf<S>::type;
  constexpr double rounding = sizeof(R) == 4 ? 0x1p-19 : 0x1p-48;  // 16 spacings at 1
  S max_w = w[0], max_grad2 = dot(grad[0], grad[0]);
  for (int j = 1; j < n; ++j) max_w = max(max_w, w[j]), max_grad2 = max(max_grad2, dot(grad[j], grad[j]));
  return sum > S(R(rounding * rounding)) * max_w * max_grad2;
}

/// Blends two corrections of constraints that are projected together. Both have the same multipliers: `move` is along
/// the current gradients, for which the multipliers were computed, and `along` is along the gradients at the start of
/// the substep. `move` becomes `along` if the two are nearly parallel, and stays as it is if they are not, because the
/// multipliers would not fit. `relative2`: the square of the total displacement in the substep over the element's size.
/// If that exceeds `max_start_step`, only a share of the correction goes along `along`.
template <class S, int n>
KERNEL void blend_with_start(const S& max_start_step, const S& relative2, const S (&w)[n], const Vector3<S> (&along)[n],
                             Vector3<S> (&move)[n]) {
  const S zero(0), one(1), move_dot_along = weighted_dot(w, move, along);
  const auto near = (zero <= move_dot_along) & is_aligned(kMinTurnCosine, w, move, along, move_dot_along);
  const auto whole = near & (relative2 <= max_start_step * max_start_step);
  if (movemask(near) != movemask(whole)) {  // rare
    const S share = select(whole, one, max_start_step / sqrt(select(whole, one, relative2))), other = one - share;
    for (int j = 0; j < n; ++j)
      move[j] = select_vector(whole, along[j], select_vector(near, along[j] * share + move[j] * other, move[j]));
  } else {
    for (int j = 0; j < n; ++j) move[j] = select_vector(whole, along[j], move[j]);
  }
}

/// `relative2` of elements that have no better measure: the largest displacement of a particle over the size at x.
template <class S, int n>
KERNEL S relative_displacement2(const S (&w)[n], const Vector3<S> (&total)[n], const Vector3<S> (&x)[n]) {
  const S zero(0), one(1), size2 = size2_of(x);
  return max_displacement2(w, total) / select(size2 > zero, size2, one);
}

}  // namespace malha
