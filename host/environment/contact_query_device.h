// SPDX-License-Identifier: Apache-2.0
// Contact queries on a device: they use the octree of an environment mesh only. Particles for which that is not enough
// are left to the host, which queries Embree (find_contact.h). Both store the same records and contacts.
#pragma once
#include "host/environment/contact_query.h"
#include "kernels/environment/broad_phase.h"
#include "kernels/environment/point_triangle_batch.h"

namespace malha {

/// Sets a bit of a mask that other threads change too.
KERNEL void set_bit(unsigned long long* mask, unsigned long long bit) {
#if defined(__CUDA_ARCH__)
  atomicOr(mask, bit);
#else
  __atomic_fetch_or(mask, bit, __ATOMIC_RELAXED);
#endif
}
/// Clears a bit of a mask that other threads change too.
KERNEL void clear_bit(unsigned long long* mask, unsigned long long bit) {
#if defined(__CUDA_ARCH__)
  atomicAnd(mask, ~bit);
#else
  __atomic_fetch_and(mask, ~bit, __ATOMIC_RELAXED);
#endif
}

/// Masks of the queries at one mesh: a bit for each particle.
struct QueryMasks {
  unsigned long long* pending;             // to be queried at this mesh; cleared when answered
  const unsigned long long* left_to_host;  // left to the host at the mesh before: it may still move them, and queries
                                           // them here too; null: this is the first mesh
  const unsigned long long* single_mesh;   // to be queried at one mesh alone
  unsigned long long* lifted;              // moved at an earlier mesh, so that later meshes are queried too
};

/// Finds the particles of a group that are queried at one mesh alone, and clears `lifted`.
struct FindSingleMeshParticles {
  ActiveMask masks;
  unsigned long long *single_mesh, *lifted;
  KERNEL void operator()(int g) const {
    unsigned long long any = 0, more = 0;
    for (int q = 0; q < masks.count; ++q) {
      const unsigned long long of = masks.of(q, g);
      more |= any & of, any |= of;
    }
    single_mesh[g] = any & ~more, lifted[g] = 0;
  }
};

/// Allocates entries for groups with a particle that will be queried and may be near.
template <class R>
struct AllocateEntries : ContactQuery<R> {
  QueryMasks bits;
  AllocateEntries(const ContactQuery<R>& query, const QueryMasks& of) : ContactQuery<R>(query), bits(of) {}

  KERNEL void operator()(int g) const {
    if (this->cache.entry_index[g] >= 0) return;
    unsigned long long rest = (bits.pending[g] | bits.lifted[g]) & ~(bits.left_to_host ? bits.left_to_host[g] : 0);
    bool near = false;
    typename ContactQuery<R>::Query query;
    for (; rest != 0 && !near; rest &= rest - 1) {
      const int i = g * kGroupSize + lowest_bit(rest);
      near = this->particles.w[i] > R(0) && this->may_be_near(i, query);
    }
    if (near) this->cache.allocate_entries(g, this->particles, this->before);
  }
};

/// Answers the queries of particles by the octree of a mesh, where that is enough.
template <class R>
struct QueryOctree : ContactQuery<R> {
  using Query = typename ContactQuery<R>::Query;
  QueryMasks bits;
  double max_lift;  // m: limit of depenetration here; beyond it another mesh may be near

  QueryOctree(const ContactQuery<R>& query, const QueryMasks& of, double max)
      : ContactQuery<R>(query), bits(of), max_lift(max) {}

  KERNEL void operator()(int i) const {
    const int g = i / kGroupSize;
    const unsigned long long bit = bit_of(i);
    const bool pending = bits.pending[g] & bit;
    if (bits.left_to_host && bits.left_to_host[g] & bit) return pending ? void() : set_bit(bits.pending + g, bit);
    if (!pending && !(bits.lifted[g] & bit)) return;
    const bool is_answered = !(this->particles.w[i] > R(0)) || answer_by_octree(i);
    if (is_answered && pending) clear_bit(bits.pending + g, bit);
    if (!is_answered && !pending) set_bit(bits.pending + g, bit);
  }

  // The tools of a query without Embree (ContactQuery::answer).
  KERNEL bool find_lower_bound(const Query& query, double& bound) const {
    bound = this->surface.known_lower_bound(query.a);
    return bound >= 0;
  }
  KERNEL bool search_mesh(const Query&, ClosestPoint&) const { return false; }
  KERNEL bool find_side(const Query& query, const ClosestPoint& near, Point& outward) const {
    outward = this->towards(near, query.a);
    return !this->may_have_changed_side(query);
  }
  /// Depenetration must be unobstructed, and end before other meshes are near.
  KERNEL bool can_finish(const Query& query, const ClosestPointRecord& last) const {
    const double lift = this->required_distance(last) - last.distance;
    if (lift > 0 && (!is_near_this_mesh_alone(query.i) || lift > max_lift || !this->is_unobstructed(last)))
      return false;
    return !this->needs_sweep(query, last.distance);
  }
  KERNEL bool depenetrate(const Query& query, const Point&, const Point& n, ClosestPointRecord& last) const {
    set_bit(bits.lifted + query.i / kGroupSize, bit_of(query.i));
    this->shift(query, this->outward_shift(n, last), n, last);
    return true;
  }
  KERNEL void sweep(int, const Point&) const {}

 private:
  KERNEL static unsigned long long bit_of(int i) { return 1ull << i % kGroupSize; }
  KERNEL bool is_near_this_mesh_alone(int i) const {
    return bits.single_mesh[i / kGroupSize] & ~bits.lifted[i / kGroupSize] & bit_of(i);
  }

  /// Answers a query, or returns false: it is left to the host.
  KERNEL bool answer_by_octree(int i) const {
    Query query;
    if (!this->begin_query(i, query)) return true;
    LeafQuery<OneLane> list(this->surface.cells);
    const ClosestFeature* const cached = this->cached_feature(query);
    if (!cached) {
      query.leaf = this->surface.leaf_of(query.a);
      list.add(this->surface.relative_to_centre(query.a), query.leaf);
      list.measure();
      query.near = list.nearest(0);
    }
    return this->answer(query, cached, *this, [&](double wall, double error) KERNEL_LAMBDA {
      return list.validity_radius(0, query.near, wall, error);
    });
  }
};

}  // namespace malha
