// SPDX-License-Identifier: Apache-2.0
// Contact queries on a device: they use the octree of an environment mesh only. Particles for which that is not enough
// are left to the host, which queries Embree (find_contact.h). Both store the same records and contacts.
#pragma once
#include "host/environment/contact_query.h"
#include "kernels/environment/broad_phase.h"

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
    const unsigned long long bit = 1ull << i % kGroupSize;
    const bool pending = bits.pending[g] & bit;
    if (bits.left_to_host && bits.left_to_host[g] & bit) return pending ? void() : set_bit(bits.pending + g, bit);
    const bool comes_lifted = bits.lifted[g] & bit;
    if (!pending && !comes_lifted) return;
    const bool is_answered = !(this->particles.w[i] > R(0)) || answer(i, bits.single_mesh[g] & bit && !comes_lifted);
    if (is_answered && pending) clear_bit(bits.pending + g, bit);
    if (!is_answered && !pending) set_bit(bits.pending + g, bit);
  }

 private:
  /// Answers a query, or returns false: it is left to the host. `alone`: no other mesh is near.
  KERNEL bool answer(int i, bool alone) const {
    const SurfaceView& surface = this->surface;
    Query query;
    if (!this->begin_query(i, query)) return true;
    const ClosestFeature* const cached = this->cached_feature(query);
    ClosestPoint near;
    double distance;  // as the search compared it
    if (cached) {
      near = surface.closest_point_on(*cached, query.a), distance = near.distance;
    } else {
      query.cell = surface.cell_of(query.a);
      if (query.cell == 0) return false;
      query.near = surface.template nearest<OneLane>(query.a, query.cell);
      if (query.near.triangle < 0) return false;
      near = surface.closest_point_on(surface.feature(query.near), query.a), distance = query.near.distance;
    }
    if (!(distance <= query.contact_range) && !(query.depth > 0)) {
      const double least = surface.known_lower_bound(query.a);
      if (least < 0) return false;        // the host computes one
      if (least > query.contact_range) {  // a coarse bound rules out contact
        this->record_lower_bound(query, least);
        return true;
      }
    }
    if (!(distance < query.radius))
      this->record_lower_bound(query, query.radius);
    else if (!finish_here(query, near, alone))
      return false;
    if (!cached)
      this->cache_feature(query,
                          [&](double wall, double error) KERNEL_LAMBDA { return validity_radius(query, wall, error); });
    return true;
  }

  KERNEL bool finish_here(const Query& query, const ClosestPoint& near, bool alone) const {
    if (needs_side_test(query)) return false;
    const Point outward = this->towards(near, query.a);
    if (needs_host(query, near, this->signed_distance(near, query.a, outward), alone)) return false;
    const auto lift = [this](const Query& of, const Point&, const Point& n, ClosestPointRecord& last) KERNEL_LAMBDA {
      set_bit(bits.lifted + of.i / kGroupSize, 1ull << of.i % kGroupSize);
      this->shift(of, this->outward_shift(n, last), n, last);
      return true;
    };
    this->finish(query, near, outward, lift, [](int, const Point&) KERNEL_LAMBDA {});
    return true;
  }

  /// Computes PointTriangleBatch::validity_radius: one triangle of the list after the other.
  KERNEL double validity_radius(const Query& query, double wall, double error) const {
    const OctreeView& mesh = this->surface.cells;
    const OctreeNode& cell = mesh.cells[query.cell];
    const Point p = this->surface.relative_to_centre(query.a);
    const FeatureValidityRadius validity(mesh, p, query.near, error);
    double radius = wall - error;
    for (int k = cell.first; k < cell.first + cell.count && radius > 0; ++k) {
      const Point q = closest_points_on(mesh, p, mesh.lists + k, 1).q, d = p - q;
      const double margin = validity.radius_for(mesh.lists[k], q, dot(d, d), radius);
      if (!(margin >= radius)) radius = margin > 0 ? margin : -1;
    }
    return radius;
  }

  /// Returns true if the particle may have been dragged through a two-sided sheet.
  KERNEL bool needs_side_test(const Query& query) const {
    return this->sides == Sides::TwoSided && query.last.distance > -INFINITY && query.last.distance < INFINITY &&
           query.moved >= query.last.distance;
  }
  /// Returns true if finish() would need what only the host can do: an obstructed depenetration, or a sweep.
  KERNEL bool needs_host(const Query& query, const ClosestPoint& near, double distance, bool alone) const {
    if (distance > query.contact_range || (distance < 0 && near.boundary)) return false;
    const ClosestPointRecord last{query.a, distance, near.triangle, {}, this->allowed_overlap(query, distance)};
    const double lift = this->required_distance(last) - distance;
    return (lift > 0 && (!alone || lift > max_lift || !this->is_unobstructed(last))) ||
           this->needs_sweep(query, distance);
  }
};

}  // namespace malha
