// SPDX-License-Identifier: Apache-2.0
// Contact detection of particles with one environment mesh on the host, with Embree: the collision constraints of a
// substep (Müller et al. 2006, section 3.4: a continuous test along the path, or the closest point of particles
// inside).
#pragma once
#include <cmath>

#include "host/attachments/pose.h"
#include "host/environment/contact_query.h"
#include "host/environment/surface.h"
#include "kernels/environment/point_triangle_batch.h"

namespace malha {

/// An environment mesh in a substep.
struct MovingSurface {
  const Surface* surface;
  Sides sides;
  double thickness;    // m
  Pose before, after;  // at the substep's start and end

  /// Motion in the substep, from the world to the world.
  Pose motion() const { return before.moves ? from_to(before, after) : Pose{}; }
};

/// The crossing of a mesh by the path of a particle from x to p in the substep, which is straight in the mesh's frame.
inline Crossing crossing(const MovingSurface& mesh, const Point& x, const Point& p) {
  return mesh.surface->crossing(to_local(mesh.before, x), to_local(mesh.after, p), 0, mesh.sides != Sides::TwoSided);
}

/// View of all environment meshes of a substep, and the contact cache of each.
template <class R>
struct EnvironmentView {
  const MovingSurface* meshes;
  int count;
  Particles<R> particles;
  const ContactCacheView<R>* caches;
};

/// The contact query of one of the meshes.
template <class R>
ContactQuery<R> query_for(const EnvironmentView<R>& environment, int mesh_index) {
  const MovingSurface& mesh = environment.meshes[mesh_index];
  return {mesh.surface->view(),          mesh.sides, mesh.thickness, mesh.before, mesh.after, environment.particles,
          environment.caches[mesh_index]};
}

/// Detects the contacts of the particles in a mask with one of the meshes, compiled for an instruction set. It runs in
/// passes over the particles of a group (positions and cells first, then contacts) so that memory latencies overlap.
template <class R>
struct FindContact : ContactQuery<R> {
  using RunsOnHost = void;
  using Base = ContactQuery<R>;
  using Query = typename Base::Query;
  using Base::surface, Base::sides, Base::thickness, Base::before, Base::after, Base::particles, Base::cache;
  EnvironmentView<R> environment;
  int mesh_index;
  const Surface* mesh_surface;
  const unsigned long long* bits;

  FindContact(const EnvironmentView<R>& view, int mesh, const unsigned long long* mask)
      : Base(query_for(view, mesh)),
        environment(view),
        mesh_index(mesh),
        mesh_surface(view.meshes[mesh].surface),
        bits(mask) {}

  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
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
      if (particles.w[i] > R(0) && this->begin_query(i, queries[count]) && !answer_by_feature(queries[count])) ++count;
    }
    for (int k = 0; k < count; ++k) find_candidates(queries[k]);
    for (int k = 0; k < count;) {
      PointTriangleBatch<typename Group::Isa> batch(surface.cells);
      const int first = k;
      for (; k < count && batch.has_capacity(queries[k].candidate_count); ++k)
        batch.add(surface.relative_to_centre(queries[k].a), queries[k].candidates, queries[k].candidate_count);
      batch.measure();
      for (int j = first; j < k; ++j) {
        queries[j].near = batch.nearest(j - first);
        surface.prefetch_normal(queries[j].near);
      }
      for (int j = first; j < k; ++j) finish_query(queries[j], batch, j - first);
    }
  }

 private:
  union Queries {  // left uninitialised
    Query of[kGroupSize];
    HOST_KERNEL Queries() {}
  };

  /// Answers the query by the cached feature. Returns false if there is none that is valid.
  HOST_KERNEL bool answer_by_feature(Query& query) const {
    const ClosestFeature* const feature = this->cached_feature(query);
    if (!feature) return false;
    const ClosestPoint near = surface.closest_point_on(*feature, query.a);
    if (near.distance <= query.contact_range || !rule_out_by_grid(query))
      finish_query(query, near.distance < query.radius ? near : ClosestPoint{});
    return true;
  }

  /// Sets the candidate triangles of the octree cell of the query.
  HOST_KERNEL void find_candidates(Query& query) const {
    query.cell = surface.cell_of(query.a);
    query.candidate_count = 0;
    if (query.cell == 0) return;
    const OctreeNode& cell = surface.cells.cells[query.cell];
    query.candidates = surface.cells.lists + cell.first, query.candidate_count = cell.count;
    prefetch(query.candidates);
  }

  template <class Isa>
  HOST_KERNEL void finish_query(Query& query, const PointTriangleBatch<Isa>& batch, int which) const {
    const bool has_candidates = query.candidate_count > 0;
    if (!(has_candidates && query.near.distance <= query.contact_range) && rule_out_by_grid(query)) return;
    finish_query(query, has_candidates ? surface.within(query.radius, query.near, query.a) : search_mesh<Isa>(query));
    this->cache_feature(query, [&](double wall, double error)
                                   KERNEL_LAMBDA { return batch.validity_radius(which, query.near, wall, error); });
  }

  /// Returns true if a coarse bound of the distance rules out contact, and records it. It has no sign, so that it says
  /// nothing about a particle that may be inside.
  bool rule_out_by_grid(const Query& query) const {
    if (query.depth > 0) return false;
    const double least = mesh_surface->distance_lower_bound(query.a);
    if (!(least > query.contact_range)) return false;
    this->record_lower_bound(query, least);
    return true;
  }

  /// Queries the whole mesh where no list answers. Lists are built for particles that are near and slow: others seldom
  /// come back.
  template <class Isa>
  ClosestPoint search_mesh(const Query& query) const {
    const bool stays = query.path < 2 * thickness;
    if (stays && query.last.triangle >= 0) {
      const int cell = mesh_surface->make_cell(query.a);
      if (cell > 0) return surface.within(query.radius, surface.template nearest<Isa>(query.a, cell), query.a);
    }
    const ClosestPoint near = mesh_surface->closest(query.a, query.radius);
    if (stays && near.found && near.distance <= query.contact_range && query.last.triangle < 0)
      mesh_surface->make_cell(query.a);
    return near;
  }

  HOST_KERNEL void finish_query(const Query& query, const ClosestPoint& near) const {
    if (!near.found) return this->record_lower_bound(query, query.radius);
    const auto depenetrate_particle = [this](const Query& of, const Point& q, const Point& n, ClosestPointRecord& last)
                                          KERNEL_LAMBDA { return depenetrate(of, q, n, last); };
    const auto sweep_path = [this](int i, const Point& outward) KERNEL_LAMBDA { sweep(i, outward); };
    this->finish(query, near, side_normal(query, near), depenetrate_particle, sweep_path);
  }

  /// The normal of the surface on the side where the particle belongs.
  HOST_KERNEL Point side_normal(const Query& query, const ClosestPoint& near) const {
    const ClosestPointRecord& last = query.last;
    // The particle may have been dragged through since its last query: then it belongs on the side where it was.
    const bool went_through = sides == Sides::TwoSided && std::isfinite(last.distance) &&
                              query.moved >= last.distance && mesh_surface->crossing(last.at, query.a, 0, false).hit;
    return this->towards(near, went_through ? last.at : query.a);
  }

  /// Contact of a path that may pass a corner: with the first crossing, or else with the surface near its end.
  void sweep(int i, const Point& outward) const {
    const Point a = to_local(before, in_double(particles.x[i])),
                b = to_local(after, particles.p.position_without_low(i));
    const Crossing crossing = mesh_surface->crossing(a, b, thickness, sides != Sides::TwoSided);
    if (crossing.hit) {
      const bool flip =
          dot(crossing.normal, b - a) > 0;  // two-sided only: the particle stays on the side that it comes from
      return this->set_contact(i, crossing.q, flip ? -crossing.normal : crossing.normal);
    }
    const ClosestPoint end = mesh_surface->closest(b, std::max(2 * thickness, sides == Sides::Solid ? norm(b - a) : 0));
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
      if (mesh_surface->crossing(above, rim, 0, sides != Sides::TwoSided).hit) return false;
    }
    const int i = query.i;
    const Vector3<R> shift = this->outward_shift(n, last), x = particles.x[i], to = x + shift;
    for (int k = 0; k < environment.count; ++k) {
      const MovingSurface& mesh = environment.meshes[k];
      const Point start = to_local(mesh.before, in_double(x)), end = to_local(mesh.before, in_double(to));
      if (k == mesh_index || environment.caches[k].record(i, start).is_path_clear(start, end)) continue;
      if (mesh.surface->crossing(start, end, 0, mesh.sides != Sides::TwoSided).hit) return false;
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
};

struct Deepest {
  double depth = 0;  // m
  HOST_KERNEL Deepest& operator+=(const Deepest& o) {
    depth = std::max(depth, o.depth);
    return *this;
  }
};

/// Depth of a particle inside a solid, behind a one-sided sheet (but not beyond its boundary), or beyond a two-sided
/// one since its last query; and the depth at which it was forced through a surface.
template <class R>
struct MeasureDepth {
  using RunsOnHost = void;
  const Surface* surface;
  Sides sides;
  Pose pose;
  Particles<R> particles;
  ContactCacheView<R> cache;
  HOST_KERNEL Deepest operator()(int i) const {
    if (!(particles.w[i] > R(0))) return {};
    const Point a = to_local(pose, in_double(particles.x[i]));
    const ClosestPointRecord last = cache.record(i, a);
    return {std::max(norm(last.tunnel_offset), depth(a, last))};
  }

 private:
  double depth(const Point& a, const ClosestPointRecord& last) const {
    if (sides == Sides::Solid && surface->box_distance(a) > 0) return 0;
    if (sides == Sides::TwoSided && !(std::isfinite(last.distance) && surface->crossing(last.at, a, 0, false).hit))
      return 0;
    const ClosestPoint near = surface->closest(a, surface->diagonal());
    if (!near.found) return 0;
    if (sides == Sides::TwoSided) return near.distance;
    return !near.boundary && dot(near.normal, a - near.q) < 0 ? near.distance : 0;
  }
};

}  // namespace malha
