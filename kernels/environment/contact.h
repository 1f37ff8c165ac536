// SPDX-License-Identifier: Apache-2.0
// Contact of a particle with one environment mesh: an inequality per particle, with Coulomb friction and restitution.
#pragma once
#include "kernels/environment/feature_cache.h"
#include "kernels/parallel/reductions.h"
#include "kernels/simd/particles.h"

namespace malha {

/// C(p) = n . (p - x) - c >= 0, with x the particle's position at the start of the substep: nothing cancels far from
/// the origin. Without contact c is minus infinity. A line of the cache, in float.
template <class R>
struct alignas(16 * sizeof(R)) Contact {
  Vec4<R> plane;    // n, c (m)
  Vec4<R> surface;  // motion of the surface over the substep, and approach: the path along n without contact (m)
  R lambda;         // accumulated push along n, m
  Vector3<R> friction_impulse;   // what friction has taken of the sliding, m, at most mu lambda
  Vector3<R> cached_position{};  // x, where it is to stay for a particle that comes again; otherwise not a number
  int particle = -1;             // none: the slot is free
};

/// Where a particle was when it was last looked at (mesh's frame), how far from the surface (m; negative inside; a
/// lower bound where no triangle is near), and its nearest triangle. While it cannot have come near, it is not looked
/// at again, and when it is, the search may start at that triangle: neither changes a contact.
struct ClosestPointRecord {
  Vector3<double> at{};
  double distance = -INFINITY;  // never seen: it may be as deep as the mesh is large
  long long triangle = -1;
  Vector3<double> tunnel_offset{};  // m, how far and whither, where something pressed it through that left no other way
  double overlap = 0;  // m, by which it may be nearer than the thickness, because it was when it was first seen

  /// Whether no surface lies on the way from a to b: none lies within the distance.
  KERNEL bool is_path_clear(const Vector3<double>& a, const Vector3<double>& b) const {
    const Vector3<double> to_a = a - at, to_b = b - at;
    return distance > 0 && dot(to_a, to_a) < distance * distance && dot(to_b, to_b) < distance * distance;
  }
};

/// The same of a pair of a mesh and a particle, for checkpoints: mesh after mesh, of each all particles.
struct SeenOfPair {
  long long pair = 0;
  ClosestPointRecord seen;
};

/// What is remembered of a particle that is near, beside its contact.
struct ProximityRecord {
  ClosestPointRecord seen;
  int cell = 0;  // in which it was last (kernels/environment/triangle_octree.h)
  NearFeature feature;
};

/// As if it were seen for the first time, within the thickness on either side of the surface.
struct KeepOverlap {
  ProximityRecord* near;
  double most;  // m
  KERNEL void operator()(int slot) const { near[slot].seen.overlap = most; }
};

/// It is to be laid anew, wherever its particle comes from.
template <class R>
KERNEL void invalidate_place(Contact<R>& contact) {
  contact.cached_position = {R(NAN), R(NAN), R(NAN)};
}
template <class R>
KERNEL void invalidate(Contact<R>& contact) {
  contact.plane = {R(0), R(0), R(0), -R(INFINITY)};
  contact.lambda = R(0);
  contact.friction_impulse = {R(0), R(0), R(0)};
  invalidate_place(contact);
}

/// Friction that all iterations of a substep take together: `taken` and what slides on, within Coulomb's cone. A push
/// that is taken back takes its friction back.
template <class R>
KERNEL Vector3<R> clamp_to_friction_cone(const Vector3<R>& taken, R budget) {
  const R length = sqrt(dot(taken, taken));
  return length > budget ? taken * (budget / length) : taken;
}

/// Pushes the particle out of the surface and takes from its sliding what Coulomb's cone allows. Friction acts on
/// positions (Müller et al. 2020, section 3.5), not on velocities afterwards, so that what sticks does not creep.
template <class R>
struct ResolveContact {
  Displaced<R> p;
  Contact<R>* contacts;
  R friction;
  KERNEL void operator()(int slot) const {
    Contact<R>& contact = contacts[slot];
    const int i = contact.particle;
    if (i < 0 || contact.plane.w == -R(INFINITY)) return;
    const Vector3<R> n = contact.plane.xyz();
    Vector3<R> moved = p.d[i];
    // With what x lacks, of which a plane that stays knows nothing.
    const R C = dot(n, p.offset_from_x(i)) - contact.plane.w;
    const R push = max(-C, -contact.lambda);
    contact.lambda += push;
    moved = moved + n * push;

    const Vector3<R> slide = moved - contact.surface.xyz();
    const Vector3<R> tangent = slide - n * dot(n, slide);
    const Vector3<R> friction_impulse =
        clamp_to_friction_cone(contact.friction_impulse + tangent, friction * contact.lambda);
    p.d.set(i, moved - (friction_impulse - contact.friction_impulse));
    contact.friction_impulse = friction_impulse;
  }
};

/// Where a contact pushed: the particle leaves at e times the speed at which it came, relative to the surface, and the
/// impulse that this takes beyond the push has its friction too, so that an impact takes mu (1 + e) times the approach
/// from the sliding whenever in the substep it happened. Of the path that was left when it hit, the particle goes e
/// times as much back. Below the threshold it rests instead. With e = 0 it stops: without this it would keep the speed
/// at which it came, until the next substep.
template <class R>
struct ApplyRestitution {
  Displaced<R> p;
  Points<R> v;
  const Contact<R>* contacts;
  R restitution, friction, threshold, per_dt;  // e, mu, m/s, 1/s
  KERNEL void operator()(int slot) const {
    const Contact<R>& contact = contacts[slot];
    const int i = contact.particle;
    const R approach = contact.surface.w * per_dt;
    if (i < 0 || !(contact.lambda > R(0)) || !(approach < -threshold)) return;
    const Vector3<R> n = contact.plane.xyz();
    const Vector3<R> relative = v[i] - contact.surface.xyz() * per_dt;
    const R speed = dot(n, relative);
    const R gained = -restitution * approach - speed;
    if (!(gained > R(0))) return;  // something else carries it away faster
    const Vector3<R> sliding = relative - n * speed;
    const R length = sqrt(dot(sliding, sliding)), budget = friction * gained;
    const R taken = length > R(0) ? (length < budget ? length : budget) / length : R(0);
    v.set(i, v[i] + n * gained - sliding * taken);
    const R path_left = contact.lambda < -contact.surface.w ? contact.lambda : -contact.surface.w;
    p.add_displacement(i, n * (restitution * path_left));
  }
};

/// Whether a contact pushed in the last substep.
template <class R>
struct CountContact {
  const Contact<R>* contacts;
  KERNEL Sum operator()(int slot) const {
    return {contacts[slot].particle >= 0 && contacts[slot].lambda > R(0) ? 1.0 : 0.0};
  }
};

}  // namespace malha
