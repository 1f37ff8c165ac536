// SPDX-License-Identifier: Apache-2.0
// Swept bounds of particles: their motion beside the common one, and whether they stay in the boxes of the last search.
#pragma once
#include "kernels/geometry/simplex.h"
#include "kernels/self_collision/contact_block.h"
#include "kernels/self_collision/swept_distance.h"

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

/// p = x0 + moved, of those that pushes moved.
template <class R>
struct ApplyDisplacements {
  Trajectories<R> motions;
  Displaced<R> p;
  KERNEL void operator()(int i) const {
    const Vector3<R> x0 = motions.x0[i].xyz(), d = motions.moved[i].xyz();
    if (!same(d, p.displacement_from(i, x0, motions.origin))) p.set_displacement_from(i, x0, motions.origin, d);
  }
};

/// The frame in which boxes stand: how far it went from the search to the start of the substep, and goes in it, m.
template <class R>
struct CommonFrame {
  Vector3<R> since, moves;
};

/// Of all particles: how many leave their boxes, or would if they were held.
struct BoundsViolations {
  double outside = 0, unheld = 0;
  KERNEL BoundsViolations& operator+=(const BoundsViolations& o) {
    outside += o.outside, unheld += o.unheld;
    return *this;
  }
};

/// Where a search looked, about where a particle was.
template <class R>
struct BoxAround {
  Vector3<R> low, high;
  /// With this share of what lies beyond the way.
  KERNEL BoxAround(const SweptBounds<R>& reach, int i, R share) {
    const R beyond = share * reach.from[i].w;
    const Vector3<R> way = reach.way[i].xyz();
    low = {min(way.x, R(0)) - beyond, min(way.y, R(0)) - beyond, min(way.z, R(0)) - beyond};
    high = {max(way.x, R(0)) + beyond, max(way.y, R(0)) + beyond, max(way.z, R(0)) + beyond};
  }
  KERNEL bool holds(const Vector3<R>& a) const {
    return a.x >= low.x && a.x <= high.x && a.y >= low.y && a.y <= high.y && a.z >= low.z && a.z <= high.z;
  }
};

/// Of what lies beyond a way: what rounding leaves.
template <class R>
KERNEL constexpr R within_rounding() {
  return R(0.99);
}

/// Start, end and the place where it may be held: the start, moved as what is held.
template <class R>
struct CheckSweptBounds {
  Trajectories<R> motions;
  SweptBounds<R> reach;
  CommonFrame<R> frame;
  const Vector3<R>* moves;  // of the frame, where a launch has left it; null: as it says
  R share;                  // of what lies beyond the way
  const unsigned char* takes_part;
  Vector3<R> rest{R(0), R(0), R(0)};  // motion of what is held, m
  KERNEL BoundsViolations operator()(int i) const {
    const Vector3<R> common = moves != nullptr ? *moves : frame.moves, own = motions.moved[i].xyz() - common;
    if (!takes_part[i] || !((own.x + own.y + own.z) * R(0) == R(0))) return {};
    const Vector3<R> start = motions.x0[i].xyz() - reach.from[i].xyz() - frame.since;
    const BoxAround<R> box(reach, i, share), whole(reach, i, within_rounding<R>());
    return {box.holds(start) && box.holds(start + own) ? 0.0 : 1.0, whole.holds(start - (common - rest)) ? 0.0 : 1.0};
  }
};

/// Puts a particle that left its box back into it.
template <class R>
struct ClampToSweptBounds {
  Trajectories<R> motions;
  SweptBounds<R> reach;
  CommonFrame<R> frame;
  Displaced<R> p;
  const unsigned char* takes_part;
  KERNEL void operator()(int i) const {
    const Vector3<R> d = motions.moved[i].xyz();
    if (!takes_part[i] || !(motions.moved[i].w > R(0)) || !((d.x + d.y + d.z) * R(0) == R(0))) return;
    const Vector3<R> start = motions.x0[i].xyz() - reach.from[i].xyz() - frame.since, to = start + d - frame.moves;
    const BoxAround<R> box(reach, i, within_rounding<R>() * within_rounding<R>());
    const Vector3<R> kept{within(to.x, box.low.x, box.high.x), within(to.y, box.low.y, box.high.y),
                          within(to.z, box.low.z, box.high.z)};
    if (same(kept, to)) return;
    p.add_displacement(i, kept - to);
    motions.moved[i].set(p.displacement_from(i, motions.x0[i].xyz(), motions.origin));
  }

 private:
  KERNEL static R within(R a, R low, R high) { return a < low ? low : a > high ? high : a; }
};

/// What decides how far a search looks.
template <class R>
struct BroadPhaseParams {
  R slack;         // m, beyond every way
  R swerve;        // and as much of a substep's way
  R far;           // along a way as far as this, m, but at least a substep's
  R min_distance;  // m: half of the thickness
};

/// What a search that shall serve some substeps starts from.
template <class R>
struct InitSweptBounds {
  Trajectories<R> motions;
  Vector3<R> common;  // of the substep's motion, m
  R ahead;            // substeps, at most
  BroadPhaseParams<R> rules;
  SweptBounds<R> reach;
  KERNEL void operator()(int i) const {
    const Vector3<R> x0 = motions.x0[i].xyz();
    Vector3<R> own = motions.moved[i].xyz() - common;
    own = or_zero((own.x + own.y + own.z) * R(0) == R(0), own);
    const R length = sqrt(dot(own, own)), fits = rules.far / length;  // of no length: as far as may be
    const R substeps = fits < ahead ? max(fits, R(1)) : ahead;
    const Vector3<R> way = own * substeps;
    reach.from[i] = {x0.x, x0.y, x0.z, rules.slack + rules.swerve * length};
    reach.way[i] = {way.x, way.y, way.z, R(0)};
  }
};

/// Their boxes, by `wanted` wider, from an origin near all.
template <class R>
struct ComputeSweptAabbs {
  SweptBounds<R> reach;
  R min_distance;
  Box<R>* boxes;
  KERNEL void operator()(int i) const {
    const Vector3<R> a = reach.from[i].xyz() - reach.from[0].xyz(), b = a + reach.way[i].xyz();
    const R m = reach.from[i].w + min_distance;
    boxes[i] = {{min(a.x, b.x) - m, min(a.y, b.y) - m, min(a.z, b.z) - m, R(0)},
                {max(a.x, b.x) + m, max(a.y, b.y) + m, max(a.z, b.z) + m, R(0)}};
  }
};

/// Patches that share a particle are never worked on at once: each gets the first phase that none of those before it
/// with a particle of its own has. One item, of which one thread of a device would take longer than the way to the
/// host.
struct ColorPatches {
  using RunsOnHost = void;
  const PairPatch* patches;
  const int* touched;
  int count;
  unsigned long long* taken;  // of each particle, phases; 0 before and after
  int* phase;                 // of each patch; without pairs: below 0
  KERNEL void operator()(int) const {
    for (int u = 0; u < count; ++u) phase[u] = patches[u].pairs > 0 ? kNone : -1;
    bool left = true;
    for (int base = 0; left; base += 64) {
      left = false;
      for (int u = 0; u < count; ++u) {
        if (phase[u] != kNone) continue;
        const int* const of = touched + patches[u].touched;
        unsigned long long used = 0;
        for (int k = 0; k < patches[u].touches; ++k) used |= taken[of[k]];
        if (~used == 0) {
          left = true;
          continue;
        }
        const int bit = lowest_bit(~used);
        for (int k = 0; k < patches[u].touches; ++k) taken[of[k]] |= 1ull << bit;
        phase[u] = base + bit;
      }
      for (int u = 0; u < count; ++u)
        for (int k = 0; phase[u] >= 0 && k < patches[u].touches; ++k) taken[touched[patches[u].touched + k]] = 0;
    }
  }

 private:
  static constexpr int kNone = 1 << 30;
};

}  // namespace malha
