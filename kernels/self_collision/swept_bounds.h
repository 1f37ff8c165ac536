// SPDX-License-Identifier: Apache-2.0
// Swept bounds of particles: boxes around their motion relative to the common (mean) one, and checks that particles
// stay in the boxes of the last broad phase.
#pragma once
#include "kernels/geometry/simplex.h"
#include "kernels/parallel/compute.h"
#include "kernels/self_collision/contact_block.h"
#include "kernels/self_collision/swept_distance.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Weighted mean of motions.
struct MeanMotion {
  double sum[3] = {}, weight = 0;
  KERNEL MeanMotion& operator+=(const MeanMotion& o) {
    for (int k = 0; k < 3; ++k) sum[k] += o.sum[k];
    weight += o.weight;
    return *this;
  }
  /// The mean; 0 without any motion.
  KERNEL Vector3<double> value() const {
    const double per = weight > 0 ? 1 / weight : 0;
    return {sum[0] * per, sum[1] * per, sum[2] * per};
  }
};

/// Sums the finite motions of particles that take part.
template <class R>
struct SumMotion {
  ScatteredPoints<R> moved;
  const unsigned char* takes_part;
  KERNEL MeanMotion operator()(int i) const {
    const Vector3<R> d = moved[i];
    if (!takes_part[i] || !((d.x + d.y + d.z) * R(0) == R(0))) return {};
    return {{double(d.x), double(d.y), double(d.z)}, 1.0};
  }
};

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

/// The frame in which boxes are at rest: how far it moved from the broad phase to the start of the substep, and how far
/// it moves in the substep, m.
template <class R>
struct CommonFrame {
  Vector3<R> since, moves;
};

/// Number of particles that leave their boxes, and of those that would leave them if they were truncated.
struct BoundsViolations {
  double outside = 0, outside_if_truncated = 0;
  KERNEL BoundsViolations& operator+=(const BoundsViolations& o) {
    outside += o.outside, outside_if_truncated += o.outside_if_truncated;
    return *this;
  }
};

/// Swept box of a particle, relative to where it was at the broad phase.
template <class R>
struct BoxAround {
  Vector3<R> low, high;
  /// `share`: of the margin around the path.
  KERNEL BoxAround(const SweptBounds<R>& bounds, int i, R share) {
    const R beyond = share * bounds.from[i].w;
    const Vector3<R> way = bounds.way[i].xyz();
    low = {min(way.x, R(0)) - beyond, min(way.y, R(0)) - beyond, min(way.z, R(0)) - beyond};
    high = {max(way.x, R(0)) + beyond, max(way.y, R(0)) + beyond, max(way.z, R(0)) + beyond};
  }
  KERNEL bool contains(const Vector3<R>& a) const {
    return a.x >= low.x && a.x <= high.x && a.y >= low.y && a.y <= high.y && a.z >= low.z && a.z <= high.z;
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
  CommonFrame<R> frame;
  R share;  // of the margin
  const unsigned char* takes_part;
  Vector3<R> rest_motion{R(0), R(0), R(0)};  // motion of truncated particles, m
  KERNEL BoundsViolations operator()(int i) const {
    const Vector3<R> own = motions.moved[i].xyz() - frame.moves;
    if (!takes_part[i] || !((own.x + own.y + own.z) * R(0) == R(0))) return {};
    const Vector3<R> start = motions.x0[i].xyz() - bounds.from[i].xyz() - frame.since;
    const BoxAround<R> box(bounds, i, share), full(bounds, i, within_rounding<R>());
    return {box.contains(start) && box.contains(start + own) ? 0.0 : 1.0,
            full.contains(start - (frame.moves - rest_motion)) ? 0.0 : 1.0};
  }
};

/// Clamps a particle to its swept box.
template <class R>
struct ClampToSweptBounds {
  Trajectories<R> motions;
  SweptBounds<R> bounds;
  CommonFrame<R> frame;
  Displaced<R> p;
  const unsigned char* takes_part;
  KERNEL void operator()(int i) const {
    const Vector3<R> d = motions.moved[i].xyz();
    if (!takes_part[i] || !(motions.moved[i].w > R(0)) || !((d.x + d.y + d.z) * R(0) == R(0))) return;
    const Vector3<R> start = motions.x0[i].xyz() - bounds.from[i].xyz() - frame.since, to = start + d - frame.moves;
    const BoxAround<R> box(bounds, i, within_rounding<R>() * within_rounding<R>());
    const Vector3<R> kept{within(to.x, box.low.x, box.high.x), within(to.y, box.low.y, box.high.y),
                          within(to.z, box.low.z, box.high.z)};
    if (same(kept, to)) return;
    p.add_displacement(i, kept - to);
    motions.moved[i].set(p.displacement_from(i, motions.x0[i].xyz(), motions.origin));
  }

 private:
  KERNEL static R within(R a, R low, R high) { return a < low ? low : a > high ? high : a; }
};

/// Parameters of the swept boxes.
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
  Vector3<R> common;  // common motion in the substep, m
  R ahead;            // substeps, at most
  BroadPhaseParams<R> rules;
  SweptBounds<R> bounds;
  KERNEL void operator()(int i) const {
    const Vector3<R> x0 = motions.x0[i].xyz();
    Vector3<R> own = motions.moved[i].xyz() - common;
    own = or_zero((own.x + own.y + own.z) * R(0) == R(0), own);
    const R length = sqrt(dot(own, own)), fits = rules.far / length;  // infinite for length 0
    const R substeps = fits < ahead ? max(fits, R(1)) : ahead;
    const Vector3<R> way = own * substeps;
    bounds.from[i] = {x0.x, x0.y, x0.z, rules.slack + rules.swerve * length};
    bounds.way[i] = {way.x, way.y, way.z, R(0)};
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
