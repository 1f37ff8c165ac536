// SPDX-License-Identifier: Apache-2.0
// Contact detection of particles with one environment mesh on the host, with Embree: the collision constraints of a
// substep (Müller et al. 2006, section 3.4: a continuous test along the path, or the closest point of particles
// inside).
#pragma once
#include <cmath>

#include "host/environment/closest_point_index.h"
#include "host/environment/contact_query.h"
#include "kernels/environment/point_triangle_batch.h"

namespace malha {

/// The crossing of a mesh by the path of a particle from x to p in the substep, which is straight in the mesh's frame.
inline Crossing crossing(const MovingMesh& mesh, const Point& x, const Point& p) {
  return mesh.index->crossing(to_local(mesh.before, x), to_local(mesh.after, p), 0, mesh.sides != Sides::TwoSided);
}

/// View of all environment meshes of a substep, and the proximity cache of each.
template <class R>
struct EnvironmentView {
  const MovingMesh* meshes;
  int count;
  Particles<R> particles;
  const ProximityCacheView<R>* caches;

  ContactQuery<R> query(int mesh) const { return {meshes[mesh], particles, caches[mesh]}; }
};

/// Detects the contacts of the particles in a mask with one of the meshes, compiled for an instruction set. It runs in
/// passes over the particles of a group (positions and octree leaves first, then contacts) so that memory latencies
/// overlap.
template <class R>
struct FindContact : ContactQuery<R> {
  using RunsOnHost = void;
  using Base = ContactQuery<R>;
  using Query = typename Base::Query;
  using Base::surface, Base::index, Base::sides, Base::thickness, Base::before, Base::after, Base::particles,
      Base::cache;
  EnvironmentView<R> environment;
  int mesh_index;
  const unsigned long long* bits;

  FindContact(const EnvironmentView<R>& view, int mesh, const unsigned long long* mask)
      : Base(view.query(mesh)), environment(view), mesh_index(mesh), bits(mask) {}

  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    unsigned long long rest = bits[group.index];
    if (rest == 0) return;
    for (unsigned long long ahead = rest; ahead != 0; ahead &= ahead - 1) {
      const int slot = cache.slot(group.index * kGroupSize + lowest_bit(ahead));
      if (slot >= 0) prefetch(cache.near + slot, int(sizeof(ProximityRecord)));
    }
    Queries storage;
    Query* const queries = storage.of;
    int count = 0;
    for (; rest != 0; rest &= rest - 1) {
      const int i = group.index * kGroupSize + lowest_bit(rest);
      Query& query = queries[count];
      if (!(particles.w[i] > R(0)) || !this->begin_query(i, query)) continue;
      if (const ClosestFeature* const feature = this->cached_feature(query))
        this->answer(query, feature, *this, [](double, double) KERNEL_LAMBDA { return -1.0; });
      else
        ++count;
    }
    for (int k = 0; k < count; ++k) {
      queries[k].leaf = surface.leaf_of(queries[k].a);
      if (queries[k].leaf) prefetch(surface.cells.lists + queries[k].leaf->first);
    }
    for (int k = 0; k < count;) {
      PointTriangleBatch<Isa> batch(surface.cells);
      const int first = k;
      for (; k < count && batch.has_capacity(queries[k].leaf); ++k)
        batch.add(surface.relative_to_centre(queries[k].a), queries[k].leaf);
      batch.measure();
      for (int j = first; j < k; ++j) {
        queries[j].near = batch.nearest(j - first);
        surface.prefetch_normal(queries[j].near);
      }
      for (int j = first; j < k; ++j)
        this->answer(queries[j], nullptr, *this, [&](double wall, double error) KERNEL_LAMBDA {
          return batch.validity_radius(j - first, queries[j].near, wall, error);
        });
    }
  }

  // The tools of a query on the host (ContactQuery::answer), which leaves none unanswered.
  bool find_lower_bound(const Query& query, double& bound) const {
    bound = index->distance_lower_bound(query.a);
    return true;
  }
  /// Queries the whole mesh where no list answers. Lists are built for particles that are near and slow: others seldom
  /// come back.
  bool search_mesh(const Query& query, ClosestPoint& near) const {
    const bool stays = query.path < 2 * thickness;
    if (const OctreeNode* const leaf = stays && query.last.triangle >= 0 ? index->make_leaf(query.a) : nullptr) {
      LeafQuery<OneLane> list(surface.cells);
      list.add(surface.relative_to_centre(query.a), leaf);
      list.measure();
      near = surface.within(query.radius, list.nearest(0), query.a);
      return true;
    }
    near = index->closest(query.a, query.radius);
    if (stays && near.found && near.distance <= query.contact_range && query.last.triangle < 0)
      index->make_leaf(query.a);
    return true;
  }
  HOST_KERNEL bool find_side(const Query& query, const ClosestPoint& near, Point& outward) const {
    const Point& last = query.last.at;
    const bool went_through = this->may_have_changed_side(query) && index->crossing(last, query.a, 0, false).hit;
    outward = this->towards(near, went_through ? last : query.a);
    return true;
  }
  HOST_KERNEL bool can_finish(const Query&, const ClosestPointRecord&) const { return true; }
  /// Contact of a path that may pass a corner: with the first crossing, or else with the surface near its end.
  void sweep(int i, const Point& outward) const {
    const Point a = to_local(before, in_double(particles.x[i])),
                b = to_local(after, particles.p.position_without_low(i));
    const Crossing crossing = index->crossing(a, b, thickness, sides != Sides::TwoSided);
    if (crossing.hit) {
      const bool flip =
          dot(crossing.normal, b - a) > 0;  // two-sided only: the particle stays on the side that it comes from
      return this->set_contact(i, crossing.q, flip ? -crossing.normal : crossing.normal);
    }
    const ClosestPoint end = index->closest(b, std::max(2 * thickness, sides == Sides::Solid ? norm(b - a) : 0));
    if (!end.found) return;
    const Point normal = sides == Sides::TwoSided && dot(end.normal, outward) < 0 ? -end.normal : end.normal;
    const double distance = dot(normal, b - end.q) < 0 ? -end.distance : end.distance;
    if (distance < 0 && end.boundary) return;
    if (distance < 2 * thickness) this->set_contact(i, end.q, this->direction(end, b, normal, distance));
  }

  /// Moves a particle out to its required distance, unless the path crosses another mesh or another part of this one.
  /// `q`: the closest point of this mesh.
  bool depenetrate(const Query& query, const Point& q, const Point& n, ClosestPointRecord& last) const {
    if (!this->is_unobstructed(last)) {
      const Point above = q + n * (1e-3 * thickness), rim = q + n * this->required_distance(last);
      if (index->crossing(above, rim, 0, sides != Sides::TwoSided).hit) return false;
    }
    const int i = query.i;
    const Vector3<R> shift = this->outward_shift(n, last), x = particles.x[i], to = x + shift;
    for (int k = 0; k < environment.count; ++k) {
      const MovingMesh& mesh = environment.meshes[k];
      const Point start = to_local(mesh.before, in_double(x)), end = to_local(mesh.before, in_double(to));
      if (k == mesh_index || environment.caches[k].record(i, start).is_path_clear(start, end)) continue;
      if (mesh.index->crossing(start, end, 0, mesh.sides != Sides::TwoSided).hit) return false;
    }
    this->shift(query, shift, n, last);
    for (int k = 0; k < mesh_index; ++k) {  // their planes are relative to x
      Contact<R>* const other = environment.caches[k].contact(i);
      if (!other) continue;
      other->plane.w = other->plane.w - dot(other->plane.xyz(), shift);
      invalidate_cached_position(*other);
    }
    return true;
  }

 private:
  union Queries {  // left uninitialised
    Query of[kGroupSize];
    HOST_KERNEL Queries() {}
  };
};

/// Depth of a particle inside a solid, behind a one-sided sheet (but not beyond its boundary), or beyond a two-sided
/// one since its last query; and the depth at which it was forced through a surface.
template <class R>
struct MeasureDepth {
  using RunsOnHost = void;
  const ClosestPointIndex* index;
  Sides sides;
  Pose pose;
  Particles<R> particles;
  ProximityCacheView<R> cache;
  HOST_KERNEL Deepest operator()(int i) const {
    if (!(particles.w[i] > R(0))) return {};
    const Point a = to_local(pose, in_double(particles.x[i]));
    const ClosestPointRecord last = cache.record(i, a);
    return {std::max(norm(last.tunnel_offset), depth(a, last))};
  }

 private:
  double depth(const Point& a, const ClosestPointRecord& last) const {
    if (sides == Sides::Solid && index->box_distance(a) > 0) return 0;
    if (sides == Sides::TwoSided && !(std::isfinite(last.distance) && index->crossing(last.at, a, 0, false).hit))
      return 0;
    const ClosestPoint near = index->closest(a, index->diagonal());
    if (!near.found) return 0;
    if (sides == Sides::TwoSided) return near.distance;
    return !near.boundary && dot(near.normal, a - near.q) < 0 ? near.distance : 0;
  }
};

}  // namespace malha
