// SPDX-License-Identifier: Apache-2.0
// Contacts of particles with deforming meshes of the environment, and the guard that keeps particles from passing
// through them. Nothing is cached from substep to substep but the overlap that a particle may keep: a tree that is
// refitted to the motion of each substep finds the triangles near a path in some tens of nanoseconds.
#pragma once
#include "kernels/environment/contact.h"
#include "kernels/environment/deforming_mesh.h"

namespace malha {

/// A deforming mesh in a substep, with the contact of each particle.
template <class R>
struct DeformingObject {
  DeformingMesh mesh;
  bool two_sided;
  double thickness;     // m
  float* overlap;       // m, of each particle: it may stay nearer than the thickness by as much
  Contact<R>* contact;  // of each particle
};

inline constexpr int kDeformingGroup = 64;  // particles of a group of the kernels below

/// The closest point of a mesh where the substep began, with the side on which the particle is.
struct SignedDistance {
  bool found = false, rim = false;
  PointOnMesh at{};
  Vector3<double> q{}, outward{};  // m; unit
  double distance = 0;             // m; negative inside a solid, or behind a one-sided sheet
};

template <class Isa, class R>
KERNEL SignedDistance signed_distance(const DeformingObject<R>& object, Vec4<double>* vertices, const Box<float>& box,
                                      const Vector3<double>& p) {
  const DeformingMesh& mesh = object.mesh;
  const ClosestOnMesh near = closest_point<Isa>(mesh, vertices, box, p);
  if (near.triangle < 0) return {};
  const Vector3<double> normal = pseudonormal(mesh, vertices, near.triangle, near.feature), offset = p - near.q;
  const bool behind = dot(normal, offset) < 0;
  return {true,
          is_rim(mesh, near.triangle, near.feature),
          closest_on(mesh, vertices, near.triangle, near.q),
          near.q,
          behind && object.two_sided ? -normal : normal,
          behind && !object.two_sided ? -sqrt(near.distance2) : sqrt(near.distance2)};
}

/// Detects the contacts of the paths from x to p with one mesh.
template <class R>
struct DetectDeformingContacts {
  using Shared = void;
  static constexpr double kOnSurface = 1e-3;  // of the thickness: nearer a particle counts as on the surface
  DeformingObject<R> object;
  Particles<R> particles;
  double max_recovery;  // m, by which a particle that is too near is moved out in a substep, at most
  bool keeps_overlaps;  // particles that are nearer than the thickness now stay so until they move away

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int first = group.index * kDeformingGroup, rest = particles.count - first;
    group.for_each(min(rest, kDeformingGroup), [&](int k) KERNEL_LAMBDA { detect<typename Group::Isa>(first + k); });
  }

 private:
  template <class Isa>
  KERNEL void detect(int i) const {
    Contact<R>& contact = object.contact[i];
    if (contact.particle >= 0) contact.particle = -1;
    if (!(particles.w[i] > R(0))) return;
    const DeformingMesh& mesh = object.mesh;
    const Vector3<double> x = particles.p.exact_start(i), p = particles.p.exact_position(i);
    const Box<float> box = box_of_segment(x, p, 2 * object.thickness);
    const SignedDistance near = signed_distance<Isa>(object, mesh.before, box, x);
    const double too_near = near.found ? max(0.0, object.thickness - near.distance) : 0.0;
    // Beyond the boundary of a sheet there is no inside.
    const bool none = !near.found || (near.distance < 0 && near.rim);
    const double overlap = none ? 0.0 : keeps_overlaps ? too_near : min(double(object.overlap[i]), too_near);
    if (double(object.overlap[i]) != overlap) object.overlap[i] = float(overlap);
    if (none) return;

    const double path = norm(p - x - (near.at.on(mesh, mesh.after) - near.q));
    if (near.distance > path + 2 * object.thickness) return;
    const double required = min(object.thickness - overlap, near.distance + max_recovery);
    const double clearance = max(object.thickness, near.distance);
    // A long path may pass a corner, where the plane at the closest point would stop it.
    if (path > max(clearance / 2, clearance - object.thickness)) return sweep<Isa>(i, box, x, p, near, required);
    set_contact(i, near.at, direction(near, x), turn_with(mesh, near.at.triangle, direction(near, x)), required);
  }

  /// The gradient of the distance; on the surface itself, where it is undefined, the normal.
  KERNEL Vector3<double> direction(const SignedDistance& near, const Vector3<double>& x) const {
    if (abs(near.distance) < kOnSurface * object.thickness) return near.outward;
    return (x - near.q) * (1 / near.distance);
  }

  /// Contact with the first crossing of the path, or else with the surface near its end.
  template <class Isa>
  KERNEL void sweep(int i, const Box<float>& box, const Vector3<double>& x, const Vector3<double>& p,
                    const SignedDistance& start, double required) const {
    const DeformingMesh& mesh = object.mesh;
    const MovingCrossing crossing = first_crossing<Isa>(mesh, box, x, p, !object.two_sided);
    if (crossing.at.triangle >= 0) {
      const double side = crossing.from_front ? 1 : -1;
      const Vector3<double> n = face_normal(mesh, mesh.before, crossing.at.triangle) * side,
                            m = face_normal(mesh, mesh.after, crossing.at.triangle) * side;
      return set_contact(i, crossing.at, n, m, required);
    }
    SignedDistance end = signed_distance<Isa>(object, mesh.after, box, p);
    if (!end.found || (end.distance < 0 && end.rim)) return;
    if (object.two_sided && dot(end.outward, turn_with(mesh, end.at.triangle, start.outward)) < 0)
      end.outward = -end.outward, end.distance = -end.distance;
    if (end.distance < 2 * object.thickness) set_contact(i, end.at, direction(end, p), direction(end, p), required);
  }

  /// Sets the contact with a point of the surface, whose normal turns from n to m in the substep.
  KERNEL void set_contact(int i, const PointOnMesh& at, const Vector3<double>& n, const Vector3<double>& m,
                          double required) const {
    const DeformingMesh& mesh = object.mesh;
    const Vector3<double> x = in_double(particles.x[i]), q = at.on(mesh, mesh.after);
    // What rests on the surface is this much above it.
    const Vector3<double> moved = q + m * required - (at.on(mesh, mesh.before) + n * required);
    Contact<R>& contact = object.contact[i];
    contact.plane = {R(m.x), R(m.y), R(m.z), R(dot(m, q - x) + required)};
    contact.surface = {R(moved.x), R(moved.y), R(moved.z), R(dot(m, in_double(particles.p.d[i]) - moved))};
    contact.lambda = R(0), contact.friction_displacement = {R(0), R(0), R(0)};
    contact.particle = i;
  }
};

/// Final guard of a substep: particles whose path crosses a deforming mesh, because constraints moved them farther than
/// predicted, are put in front of it. A particle for which there is no place, between limbs that pinch it, moves with
/// the surface that was closest, and is marked.
template <class R>
struct ClampToDeforming {
  using Shared = void;
  const DeformingObject<R>* objects;
  int count;
  Particles<R> particles;
  unsigned char* pinched;  // of each particle

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int first = group.index * kDeformingGroup, rest = particles.count - first;
    group.for_each(min(rest, kDeformingGroup), [&](int k) KERNEL_LAMBDA { clamp<typename Group::Isa>(first + k); });
  }

 private:
  static constexpr int kRounds = 10;  // corners between two surfaces need two, acute ones more

  template <class Isa>
  KERNEL void clamp(int i) const {
    pinched[i] = 0;
    if (!(particles.w[i] > R(0))) return;
    double height = 1;  // in units of the required distance: lower where there is little space
    for (int round = 0; round < kRounds; ++round) {
      if (!clamp_once<Isa>(i, height)) return;
      if (round > 2) height *= 0.3;
    }
    move_with_closest<Isa>(i);
    if (crosses<Isa>(i)) pinched[i] = 1;
  }

  template <class Isa>
  KERNEL MovingCrossing crossing(int i, const DeformingObject<R>& object) const {
    const Vector3<double> x = particles.p.exact_start(i), p = particles.p.exact_position(i);
    return first_crossing<Isa>(object.mesh, box_of_segment(x, p, 0), x, p, !object.two_sided);
  }
  template <class Isa>
  KERNEL bool crosses(int i) const {
    for (int k = 0; k < count; ++k)
      if (crossing<Isa>(i, objects[k]).at.triangle >= 0) return true;
    return false;
  }

  /// Puts the particle in front of the first surface that it crosses, of each object. Returns false if it crosses none.
  template <class Isa>
  KERNEL bool clamp_once(int i, double height) const {
    bool any = false;
    for (int k = 0; k < count; ++k) {
      const DeformingObject<R>& object = objects[k];
      const MovingCrossing at = crossing<Isa>(i, object);
      if (at.at.triangle < 0) continue;
      any = true;
      const Vector3<double> n = face_normal(object.mesh, object.mesh.after, at.at.triangle) * (at.from_front ? 1 : -1);
      const double required = object.thickness - double(object.overlap[i]);
      move_to(i, at.at.on(object.mesh, object.mesh.after) + n * (height * max(required, 0.01 * object.thickness)));
    }
    return any;
  }

  /// Keeps the place of the particle beside the closest surface where the substep began.
  template <class Isa>
  KERNEL void move_with_closest(int i) const {
    const Vector3<double> x = particles.p.exact_start(i);
    double least = INFINITY;
    Vector3<double> to = x;
    for (int k = 0; k < count; ++k) {
      const DeformingMesh& mesh = objects[k].mesh;
      const ClosestOnMesh near =
          closest_point<Isa>(mesh, mesh.before, box_of_segment(x, x, 2 * objects[k].thickness), x);
      if (!(near.distance2 < least)) continue;
      least = near.distance2;
      to = closest_on(mesh, mesh.before, near.triangle, near.q).on(mesh, mesh.after) +
           turn_with(mesh, near.triangle, x - near.q);
    }
    move_to(i, to);
  }

  KERNEL void move_to(int i, const Vector3<double>& to) const {
    particles.p.d.set(i, rounded<R>(to - particles.p.exact_start(i)));
  }
};

/// Moves particles whose path, from where a substep ended, crosses a mesh at rest back to its start.
template <class R>
struct CancelCrossings {
  using Shared = void;
  const DeformingObject<R>* objects;
  int count;
  Particles<R> particles;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int first = group.index * kDeformingGroup, rest = particles.count - first;
    group.for_each(min(rest, kDeformingGroup), [&](int k) KERNEL_LAMBDA { cancel<typename Group::Isa>(first + k); });
  }

 private:
  template <class Isa>
  KERNEL void cancel(int i) const {
    if (!(particles.w[i] > R(0)) || same(particles.p.d[i], {R(0), R(0), R(0)})) return;
    const Vector3<double> x = particles.p.exact_start(i), p = particles.p.exact_position(i);
    for (int k = 0; k < count; ++k)
      if (first_crossing<Isa>(objects[k].mesh, box_of_segment(x, p, 0), x, p, !objects[k].two_sided).at.triangle >= 0)
        return particles.p.clear_displacement(i);
  }
};

struct Deepest {
  double depth = 0;  // m
  KERNEL Deepest& operator+=(const Deepest& o) {
    depth = max(depth, o.depth);
    return *this;
  }
};

/// Depth of a particle inside a solid or behind a one-sided sheet, where the substep ended.
template <class R>
struct DepthInDeforming {
  DeformingObject<R> object;
  Particles<R> particles;
  double reach;  // m, depth up to which it is measured
  KERNEL Deepest operator()(int i) const {
    if (!(particles.w[i] > R(0)) || object.two_sided) return {};
    const Vector3<double> x = particles.p.exact_start(i);
    const SignedDistance near = signed_distance<OneLane>(object, object.mesh.after, box_of_segment(x, x, reach), x);
    return {near.found && !near.rim && near.distance < 0 ? -near.distance : 0};
  }
};

}  // namespace malha
