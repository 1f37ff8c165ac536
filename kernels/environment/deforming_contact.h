// SPDX-License-Identifier: Apache-2.0
// Contacts of particles with deforming meshes of the environment, and the guard that keeps particles from passing
// through them. Nothing is cached from substep to substep but the overlap that a particle may keep: a tree that is
// refitted to the motion of each substep finds the triangles near a path in some tens of nanoseconds.
#pragma once
#include "kernels/environment/contact.h"
#include "kernels/environment/deforming_mesh.h"
#include "kernels/environment/proximity_cache.h"

namespace malha {

/// A deforming mesh in a substep, with the contact of each particle.
template <class R>
struct DeformingObject {
  DeformingMesh mesh;
  bool solid, one_sided;  // otherwise a sheet that acts on both sides
  double thickness;       // m
  float* overlap;         // m, of each particle: it may stay nearer than the thickness by as much; kFree: it is inside
  Vec4<float>* clear;     // of each particle: its path crosses nothing if its displacement ends within w of x, y, z; m.
                          // Null: the mesh rests
  int* hint;              // of each particle: the triangle that was closest last; below 0: none was near
  Contact<R>* contact;    // of each particle

  /// An overlap without bound, of a particle that is inside a solid because there was no place for it outside: it is
  /// pushed out gently, through the nearest surface, and crosses it freely until it is outside.
  static constexpr float kFree = INFINITY;
  KERNEL double on_surface() const { return 1e-3 * thickness; }  // m: nearer a particle counts as on the surface
  KERNEL bool is_free(int i) const { return overlap[i] == kFree; }
};

/// Calls work(i) for each particle of a group.
template <class Group, class Work>
KERNEL void for_each_particle(const Group& group, int particles, const Work& work) {
  const int first = group.index * kGroupSize;
  group.for_each(min(particles - first, kGroupSize), [&](int k) KERNEL_LAMBDA { work(first + k); });
}

/// The closest point of a mesh, with the side on which the particle is.
struct SignedDistance {
  bool found = false, rim = false;
  PointOnMesh at{-1, 0, 0};
  Vector3<double> q{}, outward{};  // m; unit, of a particle on the surface, where its distance has no gradient
  double distance = 0;             // m; negative behind the surface
  Box<float> motion{};             // as in ClosestOnMesh
};

/// A particle is behind a one-sided sheet by its pseudonormal, and behind a solid's surface if it is `inside`.
template <class Isa, class R>
KERNEL SignedDistance signed_distance(const DeformingObject<R>& object, Vec4<double>* vertices, const Box<float>& box,
                                      const Vector3<double>& p, bool inside, int hint) {
  const DeformingMesh& mesh = object.mesh;
  const ClosestOnMesh near = closest_point<Isa>(mesh, vertices, box, p, hint);
  SignedDistance found;
  found.motion = near.motion;
  if (near.triangle < 0) return found;
  const double distance = sqrt(near.distance2);
  found.found = true, found.at = closest_on(mesh, vertices, near.triangle, near.q), found.q = near.q;
  found.distance = distance;
  bool back = false;
  if (object.one_sided || distance < object.on_surface()) {
    const Vector3<double> normal = pseudonormal(mesh, vertices, near.triangle, near.feature);
    back = dot(normal, p - near.q) < 0;
    found.rim = object.one_sided && is_rim(mesh, near.triangle, near.feature);
    found.outward = normal * (back != (object.one_sided ? back : inside) ? -1 : 1);
  }
  if (object.one_sided ? back : inside) found.distance = -distance;
  return found;
}

/// The first crossing of an object by the path of a particle; none if it may cross it freely.
template <class Isa, class R>
KERNEL MovingCrossing crossing_of(const DeformingObject<R>& object, const Particles<R>& particles, int i) {
  if (object.is_free(i)) return {};
  const Vector3<double> x = particles.p.exact_start(i), p = particles.p.exact_position(i);
  if (object.clear) {
    const Vec4<float> range = object.clear[i];
    const Vector3<double> off = p - x - in_double(range.xyz());
    if (range.w > 0 && dot(off, off) < double(range.w) * double(range.w)) return {};
  }
  return first_crossing<Isa>(object.mesh, box_of_segment(x, p, 0), x, p, object.one_sided);
}

/// Detects the contacts of the paths from x to p with one mesh.
template <class R>
struct DetectDeformingContacts {
  using Shared = void;
  DeformingObject<R> object;
  Particles<R> particles;
  double max_recovery;  // m, by which a particle that is too near is moved out in a substep, at most
  bool keeps_overlaps;  // particles that are nearer than the thickness now stay so until they move away

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    for_each_particle(group, particles.count, [this](int i) KERNEL_LAMBDA { detect<typename Group::Isa>(i); });
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
    const bool inside = object.solid && (keeps_overlaps || object.is_free(i)) && is_inside(mesh, mesh.before, x);
    const SignedDistance near = signed_distance<Isa>(object, mesh.before, box, x, inside, object.hint[i]);
    object.clear[i] = clear_range(p - x, near);
    if (object.hint[i] != near.at.triangle) object.hint[i] = near.at.triangle;
    // Beyond the boundary of a sheet there is no inside.
    const bool none = !near.found || (near.distance < 0 && near.rim);
    float overlap = inside ? object.kFree : 0.0f;
    if (!inside && !none && (keeps_overlaps || !object.is_free(i))) {
      const auto too_near = float(max(0.0, object.thickness - near.distance));
      overlap = keeps_overlaps ? too_near : min(object.overlap[i], too_near);
    }
    if (object.overlap[i] != overlap) object.overlap[i] = overlap;
    if (none) return;

    const double path = norm(p - x - (near.at.on(mesh, mesh.after) - near.q));
    if (near.distance > path + 2 * object.thickness) return;
    const double kept = inside ? 0.0 : double(overlap);
    const double required = min(object.thickness - kept, near.distance + max_recovery);
    const double clearance = max(object.thickness, near.distance);
    // A long path may pass a corner, where the plane at the closest point would stop it.
    if (!inside && path > max(clearance / 2, clearance - object.thickness)) return sweep<Isa>(i, box, x, p, required);
    set_contact(i, near.at, direction(near, x), turn_with(mesh, near.at.triangle, direction(near, x)), required);
  }

  /// The displacements without a crossing near the predicted one: none of the triangles near the path, whose
  /// displacements are in the box `near.motion`, is nearer to its start than the closest, and none beyond the box that
  /// was searched matters.
  KERNEL Vec4<float> clear_range(const Vector3<double>& way, const SignedDistance& near) const {
    const Box<float>& motion = near.motion;
    double range = object.thickness;  // the box has two
    if (motion.low.x <= motion.high.x) {
      const auto most = [](double at, float low, float high)
                            KERNEL_LAMBDA { return max(at - double(low), double(high) - at); };
      const double relative =
          norm(Vector3<double>{most(way.x, motion.low.x, motion.high.x), most(way.y, motion.low.y, motion.high.y),
                               most(way.z, motion.low.z, motion.high.z)});
      range = min(range, (near.found ? near.distance : INFINITY) - relative);
    }
    return {float(way.x), float(way.y), float(way.z), rounded_down(range - 1e-6 * object.thickness)};
  }

  /// The gradient of the distance; on the surface itself, where it is undefined, the normal.
  KERNEL Vector3<double> direction(const SignedDistance& near, const Vector3<double>& x) const {
    if (abs(near.distance) < object.on_surface()) return near.outward;
    return (x - near.q) * (1 / near.distance);
  }

  /// Contact with the first crossing of the path, or else with the surface near its end.
  template <class Isa>
  KERNEL void sweep(int i, const Box<float>& box, const Vector3<double>& x, const Vector3<double>& p,
                    double required) const {
    const DeformingMesh& mesh = object.mesh;
    const MovingCrossing crossing = first_crossing<Isa>(mesh, box, x, p, object.one_sided);
    if (crossing.at.triangle >= 0) {
      const double side = crossing.from_front ? 1 : -1;
      const Vector3<double> n = face_normal(mesh, mesh.before, crossing.at.triangle) * side,
                            m = face_normal(mesh, mesh.after, crossing.at.triangle) * side;
      return set_contact(i, crossing.at, n, m, required);
    }
    const SignedDistance end = signed_distance<Isa>(object, mesh.after, box, p, false, object.hint[i]);
    if (!end.found || (end.distance < 0 && end.rim)) return;
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
    for_each_particle(group, particles.count, [this](int i) KERNEL_LAMBDA { clamp<typename Group::Isa>(i); });
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
    for (int k = 0; k < count; ++k)
      if (crossing_of<Isa>(objects[k], particles, i).at.triangle >= 0)
        objects[k].overlap[i] = objects[k].kFree, pinched[i] = 1;
  }

  /// Puts the particle in front of the first surface that it crosses, of each object. Returns false if it crosses none.
  template <class Isa>
  KERNEL bool clamp_once(int i, double height) const {
    bool any = false;
    for (int k = 0; k < count; ++k) {
      const DeformingObject<R>& object = objects[k];
      const MovingCrossing at = crossing_of<Isa>(object, particles, i);
      if (at.at.triangle < 0) continue;
      any = true;
      const Vector3<double> n = face_normal(object.mesh, object.mesh.after, at.at.triangle) * (at.from_front ? 1 : -1);
      const double required = object.thickness - double(object.overlap[i]);  // it is not free
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
          closest_point<Isa>(mesh, mesh.before, box_of_segment(x, x, 2 * objects[k].thickness), x, objects[k].hint[i]);
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
    for_each_particle(group, particles.count, [this](int i) KERNEL_LAMBDA { cancel<typename Group::Isa>(i); });
  }

 private:
  template <class Isa>
  KERNEL void cancel(int i) const {
    if (!(particles.w[i] > R(0)) || same(particles.p.d[i], {R(0), R(0), R(0)})) return;
    for (int k = 0; k < count; ++k)
      if (crossing_of<Isa>(objects[k], particles, i).at.triangle >= 0) return particles.p.clear_displacement(i);
  }
};

/// Depth of a particle inside a solid or behind a one-sided sheet, where the substep ended.
template <class R>
struct DepthInDeforming {
  DeformingObject<R> object;
  Particles<R> particles;
  double reach;  // m, depth up to which it is measured
  KERNEL Deepest operator()(int i) const {
    if (!(particles.w[i] > R(0)) || (!object.solid && !object.one_sided)) return {};
    const Vector3<double> x = particles.p.exact_start(i);
    const bool inside = object.solid && is_inside(object.mesh, object.mesh.after, x);
    if (object.solid && !inside) return {};
    const SignedDistance near =
        signed_distance<OneLane>(object, object.mesh.after, box_of_segment(x, x, reach), x, inside, -1);
    return {near.found && !near.rim && near.distance < 0 ? -near.distance : 0};
  }
};

}  // namespace malha
