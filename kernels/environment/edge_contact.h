// SPDX-License-Identifier: Apache-2.0
// Contact of a deformable body with an edge or a corner of the environment: a particle and a triangle, or two edges,
// one of them of the body; and the narrow phase, which builds it from a candidate. Self-collision has contacts of its
// own, in blocks (kernels/self_collision/contact_block.h). A contact is an inequality over four particles, C(p) =
// distance along n - min_distance >= 0, with n and weights at x0, where nothing intersects, or, for pairs that slide
// far, at the end of the motion.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/geometry/simplex.h"
#include "kernels/parallel/compute.h"
#include "kernels/self_collision/division_plane.h"

namespace malha {

template <class R>
struct EdgeContact {
  int i[4];      // the first side, then the second
  R weight[4];   // at the closest points: positive on the first side, negative on the second; their sum is 0
  Vector3<R> n;  // from the second side to the first
  R bias;        // minimum distance minus that at x0, m
  R gap;         // between the planes of normal n that separate the sides at x0, m
  R lambda;      // accumulated push times dt, kg m
  Vector3<R> friction_impulse;  // accumulated friction times dt, kg m, at most mu lambda
  int first;                    // particles of the first side: 1 or 2
};

/// Sets d to the motion, or to 0 where it is not finite (such a particle ends the run). Counts the particles whose
/// swept bounds may leave the boxes that the candidates were found with.
template <class R>
struct CheckCandidateBounds {
  ScatteredPoints<R> moved, x0, d, x_then, d_then;  // the last two: at the search
  R slack;                                          // margin of those boxes, m
  KERNEL Sum operator()(int i) const {
    Vector3<R> motion = moved[i];
    motion = or_zero((motion.x + motion.y + motion.z) * R(0) == R(0), motion);
    d.set(i, motion);
    const Vector3<R> from = x0[i] - x_then[i], then = d_then[i];
    return {is_inside(from.x, motion.x, then.x) && is_inside(from.y, motion.y, then.y) &&
                    is_inside(from.z, motion.z, then.z)
                ? 0.0
                : 1.0};
  }

 private:
  KERNEL bool is_inside(R from, R motion, R then) const {
    const R low = from + min(motion, R(0)), high = from + max(motion, R(0));
    return low >= min(then, R(0)) - slack && high <= max(then, R(0)) + slack;
  }
};

/// Starts a search for candidates that serves several substeps.
template <class R>
struct InitCandidateSearch {
  ScatteredPoints<R> x0, d, x_then, d_then;
  R ahead;  // substeps
  KERNEL void operator()(int i) const {
    x_then.set(i, x0[i]);
    d_then.set(i, d[i] * ahead);
  }
};

/// Parameters of contacts from candidates.
template <class R>
struct CandidateContactParams {
  R thickness;  // m
  R recovery;   // share of a violation of the minimum distance that is recovered in a substep
};

/// Narrow phase of one candidate: whether it is a contact, and its geometry. In double: if a pair is apart by a
/// thousandth of its size, a normal from differences in float is so oblique that the pair could creep through its
/// planes.
template <class R>
struct EvaluateCandidate {
  const Candidate* candidates;
  ParticleBounds<R> bounds;
  CandidateContactParams<R> rules;

  KERNEL bool operator()(const Candidate& c, EdgeContact<R>& contact) const {
    contact.first = c.are_edges() ? 2 : 1;
    for (int j = 0; j < 4; ++j) contact.i[j] = c.particle(j);
    contact.friction_impulse = {R(0), R(0), R(0)}, contact.lambda = R(0);
    Vector3<double> x[4], motion[4];
    for (int j = 0; j < 4; ++j) x[j] = in_double(bounds.x[contact.i[j]]), motion[j] = in_double(bounds.d[contact.i[j]]);
    ContactFrameDouble<R> frame(x, contact.first);
    if (!(frame.distance > R(0))) return false;  // they touch: the direction is undefined

    // No particle leaves its swept bounds, so that the sides come no nearer than this.
    R nearing = R(0), receding = R(0);
    const Vector3<R> n = frame.n;
    for (int j = 0; j < 4; ++j) {
      const Vector3<R> d = bounds.d[contact.i[j]];
      if (j < contact.first)
        nearing = max(nearing, positive(-n.x * d.x) + positive(-n.y * d.y) + positive(-n.z * d.z));
      else
        receding = max(receding, positive(n.x * d.x) + positive(n.y * d.y) + positive(n.z * d.z));
    }
    const R margin = bounds.margin *
                     (positive(n.x) + positive(-n.x) + positive(n.y) + positive(-n.y) + positive(n.z) + positive(-n.z));
    if (frame.distance - nearing - receding > max(rules.thickness, R(2) * margin)) return false;

    R min_distance = rules.thickness;
    for (int j = 0; j < 4; ++j) min_distance = min(min_distance, bounds.x.of[contact.i[j]].w);
    if (slides_past(contact, frame, min_distance)) frame.turn(motion, min_distance);
    contact.n = frame.n, contact.gap = frame.gap;
    for (int j = 0; j < 4; ++j) contact.weight[j] = frame.w[j];
    const R missing = min_distance - frame.distance;
    contact.bias = missing > R(0) ? rules.recovery * missing : missing;
    return true;
  }

  /// Returns true if the swept boxes of the sides overlap.
  KERNEL bool boxes_overlap(const Candidate& c) const {
    const Box<R>* const of = bounds.boxes;
    const Box<R> first = of[c.particle(0)], second = of[c.i[1]], others = merge(of[c.i[2]], of[c.i[3]]);
    return c.are_edges() ? overlap(merge(first, second), others) : overlap(first, merge(others, second));
  }

 private:
  /// Returns true if the plane would stop a particle that slides past a boundary or a corner, where n is oblique: over
  /// a slide t the distance grows by t^2 / (2 distance) beyond that along n.
  KERNEL bool slides_past(const EdgeContact<R>& contact, const ContactFrameDouble<R>& frame, R min_distance) const {
    const R* const weight = frame.w;
    if (weight[0] != R(0) && weight[1] != R(0) && weight[2] != R(0) && weight[3] != R(0)) return false;
    Vector3<R> motion{R(0), R(0), R(0)};
    for (int j = 0; j < 4; ++j) motion = motion + bounds.d[contact.i[j]] * weight[j];
    const R distance = frame.distance, along = dot(frame.n, motion), violation = min_distance - distance - along;
    const Vector3<R> slide = motion - frame.n * along;
    // The growth is at least a tenth of the violation, and the slide so long that jitter at rest does not count.
    return violation > R(0) && dot(slide, slide) > R(0.1) * distance * max(violation, R(0.1) * distance);
  }

  KERNEL static R positive(R a) { return max(a, R(0)); }
};

/// Stores 1 for candidates whose swept boxes overlap.
template <class R>
struct CountOverlappingCandidates {
  EvaluateCandidate<R> evaluate;
  int* flags;
  KERNEL void operator()(int c) const { flags[c] = evaluate.boxes_overlap(evaluate.candidates[c]) ? 1 : 0; }
};

}  // namespace malha
