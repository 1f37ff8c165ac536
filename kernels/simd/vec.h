// SPDX-License-Identifier: Apache-2.0
// Small vectors: Vector3 of scalars or packs, and Vec4, four numbers of one aligned load.
#pragma once
#include <math.h>

#include "kernels/parallel/compute.h"

namespace malha {

template <class S>
struct Vector3 {
  S x, y, z;

  KERNEL friend Vector3 operator+(const Vector3& a, const Vector3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  KERNEL friend Vector3 operator-(const Vector3& a, const Vector3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  KERNEL friend Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
  KERNEL friend Vector3 operator*(const Vector3& a, S s) { return {a.x * s, a.y * s, a.z * s}; }
  KERNEL friend S dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  KERNEL friend Vector3 cross(const Vector3& a, const Vector3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
};

template <class R>
KERNEL bool same(const Vector3<R>& a, const Vector3<R>& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}
template <class R>
KERNEL Vector3<double> in_double(const Vector3<R>& a) {
  return {double(a.x), double(a.y), double(a.z)};
}
template <class R>
KERNEL Vector3<R> rounded(const Vector3<double>& a) {
  return {R(a.x), R(a.y), R(a.z)};
}

/// A particle as one aligned load, 16 bytes in float. The meaning of w depends on the array.
template <class R>
struct alignas(4 * sizeof(R)) Vec4 {
  R x, y, z, w;
  KERNEL Vector3<R> xyz() const { return {x, y, z}; }
  KERNEL void set(const Vector3<R>& a) { x = a.x, y = a.y, z = a.z; }
};

// Scalar overloads of the functions on packs (kernels/simd/pack.h), so that constraints are written once.
KERNEL float sqrt(float a) { return sqrtf(a); }
KERNEL double sqrt(double a) { return ::sqrt(a); }
KERNEL double norm(const Vector3<double>& a) { return sqrt(dot(a, a)); }
template <class R>
KERNEL R select(bool mask, R a, R b) {
  return mask ? a : b;
}
template <class R>
KERNEL R max(R a, R b) {
  return a > b ? a : b;
}
template <class R>
KERNEL R min(R a, R b) {
  return a < b ? a : b;
}
/// The mask as one bit (combined masks are numbers).
KERNEL unsigned movemask(int mask) { return mask != 0 ? 1 : 0; }

/// Absolute value of a number or a pack.
template <class S>
KERNEL S abs(const S& a) {
  return max(a, -a);
}

/// The type of a lane: R for R, and for a pack of R (kernels/simd/pack.h).
template <class S>
struct RealOf {
  using type = S;
};

/// The rounding error of sum = a + b (Knuth's TwoSum, which needs no order of a and b).
template <class S>
KERNEL S rounding_error(const S& a, const S& b, const S& sum) {
  const S other = sum - a;
  return (a - (sum - other)) + (b - other);
}
template <class S>
KERNEL Vector3<S> rounding_error(const Vector3<S>& a, const Vector3<S>& b, const Vector3<S>& sum) {
  return {rounding_error(a.x, b.x, sum.x), rounding_error(a.y, b.y, sum.y), rounding_error(a.z, b.z, sum.z)};
}

/// a where the mask is set, and otherwise zero, whatever a is.
template <class Mask, class S>
KERNEL Vector3<S> or_zero(const Mask& mask, const Vector3<S>& a) {
  const S zero(0);
  return {select(mask, a.x, zero), select(mask, a.y, zero), select(mask, a.z, zero)};
}

/// a where the mask is set, otherwise b.
template <class Mask, class S>
KERNEL Vector3<S> select_vector(const Mask& mask, const Vector3<S>& a, const Vector3<S>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

/// A sum of squared gradients below this counts as zero: dividing by it could leave the range of the type. S: a number
/// or a pack.
template <class S>
KERNEL constexpr auto tiny() {
  using R = typename RealOf<S>::type;
  return sizeof(R) == 4 ? R(1e-30) : R(1e-200);
}

}  // namespace malha
