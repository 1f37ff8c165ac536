// SPDX-License-Identifier: Apache-2.0
// Distances of pairs (a particle and a triangle, or two edges) in the broad phase: a lower bound while every particle
// stays in its swept bounds, and the distance that the pair must keep.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/simd/rows.h"

namespace malha {

/// Swept bounds of the particles, from their positions at the broad phase: a capsule around the path of each.
template <class R>
struct SweptBounds {
  Vec4<R>* from;  // m; w: margin around the path, in every direction
  Vec4<R>* way;   // m, displacement along the path
  Vec4<R>* rest;  // m, rest positions, from an origin; w: the body
};

/// Pairs of bodies that intersect, a bit each: with up to eight bodies every pair has a bit of its own.
using CrossingBodies = unsigned long long;
KERNEL CrossingBodies crossing_bit(int one, int other) {
  const int low = min(one, other), high = max(one, other);
  return 1ull << (8 * low + high) % 64;
}

/// Returns true if both sides of a pair have a particle where their bodies intersect: such pairs are left out so that
/// the bodies can separate.
template <PairKind kind, class R>
KERNEL bool cross_at_both_sides(const SweptBounds<R>& bounds, const CrossingBodies* crossing, const int (&scaled)[4]) {
  const auto particle = [&](int j) KERNEL_LAMBDA { return scaled[j] / kIndexScale<R>; };
  const CrossingBodies both = crossing_bit(int(bounds.rest[particle(0)].w), int(bounds.rest[particle(3)].w));
  CrossingBodies one = 0, other = 0;
  for (int j = 0; j < 4; ++j) (j < first_side(kind) ? one : other) |= crossing[particle(j)];
  return (one & other & both) != 0;
}

/// Indices of the particles of consecutive pairs, kIndexScale times each: an array for each of the four.
struct PairIndices {
  const int* of[4];
};

/// Lower bound of the distance of as many pairs as a pack has lanes, wherever their particles are in their bounds.
template <PairKind kind, class S, class R>
KERNEL S min_swept_distance(const SweptBounds<R>& bounds, const PairIndices& at) {
  const S zero(R(0));
  Vector3<S> x[4];
  S margin[4], unused, w[4];
  for (int j = 0; j < 4; ++j) gather_rows(bounds.from, at.of[j], x[j], margin[j]);
  weigh<kind>(x, w);
  const Vector3<S> apart = closest_offset(x, w);
  const Vector3<S> n = apart * (S(R(1)) / sqrt(dot(apart, apart)));
  // For any n, the sides come no nearer along it than this.
  S side[4], size2 = zero;
  for (int j = 0; j < 4; ++j) {
    Vector3<S> way;
    gather_rows(bounds.way, at.of[j], way, unused);
    const Vector3<S> from = x[j] - x[0];
    const S along = dot(n, way);
    size2 = max(size2, dot(from, from));
    side[j] = dot(n, from) + (j < first_side(kind) ? min(along, zero) - margin[j] : max(along, zero) + margin[j]);
  }
  constexpr R kRounding = sizeof(R) == 4 ? R(2e-6) : R(1e-14);
  const S least = gap_along_normal<kind>(side) - S(kRounding) * sqrt(size2);
  return select(least == least, least, -S(R(INFINITY)));  // not a number where the sides touch
}

/// The distance that pairs must keep: the thickness, or half of their distance at rest within a body if that is less.
template <PairKind kind, class S, class R>
KERNEL S required_distance(const SweptBounds<R>& bounds, R thickness, const PairIndices& at) {
  Vector3<S> x[4];
  S body[4], w[4];
  for (int j = 0; j < 4; ++j) gather_rows(bounds.rest, at.of[j], x[j], body[j]);
  weigh<kind>(x, w);
  const Vector3<S> at_rest = closest_offset(x, w);
  const S min_distance(thickness);
  return select(body[0] == body[3], min(min_distance, sqrt(dot(at_rest, at_rest)) * S(R(0.5))), min_distance);
}

}  // namespace malha
