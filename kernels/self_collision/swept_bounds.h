// SPDX-License-Identifier: Apache-2.0
// Swept bounds of particles: capsules around their paths, and checks that particles stay in those of the last broad
// phase.
#pragma once
#include "kernels/geometry/simplex.h"
#include "kernels/parallel/compute.h"
#include "kernels/self_collision/contact_block.h"
#include "kernels/self_collision/swept_distance.h"
#include "kernels/simd/particles.h"

namespace malha {

/// moved = p - x0, and the inverse mass.
template <class R>
struct ComputeDisplacements {
  Displaced<R> p;
  const R* w;
  Trajectories<R> motions;
  KERNEL void operator()(int i) const {
    const Vector3<R> d = p.displacement_from(i, motions.x0[i].xyz(), motions.origin);
    motions.moved[i] = {d.x, d.y, d.z, w[i]};
  }
};

/// p = x0 + moved, of particles that contacts moved.
template <class R>
struct ApplyDisplacements {
  Trajectories<R> motions;
  Displaced<R> p;
  KERNEL void operator()(int i) const {
    const Vector3<R> x0 = motions.x0[i].xyz(), d = motions.moved[i].xyz();
    if (!same(d, p.displacement_from(i, x0, motions.origin))) p.set_displacement_from(i, x0, motions.origin, d);
  }
};

/// Number of particles that leave their bounds, of those that leave a share of these, and of those that would leave
/// them if they were truncated.
struct BoundsViolations {
  double outside = 0, tight = 0, outside_if_truncated = 0;
  KERNEL BoundsViolations& operator+=(const BoundsViolations& o) {
    outside += o.outside, tight += o.tight, outside_if_truncated += o.outside_if_truncated;
    return *this;
  }
};

/// The path of a particle, from where it was at the broad phase. Its swept bounds are the points within a margin of it.
template <class S>
struct SweptPath {
  Vector3<S> way;
  S length2;
  KERNEL explicit SweptPath(const Vector3<S>& whole) : way(whole), length2(dot(whole, whole)) {}
  /// The point of the path that is nearest to a.
  KERNEL Vector3<S> nearest(const Vector3<S>& a) const {
    const S along = dot(a, way), zero = S(0), one = S(1);
    return way * select(along > zero, select(along < length2, along / length2, one), zero);
  }
  KERNEL S distance2(const Vector3<S>& a) const {
    const Vector3<S> apart = a - nearest(a);
    return dot(apart, apart);
  }
};

/// Share of a margin that rounding leaves.
template <class R>
KERNEL constexpr R within_rounding() {
  return R(0.99);
}

/// Checks the start, the end and the truncated position of each particle of a group: the start, moved by `rest_motion`.
template <class R>
struct CheckSweptBounds {
  static constexpr int kGroup = 64;  // particles
  Trajectories<R> motions;
  SweptBounds<R> bounds;
  R share;  // of the margin
  const unsigned char* takes_part;
  Vector3<R> rest_motion;  // of truncated particles, m
  int count;
  BoundsViolations* found;  // of each group

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    constexpr int lanes = kLanes<R, typename Group::Isa>;
    const int begin = group.index * kGroup, end = min(begin + kGroup, count);
    BoundsViolations all;
    int i = begin;
    for (; i + lanes <= end; i += lanes) check<Lane<R, typename Group::Isa>, lanes>(i, all);
    for (; i < end; ++i) check<R, 1>(i, all);
    found[group.index] = all;
  }

 private:
  template <class S, int lanes>
  KERNEL void check(int i, BoundsViolations& all) const {
    int index[lanes];
    unsigned counts = 0;
    for (int l = 0; l < lanes; ++l)
      index[l] = kIndexScale<R> * (i + l), counts |= (takes_part[i + l] != 0 ? 1u : 0u) << l;
    Vector3<S> x0, d, from, way;
    S margin, unused;
    gather_rows(motions.x0, index, x0, unused), gather_rows(motions.moved, index, d, unused);
    gather_rows(bounds.from, index, from, margin), gather_rows(bounds.way, index, way, unused);
    counts &= movemask((d.x + d.y + d.z) * S(R(0)) == S(R(0)));
    const SweptPath<S> path(way);
    const Vector3<S> start = x0 - from, rest{S(rest_motion.x), S(rest_motion.y), S(rest_motion.z)};
    const S at_start = path.distance2(start), at_end = path.distance2(start + d), held = path.distance2(start + rest);
    const auto violations = [&](unsigned inside) KERNEL_LAMBDA { return double(count_bits(counts & ~inside)); };
    const S whole = margin * S(within_rounding<R>()), tight = margin * S(share);
    const S whole2 = whole * whole, tight2 = tight * tight;
    all +=
        {violations(movemask(at_start <= whole2) & movemask(at_end <= whole2)),
         violations(movemask(at_start <= tight2) & movemask(at_end <= tight2)), violations(movemask(held <= whole2))};
  }
};

/// The violations of a group.
struct ReadViolations {
  const BoundsViolations* found;
  KERNEL BoundsViolations operator()(int g) const { return found[g]; }
};

/// Clamps a particle to its swept bounds.
template <class R>
struct ClampToSweptBounds {
  Trajectories<R> motions;
  SweptBounds<R> bounds;
  Displaced<R> p;
  const unsigned char* takes_part;
  KERNEL void operator()(int i) const {
    const Vector3<R> d = motions.moved[i].xyz();
    if (!takes_part[i] || !(motions.moved[i].w > R(0)) || !((d.x + d.y + d.z) * R(0) == R(0))) return;
    const Vector3<R> to = motions.x0[i].xyz() - bounds.from[i].xyz() + d;
    const Vector3<R> on_path = SweptPath<R>(bounds.way[i].xyz()).nearest(to), apart = to - on_path;
    const R margin = within_rounding<R>() * within_rounding<R>() * bounds.from[i].w;
    if (dot(apart, apart) <= margin * margin) return;
    p.add_displacement(i, on_path + apart * (margin / sqrt(dot(apart, apart))) - to);
    motions.moved[i].set(p.displacement_from(i, motions.x0[i].xyz(), motions.origin));
  }
};

/// Parameters of the swept bounds.
template <class R>
struct BroadPhaseParams {
  R slack;         // m, margin around every path
  R swerve;        // of the length of a substep's path, added to the margin
  R far;           // m, longest path that is swept, but at least that of a substep
  R min_distance;  // m: half of the thickness
};

/// Sweeps for a broad phase that serves several substeps.
template <class R>
struct InitSweptBounds {
  Trajectories<R> motions;
  Vector3<R> rest_motion;  // of truncated particles, m, which stay in the bounds
  R ahead;                 // substeps, at most
  BroadPhaseParams<R> rules;
  SweptBounds<R> bounds;
  KERNEL void operator()(int i) const {
    const Vector3<R> x0 = motions.x0[i].xyz();
    Vector3<R> d = motions.moved[i].xyz();
    d = or_zero((d.x + d.y + d.z) * R(0) == R(0), d);
    const R length = sqrt(dot(d, d)), fits = rules.far / length;  // infinite for length 0
    const R substeps = fits < ahead ? max(fits, R(1)) : ahead;
    const Vector3<R> way = d * substeps;
    bounds.way[i] = {way.x, way.y, way.z, R(0)};
    const R beside = sqrt(SweptPath<R>(way).distance2(rest_motion));
    bounds.from[i] = {x0.x, x0.y, x0.z, rules.slack + rules.swerve * length + beside};
  }
};

/// Swept boxes, wider by min_distance, relative to the first particle.
template <class R>
struct ComputeSweptAabbs {
  SweptBounds<R> bounds;
  R min_distance;
  Box<R>* boxes;
  KERNEL void operator()(int i) const {
    const Vector3<R> a = bounds.from[i].xyz() - bounds.from[0].xyz(), b = a + bounds.way[i].xyz();
    const R m = bounds.from[i].w + min_distance;
    boxes[i] = {{min(a.x, b.x) - m, min(a.y, b.y) - m, min(a.z, b.z) - m, R(0)},
                {max(a.x, b.x) + m, max(a.y, b.y) + m, max(a.z, b.z) + m, R(0)}};
  }
};

}  // namespace malha
