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

/// Allocates entries for groups with a particle that will be queried and may be near.
template <class R>
struct AllocateEntries {
  const ContactQuery<R>* meshes;
  ActiveMask active;  // of each mesh
  KERNEL void operator()(int g) const {
    typename ContactQuery<R>::Query query;
    for (int k = 0; k < active.count; ++k) {
      const ContactQuery<R>& mesh = meshes[k];
      if (mesh.cache.entry_index[g] >= 0) continue;
      bool near = false;
      for (unsigned long long rest = active.of(k, g); rest != 0 && !near; rest &= rest - 1) {
        const int i = g * kGroupSize + lowest_bit(rest);
        near = mesh.particles.w[i] > R(0) && mesh.needs_query(i, query);
      }
      if (near) mesh.cache.allocate_entries(g, mesh.particles, mesh.before);
    }
  }
};

/// The tools of a query on a device (ContactQuery::answer).
template <class R>
struct WithoutEmbree {
  using Query = typename ContactQuery<R>::Query;
  const ContactQuery<R>& mesh;
  double max_lift;  // m: limit of depenetration, beyond which other meshes may be near
  bool& lifted;     // set by depenetration

  KERNEL bool find_lower_bound(const Query& query, double& bound) const {
    bound = mesh.surface.known_lower_bound(query.a);
    return bound >= 0;
  }
  KERNEL bool search_mesh(const Query&, ClosestPoint&) const { return false; }
  KERNEL bool find_side(const Query& query, const ClosestPoint& near, Point& outward) const {
    outward = mesh.towards(near, query.a);
    return !mesh.may_have_changed_side(query);
  }
  KERNEL bool can_finish(const Query& query, const ClosestPointRecord& last) const {
    const double lift = mesh.required_distance(last) - last.distance;
    return !(lift > 0 && (lift > max_lift || !mesh.is_unobstructed(last))) && !mesh.needs_sweep(query, last.distance);
  }
  KERNEL bool depenetrate(const Query& query, const Point&, const Point& n, ClosestPointRecord& last) const {
    mesh.shift(query, mesh.outward_shift(n, last), n, last);
    return lifted = true;
  }
  KERNEL void sweep(int, const Point&) const {}
};

/// Answers the queries of a particle at all meshes by their octrees, and clears the bits of those that it answers.
/// A particle for which an octree is not enough is left to the host there and at all later meshes, since the host may
/// move it.
template <class R>
struct QueryOctrees {
  const ContactQuery<R>* meshes;
  ActiveMask active;  // of each mesh
  double max_lift;    // m: limit of the depenetration of particles that are queried at one mesh alone; others stay

  KERNEL void operator()(int i) const {
    const int g = i / kGroupSize;
    const unsigned long long bit = 1ull << i % kGroupSize;
    int queried = 0;
    for (int k = 0; k < active.count; ++k) queried += (active.of(k, g) & bit) != 0;
    if (queried == 0) return;
    bool lifted = false, left = false;
    for (int k = 0; k < active.count; ++k) {
      const bool pending = active.of(k, g) & bit;
      if (!left && pending)
        left = meshes[k].particles.w[i] > R(0) && !answer(meshes[k], i, queried == 1, lifted);
      else if (!left && lifted)
        left = came_near(meshes[k], i);
      if (left && !pending) set_bit(active.mask(k) + g, bit);
      if (!left && pending) clear_bit(active.mask(k) + g, bit);
    }
  }

 private:
  KERNEL static bool came_near(const ContactQuery<R>& mesh, int i) {
    typename ContactQuery<R>::Query query;
    return mesh.needs_query(i, query);
  }
  KERNEL bool answer(const ContactQuery<R>& mesh, int i, bool alone, bool& lifted) const {
    typename ContactQuery<R>::Query query;
    if (!mesh.begin_query(i, query)) return true;
    LeafQuery<OneLane> list(mesh.surface.cells);
    const ClosestFeature* const cached = mesh.cached_feature(query);
    if (!cached) {
      query.leaf = mesh.surface.leaf_of(query.a);
      list.add(mesh.surface.relative_to_centre(query.a), query.leaf);
      list.measure();
      query.near = list.nearest(0);
    }
    const WithoutEmbree<R> tools{mesh, alone ? max_lift : 0, lifted};
    return mesh.answer(query, cached, tools, [&](double wall, double error) KERNEL_LAMBDA {
      return list.validity_radius(0, query.near, wall, error);
    });
  }
};

}  // namespace malha
