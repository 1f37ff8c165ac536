// One particle against one environment mesh: the collision constraint of a substep (Müller et al. 2006, section 3.4: a
// continuous test along its way, or the closest point where it is inside), as a kernel that asks Embree.
#pragma once
#include <cmath>
#include <cstdint>

#include "host/collision/pose.h"
#include "host/collision/surface.h"
#include "host/scene.h"
#include "kernels/contact.h"

namespace malha {

/// What is remembered of a particle from substep to substep: where it was when it was last looked at (mesh's frame),
/// how far from the surface (m; negative inside; a lower bound where no triangle is near), and its nearest triangle.
/// While it cannot have come near, it is not looked at again, and when it is, the search starts at that triangle:
/// neither changes a contact.
struct LastSeen {
  Point at{};
  double distance = -INFINITY;  // never seen: it may be as deep as the mesh is large
  std::int64_t triangle = -1;
  Point passed{};  // m, how far and whither, where something pressed it through that left no other way
};

/// An environment mesh in a substep.
struct MovingSurface {
  const Surface* surface;
  Sides sides;
  double thickness;    // m
  Pose before, after;  // at the substep's start and end
};

template <class R>
Point in_double(const Vector3<R>& a) {
  return {double(a.x), double(a.y), double(a.z)};
}

/// Where the way of a particle from x to p over the substep, straight in the mesh's frame, leads through it.
inline Crossing crossing(const MovingSurface& mesh, const Point& x, const Point& p) {
  return mesh.surface->crossing(to_local(mesh.before, x), to_local(mesh.after, p), 0, mesh.sides != Sides::TwoSided);
}

/// All environment meshes of a substep. Of what is known of the particles, that of one mesh follows another's.
template <class R>
struct Surroundings {
  const MovingSurface* meshes;
  int count;
  Particles<R> particles;
  LastSeen* seen;
  Contact<R>* contacts;
};

/// Of the mesh `own` among them.
template <class R>
struct FindContact : MovingSurface {
  Surroundings<R> all;
  int own;
  Particles<R> particles;
  LastSeen* seen;
  Contact<R>* contacts;

  FindContact(const Surroundings<R>& in, int mesh)
      : MovingSurface(in.meshes[mesh]),
        all(in),
        own(mesh),
        particles(in.particles),
        seen(in.seen + mesh * in.particles.count),
        contacts(in.contacts + mesh * in.particles.count) {}

  KERNEL void operator()(int i) const {
    contacts[i].plane = {R(0), R(0), R(0), -R(INFINITY)};
    contacts[i].lambda = R(0);
    contacts[i].slip = {R(0), R(0), R(0)};
    if (particles.w[i] > R(0)) look(i);
  }

 private:
  static double length(const Point& a) { return std::sqrt(dot(a, a)); }

  void look(int i) const {
    const Point a = to_local(before, in_double(particles.x[i])), b = to_local(after, in_double(particles.p[i]));
    const double path = length(b - a);
    // A contact plane is laid a thickness early: neighbours may pull the particle further than its own velocity.
    const double reach = path + 2 * thickness;
    LastSeen& last = seen[i];
    const double moved = length(a - last.at);
    if (last.distance - moved > reach) return;
    const double box = surface->box_distance(a);
    if (box > reach) {
      last = {a, box, -1, last.passed};
      return;
    }
    // If it went through the surface since, or was inside, it is at most this deep now.
    const double depth = std::max(0.0, moved - last.distance);
    // Looking further than now needed keeps the particle out of the next substeps' queries.
    const double radius = 4 * reach + std::min(depth, surface->diagonal());
    const ClosestPoint near = surface->closest(a, radius, static_cast<int>(last.triangle));
    if (!near.found) {
      last = {a, radius, -1, last.passed};
      return;
    }
    const Point outward = side(near, a, last, moved);
    const double signed_distance = dot(outward, a - near.q) < 0 ? -near.distance : near.distance;
    last = {a, signed_distance, near.triangle, last.passed};
    if (signed_distance > reach) return;
    if (signed_distance < 0 && near.boundary) return;  // beyond the rim of a sheet there is no inside

    const Point n = direction(near, a, outward, signed_distance);
    if (signed_distance < thickness && !lift(i, a, n, thickness - signed_distance) && signed_distance < 0)
      last.at = near.q + n * (1e-3 * thickness);  // behind a sheet, it still belongs before it
    // The plane at the nearest point stands for the surface only on a short way: on a long one it would stop what
    // passes a corner.
    const double clearance = std::max(signed_distance, thickness);
    if (path > std::max(clearance - thickness, clearance / 2)) return sweep(i, outward);
    set(i, near.q, n);
  }

  /// The surface's normal on the side on which the particle belongs.
  Point side(const ClosestPoint& near, const Point& a, const LastSeen& last, double moved) const {
    if (sides != Sides::TwoSided) return near.normal;
    Point from = a;
    // It may have been dragged through since it was last seen: then it belongs on the side where it was.
    if (std::isfinite(last.distance) && moved >= last.distance && surface->crossing(last.at, a, 0, false).hit)
      from = last.at;
    return dot(near.normal, from - near.q) < 0 ? -near.normal : near.normal;
  }

  /// The gradient of the distance, or on the surface itself, where that has no direction, its normal.
  Point direction(const ClosestPoint& near, const Point& a, const Point& outward, double signed_distance) const {
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
    const ClosestPoint end = surface->closest(b, std::max(2 * thickness, sides == Sides::Solid ? length(b - a) : 0));
    if (!end.found) return;
    const Point normal = sides == Sides::TwoSided && dot(end.normal, outward) < 0 ? -end.normal : end.normal;
    const double signed_distance = dot(normal, b - end.q) < 0 ? -end.distance : end.distance;
    if (signed_distance < 0 && end.boundary) return;
    if (signed_distance < 2 * thickness) set(i, end.q, direction(end, b, normal, signed_distance));
  }

  /// A particle that starts within the thickness is put at its rim, state and prediction alike, so that leaving it
  /// gives no velocity (the pre-stabilisation of Macklin et al. 2014, section 4.4). Not through another mesh.
  bool lift(int i, const Point& a, const Point& n, double by) const {
    const Point world = rotate(before, n) * by;
    const Vector3<R> shift{R(world.x), R(world.y), R(world.z)}, x = particles.x[i], to = x + shift;
    for (int k = 0; k < all.count; ++k) {
      const MovingSurface& mesh = all.meshes[k];
      const auto at = [&](const Vector3<R>& place) { return to_local(mesh.before, in_double(place)); };
      if (k != own && mesh.surface->crossing(at(x), at(to), 0, mesh.sides != Sides::TwoSided).hit) return false;
    }
    particles.x.set(i, to);
    particles.p.set(i, particles.p[i] + shift);
    for (int k = 0; k < own; ++k) {  // whose planes are told from x
      Vec4<R>& plane = all.contacts[k * particles.count + i].plane;
      plane.w = plane.w - dot(plane.xyz(), shift);
    }
    seen[i].at = a + n * by;
    seen[i].distance = thickness;
    if (dot(n, seen[i].passed) < 0) seen[i].passed = {};  // not where it leaves by the back
    return true;
  }

  void set(int i, const Point& q, const Point& n) const {
    const Point x = in_double(particles.x[i]), end = to_world(after, q);
    // What rests on q lies a thickness above it, and there a turning mesh is faster than at q.
    const Point rest = q + n * thickness, surface_moved = to_world(after, rest) - to_world(before, rest);
    const Point normal = rotate(after, n);
    const Point relative = in_double(particles.p[i]) - x - surface_moved;
    contacts[i].plane = {R(normal.x), R(normal.y), R(normal.z), R(dot(normal, end - x) + thickness)};
    contacts[i].surface = {R(surface_moved.x), R(surface_moved.y), R(surface_moved.z), R(dot(normal, relative))};
  }
};

struct Deepest {
  double depth = 0;  // m
  KERNEL Deepest& operator+=(const Deepest& o) {
    depth = std::max(depth, o.depth);
    return *this;
  }
};

/// How deep a particle lies inside a solid, behind a one-sided sheet (but not beyond its rim), or beyond a two-sided
/// one since it was last seen; and how deep it was where it was pressed through.
template <class R>
struct MeasureDepth {
  const Surface* surface;
  Sides sides;
  Pose pose;
  Particles<R> particles;
  const LastSeen* seen;
  KERNEL Deepest operator()(int i) const {
    if (!(particles.w[i] > R(0))) return {};
    const double passed = std::sqrt(dot(seen[i].passed, seen[i].passed));
    return {std::max(passed, depth(to_local(pose, in_double(particles.x[i])), seen[i]))};
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
