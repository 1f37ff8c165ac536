// SPDX-License-Identifier: Apache-2.0
// A look of one particle at one environment mesh, up to where only Embree could go on: of kernels on the host and on a
// device. What it remembers and lays is the same on both.
#pragma once
#include "host/environment/surface_view.h"
#include "kernels/attachments/pose.h"
#include "kernels/environment/contact_cache.h"
#include "malha/scene.h"

namespace malha {

template <class R>
struct ContactQuery {
  static constexpr double kSlow = 0.02;   // thicknesses from look to look: its nearest feature may stay the nearest
  static constexpr double kOn = 1e-3;     // of the thickness: nearer it is on the surface
  static constexpr double kLeast = 0.02;  // of the thickness: to there it is put that is seen deeper inside than it
  SurfaceView surface;
  Sides sides;
  double thickness;    // m
  Pose before, after;  // at the substep's start and end
  Particles<R> particles;
  ContactCacheView<R> nearby;

  struct Query {
    int i, cell;
    const int* list;  // of triangles, of which one is the nearest
    int listed;       // none: not known
    Point a, b;
    ClosestPointRecord last;
    double path, reach, moved, depth, radius;
    NearTriangle near;
  };

  /// Finds where a particle is and where it was seen; returns false where it cannot have come near since.
  KERNEL bool comes_near(int i, Query& look) const {
    look.i = i;
    look.a = to_local(before, in_double(particles.x[i])), look.b = to_local(after, particles.p.position_without_low(i));
    look.last = nearby.seen(i, look.a);
    look.path = norm(look.b - look.a);
    // A contact plane is laid a thickness early: neighbours may pull the particle further than its own velocity.
    look.reach = look.path + 2 * thickness;
    look.moved = norm(look.a - look.last.at);
    return !(look.last.distance - look.moved > look.reach);
  }

  /// False where it cannot have come near, or comes as it came. Otherwise its word has places, which on a device it was
  /// given before (see GivePlaces).
  KERNEL bool begin(int i, Query& look) const {
    const int slot = nearby.slot(i);
    if (slot >= 0 && nearby.contacts[slot].plane.w != -R(INFINITY)) {
      Contact<R>& contact = nearby.contacts[slot];
      if (same(particles.x[i], contact.cached_position)) return false;
      invalidate(contact);  // another mesh has lifted it since
    }
    if (!comes_near(i, look)) return false;
    nearby.give_places(i / kGroupSize, particles, before);
    look.cell = slot < 0 ? 0 : nearby.near[slot].cell;
    if (look.cell > 0) surface.prefetch_cell(look.cell);
    const double box = surface.box_distance(look.a);
    if (box > look.reach) {
      record_lower_bound(look, box);
      return false;
    }
    // If it went through the surface since, or was inside, it is at most this deep now.
    look.depth = max(look.moved - look.last.distance, 0.0);
    // Looking further than now needed keeps the particle out of the next substeps' queries.
    look.radius = 4 * look.reach + min(surface.diagonal(), look.depth);
    return true;
  }

  /// The feature that was the nearest, if it is known to be it still.
  KERNEL const NearFeature* feature_of(const Query& look) const {
    const int slot = nearby.slot(look.i);
    if (slot < 0 || !nearby.near[slot].feature.holds(surface.in_near_mesh(look.a))) return nullptr;
    return &nearby.near[slot].feature;
  }

  /// Keeps the nearest feature for looks to come; `holds(wall, error)`: see PointTriangleBatch::holds_within.
  template <class Holds>
  KERNEL void keep_feature(const Query& look, const Holds& holds) const {
    const int slot = nearby.slot(look.i);
    if (slot < 0 || look.near.triangle < 0 || look.moved > kSlow * thickness) return;
    NearFeature feature = surface.feature(look.near);
    if (feature.kind == NearFeature::Point) return;
    const OctreeNode& cell = surface.cells.cells[look.cell];
    feature.at = surface.in_near_mesh(look.a);
    feature.radius = holds(distance_to_cell_boundary(surface.cells, cell, feature.at), double(cell.error));
    nearby.near[slot].feature = feature;
  }

  /// Nothing is nearer than that.
  KERNEL void record_lower_bound(const Query& look, double distance) const {
    nearby.see(look.i, {look.a, distance, -1, look.last.tunnel_offset});
  }
  KERNEL void remember(const Query& look, const ClosestPointRecord& last) const {
    nearby.see(look.i, last);
    const int slot = nearby.slot(look.i);
    if (slot >= 0) nearby.near[slot].cell = look.cell;
  }

  KERNEL Point towards(const ClosestPoint& near, const Point& from) const {
    return sides == Sides::TwoSided && dot(near.normal, from - near.q) < 0 ? -near.normal : near.normal;
  }
  KERNEL double signed_distance(const ClosestPoint& near, const Point& a, const Point& outward) const {
    return dot(outward, a - near.q) < 0 ? -near.distance : near.distance;
  }
  /// The gradient of the distance, or on the surface itself, where that has no direction, its normal.
  KERNEL Point direction(const ClosestPoint& near, const Point& a, const Point& outward, double distance) const {
    if (near.distance < kOn * thickness) return outward;
    return (a - near.q) * (1 / distance);
  }
  /// The plane at the nearest point stands for the surface only on a short way: on a long one it would stop what passes
  /// a corner.
  KERNEL bool goes_far(const Query& look, double distance) const {
    const double clearance = max(thickness, distance);
    return look.path > max(clearance / 2, clearance - thickness);
  }

  /// The overlap that a particle may keep, in m: what is nearer than the thickness when it is first seen, on either
  /// side of the surface, stays as near until it opens by itself. To lift it would stretch a body of which it is a
  /// part, and so give it speed.
  KERNEL double overlap_of(const Query& look, double distance) const {
    const double lacks = max(0.0, thickness - distance);
    if (look.last.distance > -INFINITY) return min(lacks, look.last.overlap);
    return lacks > 2 * thickness ? (1 - kLeast) * thickness : lacks;
  }
  /// The distance that a particle must keep, m; negative inside.
  KERNEL double least_distance(const ClosestPointRecord& last) const { return thickness - last.overlap; }

  /// Stores what the query found at the nearest point. `depenetrate(look, q, n, last)` moves a particle that starts too
  /// near out to its least distance, if it can; `sweep(i, outward)` follows a path that goes far.
  template <class Depenetrate, class Sweep>
  KERNEL void finish(const Query& look, const ClosestPoint& near, const Point& outward, const Depenetrate& depenetrate,
                     const Sweep& sweep) const {
    const int i = look.i;
    const Point& a = look.a;
    const double distance = signed_distance(near, a, outward);
    if (distance > look.reach) return record_lower_bound(look, distance);
    ClosestPointRecord last{a, distance, near.triangle, look.last.tunnel_offset, overlap_of(look, distance)};
    // beyond the rim of a sheet there is no inside
    if (distance < 0 && near.boundary) return remember(look, last);

    const Point n = direction(near, a, outward, distance);
    const Vector3<R> x = particles.x[i], p = particles.p[i];
    const bool lies_deep = distance < least_distance(last) && !depenetrate(look, near.q, n, last) && distance < 0;
    // Behind a sheet it still belongs before it, and on one that has two sides, on that on which it was seen first.
    if (lies_deep || (sides == Sides::TwoSided && near.distance < kOn * thickness))
      last.at = near.q + n * (kOn * thickness);
    remember(look, last);
    if (goes_far(look, distance)) return sweep(i, outward);
    set(i, near.q, n);
    // Of what a look would find again: within twice the thickness it looks however short the way is.
    if (distance >= 0 && distance <= 2 * thickness && same(x, particles.x[i]) && same(p, particles.p[i]))
      nearby.contact(i)->cached_position = x;
  }

  /// Returns true if nothing of the same mesh lies between a particle and its least distance: the ball around it that
  /// touches the nearest point holds nothing else, but for rounding.
  KERNEL bool is_free(const ClosestPointRecord& last) const {
    return !(least_distance(last) - last.distance > 0.99 * last.distance);
  }

  /// Puts it there, state and prediction alike, so that leaving it gives no velocity (the pre-stabilisation of Macklin
  /// et al. 2014, section 4.4).
  KERNEL Vector3<R> shift_out(const Point& n, const ClosestPointRecord& last) const {
    return rounded<R>(rotate(before, n) * (least_distance(last) - last.distance));
  }
  KERNEL void shift(const Query& look, const Vector3<R>& by, const Point& n, ClosestPointRecord& last) const {
    const double way = least_distance(last) - last.distance;
    particles.x.set(look.i, particles.x[look.i] + by);
    last.at = look.a + n * way;
    last.distance = max(0.0, last.distance - way);                // of what else is near it is known no better
    if (dot(n, last.tunnel_offset) < 0) last.tunnel_offset = {};  // not where it leaves by the back
  }

  KERNEL void set(int i, const Point& q, const Point& n) const {
    const Point x = in_double(particles.x[i]), end = to_world(after, q);
    const double above = least_distance(nearby.near[nearby.slot(i)].seen);
    // What rests on q lies so much above it, and there a turning mesh is faster than at q.
    const Point rest = q + n * above, surface_moved = to_world(after, rest) - to_world(before, rest);
    const Point normal = rotate(after, n);
    const Point relative = in_double(particles.p.d[i]) - surface_moved;
    Contact<R>& contact = *nearby.contact(i);
    contact.plane = {R(normal.x), R(normal.y), R(normal.z), R(dot(normal, end - x) + above)};
    const R approach = R(dot(in_double(contact.plane.xyz()), relative));  // as InvalidateContacts has it
    contact.surface = {R(surface_moved.x), R(surface_moved.y), R(surface_moved.z), approach};
  }
};

}  // namespace malha
