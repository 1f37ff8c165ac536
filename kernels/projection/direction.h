// The direction in which a projection moves its particles: the gradient where the substep began, as long as the
// correction along it, and all that the constraint has applied in the substep, are small beside the element.
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

/// Of the element's size, the largest correction along the gradient where the substep began. Beyond it particles go
/// along the gradient where they are. Along the other there may be no place where the constraint is met, and what is
/// torn or crushed would keep all its energy: flags in a storm got ten times as fast as the wind with four times as
/// much, while what rests, hangs and falls does not come near it. (A bound on the angle between the two instead lets
/// such flags go, or turns the edges of pressed balls against their pressure, which rolls them away.)
inline constexpr double kSmall = 0.25;
/// The same of all that a constraint has applied in a substep. Along a direction that stays it does not answer to what
/// it carries: across it is a spring of stiffness lambda / (dt^2 l) that is integrated explicitly, and four of them
/// that cross at a particle shake from lambda w / l = 1 / 4 on. (Taut sheets and pressed balls did, at 30 to 70 m/s,
/// with so many iterations that they carried it.) Beyond this, only so large a share of a correction goes along the
/// direction of the start, and the others along that where particles are. The share changes without a jump, or what
/// rests there would be thrown from one to the other.
/// One iteration hardly reaches what is carried, and keeps to the start.
inline constexpr double kTaut = 0.2;
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

/// Whether C / cross w along is small beside the element at x. Of two particles `along` is as long as the element.
template <class S, int n>
KERNEL auto is_small(const S& C, const S& cross, const S (&w)[n], const Vector3<S> (&along)[n],
                     const Vector3<S> (&x)[n]) {
  using R = typename RealOf<S>::type;
  if constexpr (n == 2)
    return (cross > S(R(0))) & (abs(C) * max(w[0], w[1]) <= S(R(kSmall)) * cross);
  else
    return (cross > S(R(0))) & (C * C * most_way2(w, along) <= S(R(kSmall * kSmall)) * size2_of(x) * cross * cross);
}

/// The way of the farthest particle over the element's size at x, if `applied` times `along` is applied. Of two
/// particles `along` is as long as the element.
template <class S, int n>
KERNEL S way_over_size(const S& applied, const S (&w)[n], const Vector3<S> (&along)[n], const Vector3<S> (&x)[n]) {
  if constexpr (n == 2) {
    return applied * max(w[0], w[1]);
  } else {
    const S zero(typename RealOf<S>::type(0)), one(typename RealOf<S>::type(1)), size2 = size2_of(x);
    return applied * sqrt(most_way2(w, along) / select(size2 > zero, size2, one));
  }
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
/// of those where the substep began, if that is small beside the element at x and has hardly turned: all of what they
/// were solved for hangs on it.
template <class S, int n>
KERNEL void go_along(const S (&w)[n], const Vector3<S> (&along)[n], const Vector3<S> (&x)[n], Vector3<S> (&move)[n]) {
  using R = typename RealOf<S>::type;
  const S cross = product(w, move, along);
  const auto near = (S(R(0)) <= cross) & has_hardly_turned(kTurned, w, move, along, cross);
  const auto small = near & (most_way2(w, along) <= S(R(kSmall * kSmall)) * size2_of(x));
  for (int j = 0; j < n; ++j) move[j] = either(small, along[j], move[j]);
}

}  // namespace malha
