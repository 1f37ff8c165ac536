// One particle against one environment mesh: the collision constraint of a substep (Müller et al. 2006, section 3.4: a
// continuous test along its way, or the closest point where it is inside), as a kernel that asks Embree.
#pragma once
#include <cmath>

#include "host/collision/surface.h"
#include "host/scene.h"
#include "kernels/near_pairs.h"
#include "kernels/nearby.h"
#include "kernels/pose.h"

namespace malha {

/// An environment mesh in a substep.
struct MovingSurface {
  const Surface* surface;
  Sides sides;
  double thickness;    // m
  Pose before, after;  // at the substep's start and end
};

/// Where the way of a particle from x to p over the substep, straight in the mesh's frame, leads through it.
inline Crossing crossing(const MovingSurface& mesh, const Point& x, const Point& p) {
  return mesh.surface->crossing(to_local(mesh.before, x), to_local(mesh.after, p), 0, mesh.sides != Sides::TwoSided);
}

/// All environment meshes of a substep, and what is known of the particles near each.
template <class R>
struct Surroundings {
  const MovingSurface* meshes;
  int count;
  Particles<R> particles;
  const Nearby<R>* nearby;
};

/// Of the mesh `own` among them: the particles that a word of bits names, compiled for an instruction set. First all
/// their places and cells, then all their contacts: so that memory is waited for once.
template <class R>
struct FindContact : MovingSurface {
  using AsksTheHost = void;
  Surroundings<R> all;
  int own;
  Particles<R> particles;
  Nearby<R> nearby;
  const unsigned long long* bits;

  FindContact(const Surroundings<R>& in, int mesh, const unsigned long long* those)
      : MovingSurface(in.meshes[mesh]),
        all(in),
        own(mesh),
        particles(in.particles),
        nearby(in.nearby[mesh]),
        bits(those) {}

  template <class Group>
  HOST_KERNEL void operator()(const Group& group) const {
    unsigned long long rest = bits[group.index];
    if (rest == 0) return;
    for (unsigned long long ahead = rest; ahead != 0; ahead &= ahead - 1) {
      const int slot = nearby.slot[group.index * kWord + lowest_bit(ahead)];
      if (slot >= 0) prefetch(nearby.near + slot, int(sizeof(Near)));
    }
    Looks storage;
    Look* const looks = storage.of;
    int count = 0;
    for (; rest != 0; rest &= rest - 1) {
      const int i = group.index * kWord + lowest_bit(rest);
      if (particles.w[i] > R(0) && begin(i, looks[count]) && !by_feature(looks[count])) ++count;
    }
    for (int k = 0; k < count; ++k) list(looks[k]);
    for (int k = 0; k < count;) {
      NearPairs<typename Group::Isa> pairs(surface->near_mesh());
      const int first = k;
      for (; k < count && pairs.has_room(looks[k].listed); ++k)
        pairs.add(surface->in_near_mesh(looks[k].a), looks[k].list, looks[k].listed);
      pairs.measure();
      for (int j = first; j < k; ++j) {
        looks[j].near = pairs.nearest(j - first);
        surface->prefetch_normal(looks[j].near);
      }
      for (int j = first; j < k; ++j) end(looks[j], pairs, j - first);
    }
  }

 private:
  struct Look {
    int i, cell;
    const int* list;  // of triangles, of which one is the nearest
    int listed;       // none: not known
    Point a, b;
    LastSeen last;
    double path, reach, moved, depth, radius;
    NearTriangle near;
  };
  union Looks {  // not filled before they are used
    Look of[kWord];
    HOST_KERNEL Looks() {}
  };

  static constexpr double kSlow = 0.02;  // thicknesses from look to look: its nearest feature may stay the nearest

  /// False where it cannot have come near, or comes as it came.
  HOST_KERNEL bool begin(int i, Look& look) const {
    const int slot = nearby.slot[i];
    if (Contact<R>* const contact = nearby.contact(i); contact && contact->plane.w != -R(INFINITY)) {
      if (same(particles.x[i], contact->laid_for)) return false;
      let_go(*contact);  // another mesh has lifted it since
    }
    look.i = i, look.cell = slot < 0 ? 0 : nearby.near[slot].cell, look.last = nearby.seen(i);
    if (look.cell > 0) surface->prefetch_cell(look.cell);
    look.a = to_local(before, in_double(particles.x[i])), look.b = to_local(after, in_double(particles.p[i]));
    look.path = norm(look.b - look.a);
    // A contact plane is laid a thickness early: neighbours may pull the particle further than its own velocity.
    look.reach = look.path + 2 * thickness;
    look.moved = norm(look.a - look.last.at);
    if (look.last.distance - look.moved > look.reach) return false;
    const double box = surface->box_distance(look.a);
    if (box > look.reach) {
      nearby.see(i, {look.a, box, -1, look.last.passed});
      return false;
    }
    // If it went through the surface since, or was inside, it is at most this deep now.
    look.depth = std::max(0.0, look.moved - look.last.distance);
    // Looking further than now needed keeps the particle out of the next substeps' queries.
    look.radius = 4 * look.reach + std::min(look.depth, surface->diagonal());
    return true;
  }

  /// Whether the feature that was the nearest is known to be it still.
  HOST_KERNEL bool by_feature(Look& look) const {
    const int slot = nearby.slot[look.i];
    if (slot < 0 || !nearby.near[slot].feature.holds(surface->in_near_mesh(look.a))) return false;
    const ClosestPoint near = surface->of_feature(nearby.near[slot].feature, look.a);
    if (near.distance <= look.reach || !leave(look)) end(look, near.distance < look.radius ? near : ClosestPoint{});
    return true;
  }

  /// Which triangles are to be compared, by the cell that it is in.
  HOST_KERNEL void list(Look& look) const {
    look.cell = surface->cell_of(look.a, look.cell);
    look.listed = 0;
    if (look.cell == 0) return;
    const NearMesh& mesh = surface->near_mesh();
    const NearCell& cell = mesh.cells[look.cell];
    look.list = mesh.lists + cell.first, look.listed = cell.count;
    prefetch(look.list);
  }

  template <class Isa>
  HOST_KERNEL void end(Look& look, const NearPairs<Isa>& pairs, int which) const {
    const bool listed = look.listed > 0;
    if (!(listed && look.near.distance <= look.reach) && leave(look)) return;
    end(look, listed ? surface->within(look.radius, look.near, look.a) : ask<Isa>(look));
    const int slot = nearby.slot[look.i];
    if (slot < 0 || look.near.triangle < 0 || look.moved > kSlow * thickness) return;
    NearFeature feature = surface->feature(look.near);
    if (feature.kind == NearFeature::Point) return;
    const NearMesh& mesh = surface->near_mesh();
    const NearCell& cell = mesh.cells[look.cell];
    feature.at = surface->in_near_mesh(look.a);
    feature.radius = pairs.holds_within(which, look.near, from_walls(mesh, cell, feature.at), double(cell.error));
    nearby.near[slot].feature = feature;
  }

  /// Whether a coarse bound tells that it cannot touch: of what may be inside it does not tell the side.
  bool leave(const Look& look) const {
    if (look.depth > 0) return false;
    const double least = surface->least_distance(look.a);
    if (!(least > look.reach)) return false;
    nearby.see(look.i, {look.a, least, -1, look.last.passed});
    return true;
  }

  /// Where no list answers. Lists are made for what is near and comes by slowly: others hardly come back.
  template <class Isa>
  ClosestPoint ask(Look& look) const {
    const bool stays = look.path < 2 * thickness;
    if (stays && look.last.triangle >= 0) {
      look.cell = surface->make_cell(look.a);
      if (look.cell > 0) return surface->within(look.radius, surface->template nearest<Isa>(look.a, look.cell), look.a);
    }
    const ClosestPoint near = surface->closest(look.a, look.radius, static_cast<int>(look.last.triangle));
    if (stays && near.found && near.distance <= look.reach && look.last.triangle < 0)
      look.cell = surface->make_cell(look.a);
    return near;
  }

  HOST_KERNEL void end(const Look& look, const ClosestPoint& near) const {
    const int i = look.i;
    const Point& a = look.a;
    if (!near.found) return nearby.see(i, {a, look.radius, -1, look.last.passed});
    const Point outward = side(near, a, look.last, look.moved);
    const double signed_distance = dot(outward, a - near.q) < 0 ? -near.distance : near.distance;
    if (signed_distance > look.reach) return nearby.see(i, {a, signed_distance, -1, look.last.passed});
    LastSeen last{a, signed_distance, near.triangle, look.last.passed};
    // beyond the rim of a sheet there is no inside
    if (signed_distance < 0 && near.boundary) return remember(look, last);

    const Point n = direction(near, a, outward, signed_distance);
    const Vector3<R> x = particles.x[i], p = particles.p[i];
    if (signed_distance < thickness && !lift(i, a, near.q, n, last) && signed_distance < 0)
      last.at = near.q + n * (1e-3 * thickness);  // behind a sheet, it still belongs before it
    remember(look, last);
    // The plane at the nearest point stands for the surface only on a short way: on a long one it would stop what
    // passes a corner.
    const double clearance = std::max(signed_distance, thickness);
    if (look.path > std::max(clearance - thickness, clearance / 2)) return sweep(i, outward);
    set(i, near.q, n);
    // Of what a look would find again: within twice the thickness it looks however short the way is.
    if (signed_distance >= 0 && signed_distance <= 2 * thickness && same(x, particles.x[i]) && same(p, particles.p[i]))
      nearby.contact(i)->laid_for = x;
  }

  HOST_KERNEL void remember(const Look& look, const LastSeen& last) const {
    nearby.see(look.i, last);
    const int slot = nearby.slot[look.i];
    if (slot >= 0) nearby.near[slot].cell = look.cell;
  }

  /// The surface's normal on the side on which the particle belongs.
  HOST_KERNEL Point side(const ClosestPoint& near, const Point& a, const LastSeen& last, double moved) const {
    if (sides != Sides::TwoSided) return near.normal;
    Point from = a;
    // It may have been dragged through since it was last seen: then it belongs on the side where it was.
    if (std::isfinite(last.distance) && moved >= last.distance && surface->crossing(last.at, a, 0, false).hit)
      from = last.at;
    return dot(near.normal, from - near.q) < 0 ? -near.normal : near.normal;
  }

  /// The gradient of the distance, or on the surface itself, where that has no direction, its normal.
  HOST_KERNEL Point direction(const ClosestPoint& near, const Point& a, const Point& outward,
                              double signed_distance) const {
    if (near.distance < 1e-3 * thickness) return outward;
    return (a - near.q) * (1 / signed_distance);
  }

  /// Far enough to reach the surface: what it meets on its way, or else what it ends near or in.
  void sweep(int i, const Point& outward) const {
    const Point a = to_local(before, in_double(particles.x[i])), b = to_local(after, in_double(particles.p[i]));
    const Crossing crossing = surface->crossing(a, b, thickness, sides != Sides::TwoSided);
    if (crossing.hit) {
      const bool flip = dot(crossing.normal, b - a) > 0;  // two-sided only: it stays on the side it comes from
      return set(i, crossing.q, flip ? -crossing.normal : crossing.normal);
    }
    const ClosestPoint end = surface->closest(b, std::max(2 * thickness, sides == Sides::Solid ? norm(b - a) : 0));
    if (!end.found) return;
    const Point normal = sides == Sides::TwoSided && dot(end.normal, outward) < 0 ? -end.normal : end.normal;
    const double signed_distance = dot(normal, b - end.q) < 0 ? -end.distance : end.distance;
    if (signed_distance < 0 && end.boundary) return;
    if (signed_distance < 2 * thickness) set(i, end.q, direction(end, b, normal, signed_distance));
  }

  /// A particle that starts within the thickness is put at its rim, state and prediction alike, so that leaving it
  /// gives no velocity (the pre-stabilisation of Macklin et al. 2014, section 4.4). Not through another mesh, nor
  /// through another part of this one, whose nearest point is q.
  bool lift(int i, const Point& a, const Point& q, const Point& n, LastSeen& last) const {
    const double by = thickness - last.distance;
    // Nothing lies in the ball around a that touches q, but for rounding.
    if (by > 0.99 * last.distance) {
      const Point above = q + n * (1e-3 * thickness), rim = q + n * thickness;
      if (surface->crossing(above, rim, 0, sides != Sides::TwoSided).hit) return false;
    }
    const Point world = rotate(before, n) * by;
    const Vector3<R> shift = rounded<R>(world), x = particles.x[i], to = x + shift;
    for (int k = 0; k < all.count; ++k) {
      const MovingSurface& mesh = all.meshes[k];
      const Point start = to_local(mesh.before, in_double(x)), end = to_local(mesh.before, in_double(to));
      if (k == own || all.nearby[k].seen(i).keeps(start, end)) continue;
      if (mesh.surface->crossing(start, end, 0, mesh.sides != Sides::TwoSided).hit) return false;
    }
    particles.x.set(i, to);
    particles.p.set(i, particles.p[i] + shift);
    for (int k = 0; k < own; ++k) {  // whose planes are told from x
      Contact<R>* const other = all.nearby[k].contact(i);
      if (!other) continue;
      other->plane.w = other->plane.w - dot(other->plane.xyz(), shift);
      forget_place(*other);
    }
    last.at = a + n * by;
    last.distance = std::max(last.distance - by, 0.0);  // of what else is near it is known no better
    if (dot(n, last.passed) < 0) last.passed = {};      // not where it leaves by the back
    return true;
  }

  HOST_KERNEL void set(int i, const Point& q, const Point& n) const {
    const Point x = in_double(particles.x[i]), end = to_world(after, q);
    // What rests on q lies a thickness above it, and there a turning mesh is faster than at q.
    const Point rest = q + n * thickness, surface_moved = to_world(after, rest) - to_world(before, rest);
    const Point normal = rotate(after, n);
    const Point relative = in_double(particles.p[i]) - x - surface_moved;
    Contact<R>& contact = *nearby.contact(i);
    contact.plane = {R(normal.x), R(normal.y), R(normal.z), R(dot(normal, end - x) + thickness)};
    const R approach = R(dot(in_double(contact.plane.xyz()), relative));  // as LetGo has it
    contact.surface = {R(surface_moved.x), R(surface_moved.y), R(surface_moved.z), approach};
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
  using AsksTheHost = void;
  const Surface* surface;
  Sides sides;
  Pose pose;
  Particles<R> particles;
  Nearby<R> nearby;
  HOST_KERNEL Deepest operator()(int i) const {
    if (!(particles.w[i] > R(0))) return {};
    const LastSeen last = nearby.seen(i);
    const double passed = norm(last.passed);
    return {std::max(passed, depth(to_local(pose, in_double(particles.x[i])), last))};
  }

 private:
  double depth(const Point& a, const LastSeen& last) const {
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
