// SPDX-License-Identifier: Apache-2.0
// One particle against one environment mesh: the collision constraint of a substep (Müller et al. 2006, section 3.4: a
// continuous test along its way, or the closest point where it is inside), as a kernel that asks Embree.
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

  /// In the substep, from the world to the world.
  Pose motion() const { return before.moves ? from_to(before, after) : Pose{}; }
};

/// Where the way of a particle from x to p over the substep, straight in the mesh's frame, leads through it.
inline Crossing crossing(const MovingSurface& mesh, const Point& x, const Point& p) {
  return mesh.surface->crossing(to_local(mesh.before, x), to_local(mesh.after, p), 0, mesh.sides != Sides::TwoSided);
}

/// All environment meshes of a substep, and what is known of the particles near each.
template <class R>
struct EnvironmentView {
  const MovingSurface* meshes;
  int count;
  Particles<R> particles;
  const ContactCacheView<R>* nearby;
};

/// Of the mesh `own` among them.
template <class R>
ContactQuery<R> look_at(const EnvironmentView<R>& in, int own) {
  const MovingSurface& mesh = in.meshes[own];
  return {mesh.surface->view(), mesh.sides, mesh.thickness, mesh.before, mesh.after, in.particles, in.nearby[own]};
}

/// Of the mesh `own` among them: the particles that a word of bits names, compiled for an instruction set. First all
/// their places and cells, then all their contacts: so that memory is waited for once.
template <class R>
struct FindContact : ContactQuery<R> {
  using RunsOnHost = void;
  using Base = ContactQuery<R>;
  using Query = typename Base::Query;
  using Base::surface, Base::sides, Base::thickness, Base::before, Base::after, Base::particles, Base::nearby;
  EnvironmentView<R> all;
  int own;
  const Surface* whole;
  const unsigned long long* bits;

  FindContact(const EnvironmentView<R>& in, int mesh, const unsigned long long* those)
      : Base(look_at(in, mesh)), all(in), own(mesh), whole(in.meshes[mesh].surface), bits(those) {}

  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    unsigned long long rest = bits[group.index];
    if (rest == 0) return;
    for (unsigned long long ahead = rest; ahead != 0; ahead &= ahead - 1) {
      const int slot = nearby.slot(group.index * kGroupSize + lowest_bit(ahead));
      if (slot >= 0) prefetch(nearby.near + slot, int(sizeof(ProximityRecord)));
    }
    Looks storage;
    Query* const looks = storage.of;
    int count = 0;
    for (; rest != 0; rest &= rest - 1) {
      const int i = group.index * kGroupSize + lowest_bit(rest);
      if (particles.w[i] > R(0) && this->begin(i, looks[count]) && !by_feature(looks[count])) ++count;
    }
    for (int k = 0; k < count; ++k) list(looks[k]);
    for (int k = 0; k < count;) {
      PointTriangleBatch<typename Group::Isa> pairs(surface.cells);
      const int first = k;
      for (; k < count && pairs.has_room(looks[k].listed); ++k)
        pairs.add(surface.in_near_mesh(looks[k].a), looks[k].list, looks[k].listed);
      pairs.measure();
      for (int j = first; j < k; ++j) {
        looks[j].near = pairs.nearest(j - first);
        surface.prefetch_normal(looks[j].near);
      }
      for (int j = first; j < k; ++j) end(looks[j], pairs, j - first);
    }
  }

 private:
  union Looks {  // not filled before they are used
    Query of[kGroupSize];
    HOST_KERNEL Looks() {}
  };

  /// Whether the feature that was the nearest is known to be it still.
  HOST_KERNEL bool by_feature(Query& look) const {
    const NearFeature* const feature = this->feature_of(look);
    if (!feature) return false;
    const ClosestPoint near = surface.of_feature(*feature, look.a);
    if (near.distance <= look.reach || !leave(look)) end(look, near.distance < look.radius ? near : ClosestPoint{});
    return true;
  }

  /// Which triangles are to be compared, by the cell that it is in.
  HOST_KERNEL void list(Query& look) const {
    look.cell = surface.cell_of(look.a, look.cell);
    look.listed = 0;
    if (look.cell == 0) return;
    const OctreeNode& cell = surface.cells.cells[look.cell];
    look.list = surface.cells.lists + cell.first, look.listed = cell.count;
    prefetch(look.list);
  }

  template <class Isa>
  HOST_KERNEL void end(Query& look, const PointTriangleBatch<Isa>& pairs, int which) const {
    const bool listed = look.listed > 0;
    if (!(listed && look.near.distance <= look.reach) && leave(look)) return;
    end(look, listed ? surface.within(look.radius, look.near, look.a) : ask<Isa>(look));
    this->keep_feature(look, [&](double wall, double error)
                                 KERNEL_LAMBDA { return pairs.holds_within(which, look.near, wall, error); });
  }

  /// Whether a coarse bound tells that it cannot touch: of what may be inside it does not tell the side.
  bool leave(const Query& look) const {
    if (look.depth > 0) return false;
    const double least = whole->least_distance(look.a);
    if (!(least > look.reach)) return false;
    this->record_lower_bound(look, least);
    return true;
  }

  /// Where no list answers. Lists are made for what is near and comes by slowly: others hardly come back.
  template <class Isa>
  ClosestPoint ask(Query& look) const {
    const bool stays = look.path < 2 * thickness;
    if (stays && look.last.triangle >= 0) {
      look.cell = whole->make_cell(look.a);
      if (look.cell > 0) return surface.within(look.radius, surface.template nearest<Isa>(look.a, look.cell), look.a);
    }
    const ClosestPoint near = whole->closest(look.a, look.radius, static_cast<int>(look.last.triangle));
    if (stays && near.found && near.distance <= look.reach && look.last.triangle < 0)
      look.cell = whole->make_cell(look.a);
    return near;
  }

  HOST_KERNEL void end(const Query& look, const ClosestPoint& near) const {
    if (!near.found) return this->record_lower_bound(look, look.radius);
    const auto lift_it = [this](const Query& of, const Point& q, const Point& n, ClosestPointRecord& last)
                             KERNEL_LAMBDA { return depenetrate(of, q, n, last); };
    const auto sweep_it = [this](int i, const Point& outward) KERNEL_LAMBDA { sweep(i, outward); };
    this->finish(look, near, side(look, near), lift_it, sweep_it);
  }

  /// The surface's normal on the side on which the particle belongs.
  HOST_KERNEL Point side(const Query& look, const ClosestPoint& near) const {
    const ClosestPointRecord& last = look.last;
    // It may have been dragged through since it was last seen: then it belongs on the side where it was.
    const bool through = sides == Sides::TwoSided && std::isfinite(last.distance) && look.moved >= last.distance &&
                         whole->crossing(last.at, look.a, 0, false).hit;
    return this->towards(near, through ? last.at : look.a);
  }

  /// Far enough to reach the surface: what it meets on its way, or else what it ends near or in.
  void sweep(int i, const Point& outward) const {
    const Point a = to_local(before, in_double(particles.x[i])),
                b = to_local(after, particles.p.position_without_low(i));
    const Crossing crossing = whole->crossing(a, b, thickness, sides != Sides::TwoSided);
    if (crossing.hit) {
      const bool flip = dot(crossing.normal, b - a) > 0;  // two-sided only: it stays on the side it comes from
      return this->set(i, crossing.q, flip ? -crossing.normal : crossing.normal);
    }
    const ClosestPoint end = whole->closest(b, std::max(2 * thickness, sides == Sides::Solid ? norm(b - a) : 0));
    if (!end.found) return;
    const Point normal = sides == Sides::TwoSided && dot(end.normal, outward) < 0 ? -end.normal : end.normal;
    const double distance = dot(normal, b - end.q) < 0 ? -end.distance : end.distance;
    if (distance < 0 && end.boundary) return;
    if (distance < 2 * thickness) this->set(i, end.q, this->direction(end, b, normal, distance));
  }

  /// Not through another mesh, nor through another part of this one, whose nearest point is q.
  bool depenetrate(const Query& look, const Point& q, const Point& n, ClosestPointRecord& last) const {
    if (!this->is_free(last)) {
      const Point above = q + n * (1e-3 * thickness), rim = q + n * this->least_distance(last);
      if (whole->crossing(above, rim, 0, sides != Sides::TwoSided).hit) return false;
    }
    const int i = look.i;
    const Vector3<R> shift = this->shift_out(n, last), x = particles.x[i], to = x + shift;
    for (int k = 0; k < all.count; ++k) {
      const MovingSurface& mesh = all.meshes[k];
      const Point start = to_local(mesh.before, in_double(x)), end = to_local(mesh.before, in_double(to));
      if (k == own || all.nearby[k].seen(i, start).is_path_clear(start, end)) continue;
      if (mesh.surface->crossing(start, end, 0, mesh.sides != Sides::TwoSided).hit) return false;
    }
    this->shift(look, shift, n, last);
    for (int k = 0; k < own; ++k) {  // whose planes are told from x
      Contact<R>* const other = all.nearby[k].contact(i);
      if (!other) continue;
      other->plane.w = other->plane.w - dot(other->plane.xyz(), shift);
      invalidate_place(*other);
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

/// How deep a particle lies inside a solid, behind a one-sided sheet (but not beyond its rim), or beyond a two-sided
/// one since it was last seen; and how deep it was where it was pressed through.
template <class R>
struct MeasureDepth {
  using RunsOnHost = void;
  const Surface* surface;
  Sides sides;
  Pose pose;
  Particles<R> particles;
  ContactCacheView<R> nearby;
  HOST_KERNEL Deepest operator()(int i) const {
    if (!(particles.w[i] > R(0))) return {};
    const Point a = to_local(pose, in_double(particles.x[i]));
    const ClosestPointRecord last = nearby.seen(i, a);
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
