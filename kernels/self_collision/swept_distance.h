// SPDX-License-Identifier: Apache-2.0
// How near the sides of a pair (a particle and a triangle, or two edges) can come while every particle stays in the box
// of its search, and how near they may.
#pragma once
#include "kernels/geometry/closest_point.h"

namespace malha {

/// Where particles may go in the frame of their common motion: from where they were at the search.
template <class R>
struct SweptBounds {
  Vec4<R>* from;  // w: how far beyond the way, in every direction
  Vec4<R>* way;
  Vec4<R>* rest;  // positions at the start of the scene, from an origin; w: the body
};

/// Which pairs of bodies cross, a bit each: with up to eight bodies a bit of their own.
using CrossingBodies = unsigned long long;
KERNEL CrossingBodies crossing_bit(int one, int other) {
  const int low = min(one, other), high = max(one, other);
  return 1ull << (8 * low + high) % 64;
}

/// Whether the bodies of four particles cross at both sides: such pairs must be able to part.
template <PairKind kind, class R>
KERNEL bool cross_at_both_sides(const SweptBounds<R>& reach, const CrossingBodies* crosses, const int (&scaled)[4]) {
  const auto particle = [&](int j) KERNEL_LAMBDA { return scaled[j] / kIndexScale<R>; };
  const CrossingBodies both = crossing_bit(int(reach.rest[particle(0)].w), int(reach.rest[particle(3)].w));
  CrossingBodies one = 0, other = 0;
  for (int j = 0; j < 4; ++j) (j < first_side(kind) ? one : other) |= crosses[particle(j)];
  return (one & other & both) != 0;
}

/// Where the numbers of the particles of some pairs begin, kIndexScale times each: of each of the four.
struct PairIndices {
  const int* of[4];
};

/// How near pairs can come, at least: as many as a pack has lanes.
template <PairKind kind, class S, class R>
KERNEL S min_swept_distance(const SweptBounds<R>& reach, const PairIndices& at) {
  const S zero(R(0));
  Vector3<S> x[4];
  S beyond[4], unused, w[4];
  for (int j = 0; j < 4; ++j) gather_rows(reach.from, at.of[j], x[j], beyond[j]);
  weigh<kind>(x, w);
  const Vector3<S> apart = closest_difference(x, w);
  const Vector3<S> n = apart * (S(R(1)) / sqrt(dot(apart, apart)));
  const S diagonal = abs(n.x) + abs(n.y) + abs(n.z);
  // Along whatever n, the sides come no nearer than this.
  S side[4], size2 = zero;
  for (int j = 0; j < 4; ++j) {
    Vector3<S> way;
    gather_rows(reach.way, at.of[j], way, unused);
    const Vector3<S> from = x[j] - x[0], along{n.x * way.x, n.y * way.y, n.z * way.z};
    size2 = max(size2, dot(from, from));
    if (j < first_side(kind))
      side[j] = dot(n, from) + min(along.x, zero) + min(along.y, zero) + min(along.z, zero) - beyond[j] * diagonal;
    else
      side[j] = dot(n, from) + max(along.x, zero) + max(along.y, zero) + max(along.z, zero) + beyond[j] * diagonal;
  }
  constexpr R kRounding = sizeof(R) == 4 ? R(2e-6) : R(1e-14);
  const S least = gap_along_normal<kind>(side) - S(kRounding) * sqrt(size2);
  return select(least == least, least, -S(R(INFINITY)));  // no number: where the sides touch
}

/// How near they may: the thickness, or half as far as at rest where that is less.
template <PairKind kind, class S, class R>
KERNEL S required_distance(const SweptBounds<R>& reach, R thickness, const PairIndices& at) {
  Vector3<S> x[4];
  S body[4], w[4];
  for (int j = 0; j < 4; ++j) gather_rows(reach.rest, at.of[j], x[j], body[j]);
  weigh<kind>(x, w);
  const Vector3<S> there = closest_difference(x, w);
  const S min_distance(thickness);
  return select(body[0] == body[3], min(min_distance, sqrt(dot(there, there)) * S(R(0.5))), min_distance);
}

}  // namespace malha
