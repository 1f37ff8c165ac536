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

/// Number of particles that leave their bounds, and of those that would leave them if they were truncated.
struct BoundsViolations {
  double outside = 0, outside_if_truncated = 0;
  KERNEL BoundsViolations& operator+=(const BoundsViolations& o) {
    outside += o.outside, outside_if_truncated += o.outside_if_truncated;
    return *this;
  }
};

/// Swept bounds of a particle, relative to where it was at the broad phase: the points within a margin of its path.
template <class R>
struct Capsule {
  Vector3<R> way;
  R length2, margin;
  /// `share`: of the margin around the path.
  KERNEL Capsule(const SweptBounds<R>& bounds, int i, R share)
      : way(bounds.way[i].xyz()), length2(dot(way, way)), margin(share * bounds.from[i].w) {}
  /// The point of the path that is nearest to a.
  KERNEL Vector3<R> on_path(const Vector3<R>& a) const {
    const R along = dot(a, way);
    return way * (along > R(0) ? along < length2 ? along / length2 : R(1) : R(0));
  }
  KERNEL bool contains(const Vector3<R>& a) const {
    const Vector3<R> apart = a - on_path(a);
    return dot(apart, apart) <= margin * margin;
  }
  KERNEL Vector3<R> clamp(const Vector3<R>& a) const {
    if (contains(a)) return a;
    const Vector3<R> on = on_path(a), apart = a - on;
    return on + apart * (margin / sqrt(dot(apart, apart)));
  }
};

/// Share of a margin that rounding leaves.
template <class R>
KERNEL constexpr R within_rounding() {
  return R(0.99);
}

/// Checks the start, the end and the truncated position of a particle: the start, moved by `rest_motion`.
template <class R>
struct CheckSweptBounds {
  Trajectories<R> motions;
  SweptBounds<R> bounds;
  R share;  // of the margin
  const unsigned char* takes_part;
  Vector3<R> rest_motion{R(0), R(0), R(0)};  // motion of truncated particles, m
  KERNEL BoundsViolations operator()(int i) const {
    const Vector3<R> d = motions.moved[i].xyz();
    if (!takes_part[i] || !((d.x + d.y + d.z) * R(0) == R(0))) return {};
    const Vector3<R> start = motions.x0[i].xyz() - bounds.from[i].xyz();
    const Capsule<R> within(bounds, i, share), whole(bounds, i, within_rounding<R>());
    return {within.contains(start) && within.contains(start + d) ? 0.0 : 1.0,
            whole.contains(start + rest_motion) ? 0.0 : 1.0};
  }
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
    const Vector3<R> kept = Capsule<R>(bounds, i, within_rounding<R>() * within_rounding<R>()).clamp(to);
    if (same(kept, to)) return;
    p.add_displacement(i, kept - to);
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
    const Vector3<R> beside = rest_motion - Capsule<R>(bounds, i, R(0)).on_path(rest_motion);
    bounds.from[i] = {x0.x, x0.y, x0.z, rules.slack + rules.swerve * length + sqrt(dot(beside, beside))};
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
