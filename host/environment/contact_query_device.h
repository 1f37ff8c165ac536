// SPDX-License-Identifier: Apache-2.0
// On a device: of the particles that may touch an environment mesh, those are answered that need no more than the
// mesh's lists. The others are left to the host, which asks Embree (find_contact.h). Both leave the same.
#pragma once
#include "host/environment/contact_query.h"
#include "kernels/environment/broad_phase.h"

namespace malha {

/// A word that other threads change, too, has the bit.
KERNEL void set_bit(unsigned long long* word, unsigned long long bit) {
#if defined(__CUDA_ARCH__)
  atomicOr(word, bit);
#else
  __atomic_fetch_or(word, bit, __ATOMIC_RELAXED);
#endif
}
KERNEL void clear_bit(unsigned long long* word, unsigned long long bit) {
#if defined(__CUDA_ARCH__)
  atomicAnd(word, ~bit);
#else
  __atomic_fetch_and(word, ~bit, __ATOMIC_RELAXED);
#endif
}

/// A bit for each particle, a word for each kGroupSize of them.
struct QueryMasks {
  unsigned long long* asked;       // about at this mesh; answered: no longer
  const unsigned long long* left;  // not answered at the mesh before: the host may still move them, and goes on with
                                   // them here; null: this is the first
  const unsigned long long* once;  // asked about at one mesh alone
  unsigned long long* lifted;      // on the way, so that later meshes are asked, too
};

/// Of a word: which of its particles one mesh alone asks about. No other is lifted yet.
struct FindSingleMeshParticles {
  ActiveMask questions;
  unsigned long long *once, *lifted;
  KERNEL void operator()(int word) const {
    unsigned long long any = 0, more = 0;
    for (int q = 0; q < questions.count; ++q) {
      const unsigned long long of = questions.of(q, word);
      more |= any & of, any |= of;
    }
    once[word] = any & ~more, lifted[word] = 0;
  }
};

/// The words of particles that are going to be answered get places of their own, where any of them comes near.
template <class R>
struct AllocateEntries : ContactQuery<R> {
  QueryMasks bits;
  AllocateEntries(const ContactQuery<R>& look, const QueryMasks& of) : ContactQuery<R>(look), bits(of) {}

  KERNEL void operator()(int word) const {
    if (this->nearby.which[word] >= 0) return;
    unsigned long long rest = (bits.asked[word] | bits.lifted[word]) & ~(bits.left ? bits.left[word] : 0);
    bool near = false;
    typename ContactQuery<R>::Query look;
    for (; rest != 0 && !near; rest &= rest - 1) {
      const int i = word * kGroupSize + lowest_bit(rest);
      near = this->particles.w[i] > R(0) && this->comes_near(i, look);
    }
    if (near) this->nearby.allocate_entries(word, this->particles, this->before);
  }
};

template <class R>
struct QueryOctree : ContactQuery<R> {
  using Query = typename ContactQuery<R>::Query;
  QueryMasks bits;
  double most_lift;  // m: no farther is a particle lifted here, near to no other mesh

  QueryOctree(const ContactQuery<R>& look, const QueryMasks& of, double most)
      : ContactQuery<R>(look), bits(of), most_lift(most) {}

  KERNEL void operator()(int i) const {
    const int word = i / kGroupSize;
    const unsigned long long bit = 1ull << i % kGroupSize;
    const bool asked = bits.asked[word] & bit;
    if (bits.left && bits.left[word] & bit) return asked ? void() : set_bit(bits.asked + word, bit);
    const bool comes_lifted = bits.lifted[word] & bit;
    if (!asked && !comes_lifted) return;
    const bool answered = !(this->particles.w[i] > R(0)) || answers(i, bits.once[word] & bit && !comes_lifted);
    if (answered && asked) clear_bit(bits.asked + word, bit);
    if (!answered && !asked) set_bit(bits.asked + word, bit);
  }

 private:
  /// `alone`: no other mesh is near.
  KERNEL bool answers(int i, bool alone) const {
    const SurfaceView& surface = this->surface;
    Query look;
    if (!this->begin(i, look)) return true;
    const ClosestFeature* const kept = this->feature_of(look);
    ClosestPoint near;
    double distance;  // as it was compared
    if (kept) {
      near = surface.of_feature(*kept, look.a), distance = near.distance;
    } else {
      look.cell = surface.cell_of(look.a, look.cell);
      if (look.cell == 0) return false;
      look.near = surface.template nearest<OneLane>(look.a, look.cell);
      if (look.near.triangle < 0) return false;
      near = surface.of_feature(surface.feature(look.near), look.a), distance = look.near.distance;
    }
    if (!(distance <= look.reach) && !(look.depth > 0)) {
      const double least = surface.known_lower_bound(look.a);
      if (least < 0) return false;  // the host finds out
      if (least > look.reach) {     // a coarse bound tells that it cannot touch
        this->record_lower_bound(look, least);
        return true;
      }
    }
    if (!(distance < look.radius))
      this->record_lower_bound(look, look.radius);
    else if (!finishes(look, near, alone))
      return false;
    if (!kept)
      this->keep_feature(look,
                         [&](double wall, double error) KERNEL_LAMBDA { return holds_within(look, wall, error); });
    return true;
  }

  KERNEL bool finishes(const Query& look, const ClosestPoint& near, bool alone) const {
    if (asks_the_side(look)) return false;
    const Point outward = this->towards(near, look.a);
    if (asks_more(look, near, this->signed_distance(near, look.a, outward), alone)) return false;
    const auto lift = [this](const Query& of, const Point&, const Point& n, ClosestPointRecord& last) KERNEL_LAMBDA {
      set_bit(bits.lifted + of.i / kGroupSize, 1ull << of.i % kGroupSize);
      this->shift(of, this->shift_out(n, last), n, last);
      return true;
    };
    this->finish(look, near, outward, lift, [](int, const Point&) KERNEL_LAMBDA {});
    return true;
  }

  /// As PointTriangleBatch::holds_within: one triangle of the list after the other.
  KERNEL double holds_within(const Query& look, double wall, double error) const {
    const OctreeView& mesh = this->surface.cells;
    const OctreeNode& cell = mesh.cells[look.cell];
    const Point p = this->surface.relative_to_centre(look.a);
    const FeatureValidityRadius holds(mesh, p, look.near, error);
    double radius = wall - error;
    for (int k = cell.first; k < cell.first + cell.count && radius > 0; ++k) {
      const Point q = nearest_of_listed(mesh, p, mesh.lists + k, 1).q, d = p - q;
      const double margin = holds.of(mesh.lists[k], q, dot(d, d), radius);
      if (!(margin >= radius)) radius = margin > 0 ? margin : -1;
    }
    return radius;
  }

  /// Whether it may have been dragged through.
  KERNEL bool asks_the_side(const Query& look) const {
    return this->sides == Sides::TwoSided && look.last.distance > -INFINITY && look.last.distance < INFINITY &&
           look.moved >= look.last.distance;
  }
  /// Whether the rim, or a way that goes far, is to be looked at: what finish() would do where it is not.
  KERNEL bool asks_more(const Query& look, const ClosestPoint& near, double distance, bool alone) const {
    if (distance > look.reach || (distance < 0 && near.boundary)) return false;
    const ClosestPointRecord last{look.a, distance, near.triangle, {}, this->overlap_of(look, distance)};
    const double lift = this->least_distance(last) - distance;
    return (lift > 0 && (!alone || lift > most_lift || !this->is_free(last))) || this->goes_far(look, distance);
  }
};

}  // namespace malha
