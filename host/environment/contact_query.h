// SPDX-License-Identifier: Apache-2.0
// Contact query of one particle at one environment mesh, on the host and on a device: both store the same records and
// contacts. What the octree does not answer is up to the `tools` of the caller: on the host they have Embree
// (find_contact.h); on a device they leave the query to the host (contact_query_device.h).
#pragma once
#include "host/attachments/pose.h"
#include "kernels/environment/closest_point_index_view.h"
#include "kernels/environment/proximity_cache.h"
#include "malha/scene.h"

namespace malha {

class ClosestPointIndex;

/// An environment mesh in a substep.
struct MovingMesh {
  const ClosestPointIndex* index;  // for the host
  ClosestPointIndexView surface;
  Sides sides;
  double thickness;    // m
  Pose before, after;  // at the substep's start and end

  /// Motion in the substep, from the world to the world.
  Pose motion() const { return before.moves ? from_to(before, after) : Pose{}; }
};

template <class R>
struct ContactQuery : MovingMesh {
  static constexpr double kSlow = 0.02;       // thicknesses between queries: below it the closest feature is cached
  static constexpr double kOnSurface = 1e-3;  // of the thickness: nearer a particle counts as on the surface
  static constexpr double kMinDistance =
      0.02;  // of the thickness: a particle that was first found deeper inside is moved out to it
  Particles<R> particles;
  ProximityCacheView<R> cache;

  struct Query {
    int i;
    const OctreeNode* leaf = nullptr;  // the octree leaf whose list answers the query; null: none
    ClosestTriangle near;              // by that list
    Point a, b;
    ClosestPointRecord last;
    double path, contact_range, moved, depth, radius;
  };

  /// Returns false if the particle cannot have come near the mesh since its last query, or its cached contact holds.
  KERNEL bool needs_query(int i, Query& query) const {
    const int slot = cache.slot(i);
    if (slot >= 0 && cache.contacts[slot].plane.w != -R(INFINITY)) {
      Contact<R>& contact = cache.contacts[slot];
      if (contact.holds_at(particles.x[i])) return false;
      invalidate(contact);  // another mesh has moved it since
    }
    query.i = i;
    query.a = to_local(before, in_double(particles.x[i])),
    query.b = to_local(after, particles.p.position_without_low(i));
    query.last = cache.record(i, query.a);
    query.path = norm(query.b - query.a);
    // Contact planes are set a thickness early: neighbours may pull the particle further than its own velocity.
    query.contact_range = query.path + 2 * thickness;
    query.moved = norm(query.a - query.last.at);
    return !holds(query.a, query.last.at, query.last.distance - query.contact_range);
  }

  /// Begins a query. Returns false if none is needed, or the mesh's box answers it. Otherwise the particle's group has
  /// entries, which on a device AllocateEntries has allocated before.
  KERNEL bool begin_query(int i, Query& query) const {
    if (!needs_query(i, query)) return false;
    cache.allocate_entries(i / kGroupSize, particles, before);
    const double box = surface.box_distance(query.a);
    if (box > query.contact_range) return record_lower_bound(query, box), false;
    // If the particle went through the surface since, or was inside, it is at most this deep now.
    query.depth = max(query.moved - query.last.distance, 0.0);
    // A larger search radius than needed now spares queries in the next substeps.
    query.radius = 4 * query.contact_range + min(surface.diagonal(), query.depth);
    return true;
  }

  /// The cached closest feature, if it is known to be the closest still; otherwise null.
  KERNEL const ClosestFeature* cached_feature(const Query& query) const {
    const int slot = cache.slot(query.i);
    if (slot < 0 || !cache.near[slot].feature.is_valid_at(surface.relative_to_centre(query.a))) return nullptr;
    return &cache.near[slot].feature;
  }

  /// Answers a query by the cached feature, or else by the closest triangle of its leaf. Returns false, with nothing
  /// stored, if `tools` lack what that needs. `validity_radius(wall, error)`: PointTriangleBatch::validity_radius.
  template <class Tools, class ValidityRadius>
  KERNEL bool answer(const Query& query, const ClosestFeature* cached, const Tools& tools,
                     const ValidityRadius& validity_radius) const {
    const bool listed = !cached && query.near.triangle >= 0;
    ClosestPoint near{};
    if (cached) near = surface.closest_point_on(*cached, query.a);
    const double distance = cached ? near.distance : query.near.distance;
    // A coarse bound may rule out contact. It has no sign, so that it says nothing about a particle that may be inside.
    if (!((cached || listed) && distance <= query.contact_range) && !(query.depth > 0)) {
      double bound;
      if (!tools.find_lower_bound(query, bound)) return false;
      if (bound > query.contact_range) return record_lower_bound(query, bound), true;
    }
    if (listed)
      near = surface.within(query.radius, query.near, query.a);
    else if (cached)
      near.found = distance < query.radius;
    else if (!tools.search_mesh(query, near))
      return false;
    if (!near.found)
      record_lower_bound(query, query.radius);
    else if (!finish(query, near, tools))
      return false;
    if (listed) cache_feature(query, validity_radius);
    return true;
  }

  /// Records that no surface is nearer than `distance`.
  KERNEL void record_lower_bound(const Query& query, double distance) const {
    cache.store(query.i, {query.a, distance, -1, query.last.tunnel_offset});
  }

  KERNEL Point towards(const ClosestPoint& near, const Point& from) const {
    return sides == Sides::TwoSided && dot(near.normal, from - near.q) < 0 ? -near.normal : near.normal;
  }
  /// Returns true if the particle may have been dragged through a two-sided sheet since its last query: then it belongs
  /// on the side where it was.
  KERNEL bool may_have_changed_side(const Query& query) const {
    const double distance = query.last.distance;
    return sides == Sides::TwoSided && distance > -INFINITY && distance < INFINITY && query.moved >= distance;
  }
  /// The gradient of the distance; on the surface itself, where it is undefined, the normal.
  KERNEL Point direction(const ClosestPoint& near, const Point& a, const Point& outward, double distance) const {
    if (near.distance < kOnSurface * thickness) return outward;
    return (a - near.q) * (1 / distance);
  }
  /// Returns true if the path is so long that the plane at the closest point no longer represents the surface: it would
  /// stop a particle that passes a corner.
  KERNEL bool needs_sweep(const Query& query, double distance) const {
    const double clearance = max(thickness, distance);
    return query.path > max(clearance / 2, clearance - thickness);
  }

  /// The overlap that a particle may keep, m. A particle that is nearer than the thickness at its first query, on
  /// either side of the surface, stays as near until it moves away by itself: pushing it out would stretch its body and
  /// give it velocity.
  KERNEL double allowed_overlap(const Query& query, double distance) const {
    const double overlap = max(0.0, thickness - distance);
    if (query.last.distance > -INFINITY) return min(overlap, query.last.overlap);
    return overlap > 2 * thickness ? (1 - kMinDistance) * thickness : overlap;
  }
  /// The distance that a particle must keep, m; negative inside.
  KERNEL double required_distance(const ClosestPointRecord& last) const { return thickness - last.overlap; }

  /// Stores what the query found at the closest point, and sets the contact.
  template <class Tools>
  KERNEL bool finish(const Query& query, const ClosestPoint& near, const Tools& tools) const {
    const int i = query.i;
    const Point& a = query.a;
    Point outward;
    if (!tools.find_side(query, near, outward)) return false;
    const double distance = dot(outward, a - near.q) < 0 ? -near.distance : near.distance;
    if (distance > query.contact_range) return record_lower_bound(query, distance), true;
    ClosestPointRecord last{a, distance, near.triangle, query.last.tunnel_offset, allowed_overlap(query, distance)};
    // Beyond the boundary of a sheet there is no inside.
    if (distance < 0 && near.boundary) return cache.store(i, last), true;
    if (!tools.can_finish(query, last)) return false;

    const Point n = direction(near, a, outward, distance);
    const Vector3<R> x = particles.x[i], p = particles.p[i];
    const bool lies_deep =
        distance < required_distance(last) && !tools.depenetrate(query, near.q, n, last) && distance < 0;
    // A particle behind a sheet still belongs in front of it; at a two-sided sheet, on the side where it was first.
    if (lies_deep || (sides == Sides::TwoSided && near.distance < kOnSurface * thickness))
      last.at = near.q + n * (kOnSurface * thickness);
    cache.store(i, last);
    if (needs_sweep(query, distance)) return tools.sweep(i, outward), true;
    set_contact(i, near.q, n);
    // The contact stays valid for the same position: within twice the thickness every query is made, however short the
    // path.
    if (distance >= 0 && distance <= 2 * thickness && same(x, particles.x[i]) && same(p, particles.p[i]))
      cache.contact(i)->cached_position = x;
    return true;
  }

  /// Caches the closest feature by the list for later queries.
  template <class ValidityRadius>
  KERNEL void cache_feature(const Query& query, const ValidityRadius& validity_radius) const {
    const int slot = cache.slot(query.i);
    if (slot < 0 || query.moved > kSlow * thickness) return;
    ClosestFeature feature = surface.feature(query.near);
    if (feature.kind == ClosestFeature::Point) return;
    feature.at = surface.relative_to_centre(query.a);
    const double wall = distance_to_cell_boundary(surface.cells, *query.leaf, feature.at);
    feature.radius = validity_radius(wall, double(query.leaf->error));
    cache.near[slot].feature = feature;
  }

  /// Returns true if nothing of the same mesh lies between a particle and its least distance: the ball around it that
  /// touches the nearest point contains no other surface, up to rounding.
  KERNEL bool is_unobstructed(const ClosestPointRecord& last) const {
    return !(required_distance(last) - last.distance > 0.99 * last.distance);
  }

  /// The shift that moves a particle out to its required distance: both position and prediction, so that it gives no
  /// velocity (the pre-stabilisation of Macklin et al. 2014, section 4.4).
  KERNEL Vector3<R> outward_shift(const Point& n, const ClosestPointRecord& last) const {
    return rounded<R>(rotate(before, n) * (required_distance(last) - last.distance));
  }
  KERNEL void shift(const Query& query, const Vector3<R>& by, const Point& n, ClosestPointRecord& last) const {
    const double way = required_distance(last) - last.distance;
    particles.x.set(query.i, particles.x[query.i] + by);
    last.at = query.a + n * way;
    last.distance = max(0.0, last.distance - way);                // a lower bound: other triangles may be near
    if (dot(n, last.tunnel_offset) < 0) last.tunnel_offset = {};  // unless it leaves by the back
  }

  KERNEL void set_contact(int i, const Point& q, const Point& n) const {
    const Point x = in_double(particles.x[i]), end = to_world(after, q);
    const double above = required_distance(cache.near[cache.slot(i)].record);
    // A particle that rests on q is this much above it, where a rotating mesh moves faster than at q.
    const Point rest = q + n * above, surface_moved = to_world(after, rest) - to_world(before, rest);
    const Point normal = rotate(after, n);
    const Point relative = in_double(particles.p.d[i]) - surface_moved;
    Contact<R>& contact = *cache.contact(i);
    contact.plane = {R(normal.x), R(normal.y), R(normal.z), R(dot(normal, end - x) + above)};
    const R approach = R(dot(in_double(contact.plane.xyz()), relative));  // as InvalidateContacts computes it
    contact.surface = {R(surface_moved.x), R(surface_moved.y), R(surface_moved.z), approach};
  }
};

}  // namespace malha
