// SPDX-License-Identifier: Apache-2.0
// Contact of a particle with one environment mesh: an inequality per particle, with Coulomb friction and restitution.
#pragma once
#include "kernels/parallel/compute.h"
#include "kernels/simd/particles.h"

namespace malha {

/// C(p) = n . (p - x) - c >= 0, with x the particle's position at the start of the substep: nothing cancels far from
/// the origin. Without contact c is minus infinity. In float it fills a cache line.
template <class R>
struct alignas(16 * sizeof(R)) Contact {
  Vec4<R> plane;    // n, c (m)
  Vec4<R> surface;  // motion of the surface over the substep, and the approach along n without contact (m)
  R lambda;         // accumulated push along n, m
  Vector3<R> friction_displacement;  // m, by which friction has moved the particle back, at most mu lambda
  Vector3<R> cached_position{};      // x for which the plane was computed and still holds; NaN: none
  int particle = -1;                 // -1: the slot is unused

  /// Tells whether the plane still holds for the particle at x: only where it was computed.
  KERNEL bool holds_at(const Vector3<R>& x) const { return same(x, cached_position); }
};

/// Makes the next detection compute the contact anew, wherever its particle starts.
template <class R>
KERNEL void invalidate_cached_position(Contact<R>& contact) {
  contact.cached_position = {R(NAN), R(NAN), R(NAN)};
}
template <class R>
KERNEL void invalidate(Contact<R>& contact) {
  contact.plane = {R(0), R(0), R(0), -R(INFINITY)};
  contact.lambda = R(0);
  contact.friction_displacement = {R(0), R(0), R(0)};
  invalidate_cached_position(contact);
}

/// Invalidates contacts before detection, except resting ones: the same position and a displacement up to max_path (m;
/// below 0: none, as for a moving mesh) give the same contact.
template <class R>
struct InvalidateContacts {
  Contact<R>* contacts;
  Displaced<R> p;
  double max_path;
  KERNEL void operator()(int s) const {
    Contact<R>& contact = contacts[s];
    const int i = contact.particle;
    if (i < 0 || max_path < 0 || !contact.holds_at(p.x[i])) return invalidate(contact);
    const Vector3<double> path = in_double(p.d[i]);
    if (!(dot(path, path) <= max_path * max_path)) return invalidate(contact);
    contact.lambda = R(0);
    contact.friction_displacement = {R(0), R(0), R(0)};
    contact.surface.w = R(dot(in_double(contact.plane.xyz()), path));
  }
};

/// Clamps the accumulated friction to the friction cone; `friction` and `max_length` are displacements (m) or impulses
/// times dt (kg m). If a push is undone, its friction is undone with it.
template <class R>
KERNEL Vector3<R> clamp_to_friction_cone(const Vector3<R>& friction, R max_length) {
  const R length = sqrt(dot(friction, friction));
  return length > max_length ? friction * (max_length / length) : friction;
}

/// Pushes the particle out of the surface and reduces its sliding within the friction cone. Friction acts on
/// positions (Müller et al. 2020, section 3.5), not on velocities afterwards, so that what sticks does not creep.
template <class R, bool mapped = false>
struct ResolveContact {
  Displaced<R> p;
  Contact<R>* contacts;
  R friction;
  const R* factor = nullptr;  // of the friction, where mapped
  KERNEL void operator()(int slot) const {
    Contact<R>& contact = contacts[slot];
    const int i = contact.particle;
    if (i < 0 || contact.plane.w == -R(INFINITY)) return;
    const Vector3<R> n = contact.plane.xyz();
    Vector3<R> moved = p.d[i];
    // Includes the low part of x, which a cached plane does not contain.
    const R C = dot(n, p.offset_from_x(i)) - contact.plane.w;
    const R push = max(-C, -contact.lambda);
    contact.lambda += push;
    moved = moved + n * push;

    const Vector3<R> slide = moved - contact.surface.xyz();
    const Vector3<R> tangent = slide - n * dot(n, slide);
    const Vector3<R> friction_displacement = clamp_to_friction_cone(
        contact.friction_displacement + tangent, friction_of<mapped, R>(factor, i, friction) * contact.lambda);
    p.d.set(i, moved - (friction_displacement - contact.friction_displacement));
    contact.friction_displacement = friction_displacement;
  }
};

/// Restitution where a contact pushed: the particle leaves at e times its approach speed relative to the surface. The
/// impulse that this needs beyond the push has friction too, so that an impact reduces the sliding by mu (1 + e) times
/// the approach, whenever in the substep it happened. The particle moves back by e times the path that remained after
/// the impact. Below the threshold it rests instead. With e = 0 it stops: without this pass it would keep its approach
/// speed until the next substep.
template <class R, bool mapped = false>
struct ApplyRestitution {
  Displaced<R> p;
  Points<R> v;
  const Contact<R>* contacts;
  R restitution, friction, threshold, per_dt;  // e, mu, m/s, 1 / h of the substep (1/s)
  const R* factor = nullptr;                   // of the friction, where mapped
  KERNEL void operator()(int slot) const {
    const Contact<R>& contact = contacts[slot];
    const int i = contact.particle;
    const R approach = contact.surface.w * per_dt;
    if (i < 0 || !(contact.lambda > R(0)) || !(approach < -threshold)) return;
    const Vector3<R> n = contact.plane.xyz();
    const Vector3<R> relative = v[i] - contact.surface.xyz() * per_dt;
    const R speed = dot(n, relative);
    const R gained = -restitution * approach - speed;
    if (!(gained > R(0))) return;  // it already leaves faster
    const Vector3<R> sliding = relative - n * speed;
    const R length = sqrt(dot(sliding, sliding)), max_change = friction_of<mapped, R>(factor, i, friction) * gained;
    const R fraction = length > R(0) ? (length < max_change ? length : max_change) / length : R(0);
    v.set(i, v[i] + n * gained - sliding * fraction);
    const R path_left = contact.lambda < -contact.surface.w ? contact.lambda : -contact.surface.w;
    p.add_displacement(i, n * (restitution * path_left));
  }
};

/// The largest of the depths of particles.
struct Deepest {
  double depth = 0;  // m
  KERNEL Deepest& operator+=(const Deepest& o) {
    depth = max(depth, o.depth);
    return *this;
  }
};

/// Counts contacts that pushed in the last substep.
template <class R>
struct CountContact {
  const Contact<R>* contacts;
  KERNEL Sum operator()(int slot) const {
    return {contacts[slot].particle >= 0 && contacts[slot].lambda > R(0) ? 1.0 : 0.0};
  }
};

}  // namespace malha
