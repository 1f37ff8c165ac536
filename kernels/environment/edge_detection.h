// SPDX-License-Identifier: Apache-2.0
// Detection of the contacts of deformable bodies with edges and corners of the environment
// (kernels/environment/edge_contact.h), in the frame of the moving objects. The points of rigid objects rest in it, and
// those of a mesh that deforms move (kernels/environment/deforming_edge.h). These points are numbered after the
// particles and have inverse mass 0.
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/environment/edge_truncate.h"
#include "kernels/geometry/stackless_bvh.h"

namespace malha {

/// Frame of objects with a common motion, relative to their centre, so that rounding is small far from the origin too.
struct ObjectFrame {
  Pose pose;
  Vector3<double> centre;  // m
  KERNEL Vector3<double> local_of(const Vector3<double>& a) const { return to_local(pose, a) - centre; }
  template <class R>
  KERNEL Vector3<double> local(const Vector3<R>& a) const {
    return local_of(in_double(a));
  }
  template <class R>
  KERNEL Vector3<R> world(const Vector3<R>& a) const {
    return rounded<R>(to_world(pose, in_double(a) + centre));
  }
};

/// Computes the start positions of the particles in the objects' frame.
template <class R>
struct StartLocal {
  ScatteredPoints<R> x0;
  ObjectFrame before;
  ScatteredPoints<R> x;
  KERNEL void operator()(int i) const { x.set(i, rounded<R>(before.local(x0[i]))); }
};

/// Computes the displacements of the particles in the objects' frame.
template <class R>
struct MoveLocal {
  Displaced<R> p;
  ObjectFrame after;
  ScatteredPoints<R> x, moved;
  KERNEL void operator()(int i) const {
    moved.set(i, rounded<R>(after.local_of(in_double(p.x[i]) + in_double(p.d[i])) - in_double(x[i])));
  }
};

/// Marks particles that edges or meshes of the environment have moved in this substep as kinematic for self-collision.
template <class R>
struct KinematicMarks {
  R* w = nullptr;                    // 1/kg; 0 once marked; null: no self-collision
  KinematicOwner* owner = nullptr;   // of each particle
  KinematicOwner number = kNoOwner;  // of the objects that move particles now
  KERNEL bool is_enabled() const { return w != nullptr; }
  KERNEL void mark(int i) const {
    if (is_enabled()) w[i] = R(0), owner[i] = number;
  }
};

/// Sets the position of a particle, given in the objects' frame, and marks it.
template <class R>
struct SetFromLocal {
  Displaced<R> p;
  ObjectFrame after;
  KinematicMarks<R> marks;
  KERNEL void operator()(int i, const Vector3<R>& a) const {
    p.set(i, after.world(a));
    marks.mark(i);
  }
};

/// Stores 1 while other threads may store 1 too.
KERNEL void store_flag(unsigned char* of) {
#if defined(__CUDA_ARCH__)
  *static_cast<volatile unsigned char*>(of) = 1;
#else
  __atomic_store_n(of, static_cast<unsigned char>(1), __ATOMIC_RELAXED);
#endif
}

/// Broad phase of edge contacts: counts the candidate pairs of every simplex of the bodies with the triangles whose
/// boxes overlap its own, or (kStores) stores them at the offsets that the counts gave. kDeforms: the objects' points
/// move, by their d.
template <class R, bool kStores, bool kDeforms = false>
struct FindEdgePairs {
  StacklessBvh path;
  const Simplex *bodies, *objects;  // objects own only features that can touch
  const Box<R>* boxes;              // of particles and points
  ScatteredPoints<R> x;             // of both, at the start of the search
  ScatteredPoints<R> d;             // displacements of the particles, and of points that move
  R contact_range;                  // m, contact distance beyond the displacements
  int* offset;                      // counts that are stored, or offsets
  int count, total;                 // of simplices, of candidates
  Candidate* candidates;
  unsigned char* has_candidates;  // of each particle: whether it is in any candidate

  KERNEL void operator()(int e) const {
    if (kStores && offset[e] == (e + 1 < count ? offset[e + 1] : total)) return;
    const Simplex body = bodies[e];
    const Box<R> edge[3] = {of_edge(body, 0), of_edge(body, 1), of_edge(body, 2)}, box = merge(edge[0], edge[1]);
    int found = 0;
    Candidate* const to = kStores ? candidates + offset[e] : nullptr;
    const auto add = [&](const Candidate& candidate) KERNEL_LAMBDA {
      if (kStores) to[found] = candidate;
      ++found;
    };
    const Slab<R> slab = slab_of(body);
    path.for_each_in(box, slab, [&](int t) KERNEL_LAMBDA {
      const Simplex object = objects[t];
      const int* const c = object.corner;
      const Box<R> object_edge[3] = {of_edge(object, 0), of_edge(object, 1), of_edge(object, 2)},
                   object_box = merge(object_edge[0], object_edge[1]);
      if (!overlap(box, object_box) || are_separated(slab, object) || are_separated(object, body)) return;
      for (int k = 0; k < 3; ++k)
        if (body.owns_corner(k) && overlap(boxes[body.corner[k]], object_box))
          add({{body.corner[k], c[0], c[1], c[2]}});
      KERNEL_ROLLED
      for (int l = 0; l < 3; ++l) {
        if (body.is_face() && object.owns_corner(l) && overlap(boxes[c[l]], box))
          add({{c[l], body.corner[0], body.corner[1], body.corner[2]}});
        if (!object.owns_edge(l)) continue;
        for (int k = 0; k < 3; ++k)
          if (body.owns_edge(k) && overlap(edge[k], object_edge[l]))
            add({{~body.from(k), body.to(k), object.from(l), object.to(l)}});
      }
    });
    if (!kStores) offset[e] = found;
    if (!kStores && found > 0)
      for (const int i : body.corner) store_flag(has_candidates + i);
  }

 private:
  /// Largest motion along n inside the box of displacement d: constraints may pull particles off the straight path.
  KERNEL static R farthest(const Vector3<R>& n, const Vector3<R>& d) {
    return max(n.x * d.x, R(0)) + max(n.y * d.y, R(0)) + max(n.z * d.z, R(0));
  }
  /// The slab that contains the swept boxes of a triangle.
  KERNEL Slab<R> slab_of(const Simplex& s) const {
    const int* const i = s.corner;
    const Vector3<R> a = x[i[0]], n = cross(x[i[1]] - a, x[i[2]] - a);
    R low = R(0), high = R(0);
    for (int k = 0; k < 3; ++k) {
      const Vector3<R> own = d[i[k]];
      low = min(low, -farthest(n, -own)), high = max(high, farthest(n, own));
    }
    const R more = R(1.01) * contact_range * sqrt(dot(n, n));
    return {a, n, low - more, high + more};
  }
  /// Returns true if a triangle lies outside a slab, all the way.
  KERNEL bool are_separated(const Slab<R>& slab, const Simplex& object) const {
    R low = R(INFINITY), high = -R(INFINITY);
    for (int k = 0; k < 3; ++k) {
      const R at = dot(slab.n, x[object.corner[k]] - slab.at);
      low = min(low, at), high = max(high, at);
      if constexpr (kDeforms) {
        const R end = at + dot(slab.n, d[object.corner[k]]);
        low = min(low, end), high = max(high, end);
      }
    }
    return low > slab.high || high < slab.low;
  }
  /// Returns true if the two are separated along the normal of the object's triangle.
  KERNEL bool are_separated(const Simplex& object, const Simplex& body) const {
    const int *const c = object.corner, *const i = body.corner;
    const Vector3<R> a = x[c[0]], n = cross(x[c[1]] - a, x[c[2]] - a);
    R low = R(INFINITY), high = -R(INFINITY);
    for (int k = 0; k < 3; ++k) {
      const R at = dot(n, x[i[k]] - a);
      const Vector3<R> own = d[i[k]];
      low = min(low, at - farthest(n, -own)), high = max(high, at + farthest(n, own));
    }
    const R most = R(1.01) * contact_range * sqrt(dot(n, n));
    if constexpr (kDeforms) {
      R lowest = R(0), highest = R(0);  // of the object's triangle, all the way
      for (int k = 0; k < 3; ++k) {
        const R end = dot(n, x[c[k]] - a + d[c[k]]);
        lowest = min(lowest, end), highest = max(highest, end);
      }
      return low > most + highest || high < lowest - most;
    }
    return low > most || high < -most;
  }
  KERNEL Box<R> of_edge(const Simplex& s, int k) const { return merge(boxes[s.from(k)], boxes[s.to(k)]); }
};

/// Contact parameters of an object.
template <class R>
struct EdgeContactParams {
  R min_distance, friction;  // m, Coulomb's mu
};

/// Index of a contact's object. `object`: 0 for particles, otherwise the index plus 1.
template <class R>
KERNEL int object_of(const EdgeContact<R>& c, const int* object) {
  return max(object[c.i[0]], object[c.i[3]]) - 1;
}

/// Builds the contacts of candidates by the parameters of their objects, and counts how many of their points are
/// particles.
template <class R, class Evaluate = EvaluateCandidate<R>>
struct BuildEdgeContacts {
  Evaluate evaluate;
  const EdgeContactParams<R>* params;
  const int* object;
  const int* offset;
  int count, total, particles;
  EdgeContact<R>* contacts;
  int* ends;
  KERNEL void operator()(int c) const {
    const int at = offset[c], next = c + 1 < count ? offset[c + 1] : total;
    if (next == at) return;
    const Candidate& candidate = evaluate.candidates[c];
    Evaluate with_object = evaluate;
    if constexpr (requires { with_object.select(at); }) with_object.select(at);
    with_object.rules.thickness = params[max(object[candidate.particle(0)], object[candidate.i[3]]) - 1].min_distance;
    EdgeContact<R>& contact = contacts[at];
    if (with_object(candidate, contact)) {
      // Faces push particles in kernels/environment/contact.h; here they only serve the final guard.
      if (contact.first == 1 && contact.i[0] < particles) contact.bias = -R(INFINITY);
      int particle_ends = 0;
      for (int j = 0; j < 4; ++j) particle_ends += contact.i[j] < particles ? 1 : 0;
      ends[at] = particle_ends;
    } else {
      contact.bias = contact.gap = -R(INFINITY);
      ends[at] = 0;
    }
  }
};

/// Lists the particles of all contacts as (particle, contact slot) pairs.
template <class R>
struct ListContactEnds {
  const EdgeContact<R>* contacts;
  const int* offset;  // offsets of the contacts' ends
  int particles;
  Keyed* ends;  // particle, and 4 contact + slot
  KERNEL void operator()(int k) const {
    if (!(contacts[k].gap > -R(INFINITY))) return;
    int at = offset[k];
    for (int j = 0; j < 4; ++j)
      if (contacts[k].i[j] < particles) ends[at++] = {unsigned(contacts[k].i[j]), 4 * k + j};
  }
};

/// Grows the contact distances of particles (kernels/self_collision/contact_distance.h; the w of x) to the distance of
/// the nearest contact below its object's minimum distance, and to max_distance where there is none. Returns how many
/// are still below that.
template <class R>
struct GrowEdgeDistances {
  ScatteredPoints<R> x;
  const EdgeContact<R>* contacts;
  const Keyed* ends;
  const int* begin;  // null: there are no contacts
  const EdgeContactParams<R>* params;
  const int* object;
  R max_distance;
  KERNEL Sum operator()(int i) const {
    R nearest = max_distance;
    for (int e = begin ? begin[i] : 0; e < (begin ? begin[i + 1] : 0); ++e) {
      const EdgeContact<R>& c = contacts[ends[e].value / 4];
      const R distance = distance_of(c);
      if (distance < params[object_of(c, object)].min_distance) nearest = min(nearest, distance);
    }
    R& own = x.of[i].w;
    own = max(own, nearest);
    return {own < max_distance ? 1.0 : 0.0};
  }

 private:
  KERNEL R distance_of(const EdgeContact<R>& c) const {
    Vector3<double> at[4];
    for (int j = 0; j < 4; ++j) at[j] = in_double(x[c.i[j]]);
    return ContactFrameDouble<R>(at, c.first).distance;
  }
};

/// Friction coefficient of a contact: its object's, times the factor at the point of the body, where mapped.
template <class R, bool mapped = false>
struct ObjectFriction {
  const EdgeContactParams<R>* params;
  const int* object;
  const R* factor = nullptr;  // of each particle
  KERNEL R operator()(const EdgeContact<R>& c) const {
    const R mu = params[object_of(c, object)].friction;
    if constexpr (!mapped) return mu;
    R at_point = R(0);
    for (int j = 0; j < 4; ++j)
      if (object[c.i[j]] == 0) at_point += abs(c.weight[j]) * factor[c.i[j]];
    return mu * at_point;
  }
};

/// Rotates impulses from the objects' frame to the world.
struct TurnToWorld {
  Pose pose;
  template <class R>
  KERNEL Vector3<R> operator()(const Vector3<R>& impulse) const {
    return rounded<R>(rotate(pose, in_double(impulse)));
  }
};

/// Counts the particles that may meet triangles that are no candidates: those with contacts that left their swept
/// bounds, and those that left the box of the search.
template <class R>
struct CountBoundsViolations {
  ScatteredPoints<R> x, moved, d, x_then, d_then;
  R margin, slack;  // m
  const unsigned char* has_candidates;
  KERNEL Sum operator()(int i) const {
    const Vector3<R> m = moved[i], own = d[i];
    if (!((m.x + m.y + m.z) * R(0) == R(0))) return {};
    const bool inside = within(m.x, own.x, margin) && within(m.y, own.y, margin) && within(m.z, own.z, margin);
    if (inside) return {};
    if (has_candidates[i]) return {1.0};
    const Vector3<R> from = x[i] + m - x_then[i], then = d_then[i];
    const R most = margin + slack;
    return {within(from.x, then.x, most) && within(from.y, then.y, most) && within(from.z, then.z, most) ? 0.0 : 1.0};
  }

 private:
  KERNEL static bool within(R at, R d, R margin) { return at >= min(d, R(0)) - margin && at <= max(d, R(0)) + margin; }
};

}  // namespace malha
