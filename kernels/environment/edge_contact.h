// SPDX-License-Identifier: Apache-2.0
// Contacts of deformable bodies with edges and corners of the environment: those of
// kernels/self_collision/self_contact.h in the frame of what moves, where its points rest. They are numbered after the
// particles, and have no inverse mass.
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/environment/edge_truncate.h"
#include "kernels/geometry/stackless_bvh.h"

namespace malha {

/// Places of the world as objects of one motion see them, from a point amid them: rounding is small far from the
/// origin too.
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

/// Where the particles start, as seen from the objects.
template <class R>
struct StartLocal {
  ScatteredPoints<R> x0;
  ObjectFrame before;
  ScatteredPoints<R> x;
  KERNEL void operator()(int i) const { x.set(i, rounded<R>(before.local(x0[i]))); }
};

/// And how far they have moved.
template <class R>
struct MoveLocal {
  Displaced<R> p;
  ObjectFrame after;
  ScatteredPoints<R> x, moved;
  KERNEL void operator()(int i) const {
    moved.set(i, rounded<R>(after.local_of(in_double(p.x[i]) + in_double(p.d[i])) - in_double(x[i])));
  }
};

/// Of what edges hold in this substep, where bodies collide with themselves: nothing else may move it.
template <class R>
struct KinematicMarks {
  R* w = nullptr;                    // 1/kg, then 0; none: nothing else will try
  KinematicOwner* owner = nullptr;   // of each particle
  KinematicOwner number = kNoOwner;  // of these edges
  KERNEL bool any() const { return w != nullptr; }
  KERNEL void note(int i) const {
    if (any()) w[i] = R(0), owner[i] = number;
  }
};

/// Puts a particle where the objects see it.
template <class R>
struct SetFromLocal {
  Displaced<R> p;
  ObjectFrame after;
  KinematicMarks<R> held;
  KERNEL void operator()(int i, const Vector3<R>& a) const {
    p.set(i, after.world(a));
    held.note(i);
  }
};

/// Every simplex of the bodies meets the triangles whose boxes overlap its own: finds their pairs, or lays them down
/// where their count said.
template <class R, bool kLays>
struct FindEdgePairs {
  StacklessBvh path;
  const Simplex *bodies, *objects;  // of the objects, only what can touch is owned
  const Box<R>* boxes;              // of particles and points
  ScatteredPoints<R> x;             // of both, where the search starts
  ScatteredPoints<R> d;             // how far the particles may go
  R reach;                          // m: farther than this beyond it they do not meet
  int* place;                       // counts to fill in, or places
  int count, total;                 // of simplices, of places
  Candidate* candidates;
  unsigned char* near;  // of each particle: whether it is in any

  KERNEL void operator()(int e) const {
    if (kLays && place[e] == (e + 1 < count ? place[e + 1] : total)) return;
    const Simplex mine = bodies[e];
    const Box<R> edge[3] = {of_edge(mine, 0), of_edge(mine, 1), of_edge(mine, 2)}, box = merge(edge[0], edge[1]);
    int found = 0;
    Candidate* const to = kLays ? candidates + place[e] : nullptr;
    const auto add = [&](const Candidate& candidate) KERNEL_LAMBDA {
      if (kLays) to[found] = candidate;
      ++found;
    };
    const Slab<R> slab = slab_of(mine);
    path.for_each_in(box, slab, [&](int t) KERNEL_LAMBDA {
      const Simplex theirs = objects[t];
      const int* const c = theirs.corner;
      const Box<R> their_edge[3] = {of_edge(theirs, 0), of_edge(theirs, 1), of_edge(theirs, 2)},
                   their_box = merge(their_edge[0], their_edge[1]);
      if (!overlap(box, their_box) || parted(slab, theirs) || parted(theirs, mine)) return;
      for (int k = 0; k < 3; ++k)
        if (mine.owns_corner(k) && overlap(boxes[mine.corner[k]], their_box)) add({{mine.corner[k], c[0], c[1], c[2]}});
      KERNEL_ROLLED
      for (int l = 0; l < 3; ++l) {
        if (mine.is_face() && theirs.owns_corner(l) && overlap(boxes[c[l]], box))
          add({{c[l], mine.corner[0], mine.corner[1], mine.corner[2]}});
        if (!theirs.owns_edge(l)) continue;
        for (int k = 0; k < 3; ++k)
          if (mine.owns_edge(k) && overlap(edge[k], their_edge[l]))
            add({{~mine.from(k), mine.to(k), theirs.from(l), theirs.to(l)}});
      }
    });
    if (!kLays) place[e] = found;
    if (!kLays && found > 0)
      for (const int i : mine.corner) note(near + i);
  }

 private:
  /// Neighbours note the same of a particle that they share.
  KERNEL static void note(unsigned char* of) {
#if defined(__CUDA_ARCH__)
    *static_cast<volatile unsigned char*>(of) = 1;
#else
    __atomic_store_n(of, static_cast<unsigned char>(1), __ATOMIC_RELAXED);
#endif
  }
  /// Along n, of what stays in the box of its way d: constraints may pull it off the straight one.
  KERNEL static R farthest(const Vector3<R>& n, const Vector3<R>& d) {
    return max(n.x * d.x, R(0)) + max(n.y * d.y, R(0)) + max(n.z * d.z, R(0));
  }
  /// In which the boxes of the ways of a triangle lie.
  KERNEL Slab<R> slab_of(const Simplex& s) const {
    const int* const i = s.corner;
    const Vector3<R> a = x[i[0]], n = cross(x[i[1]] - a, x[i[2]] - a);
    R low = R(0), high = R(0);
    for (int k = 0; k < 3; ++k) {
      const Vector3<R> own = d[i[k]];
      low = min(low, -farthest(n, -own)), high = max(high, farthest(n, own));
    }
    const R more = R(1.01) * reach * sqrt(dot(n, n));
    return {a, n, low - more, high + more};
  }
  KERNEL bool parted(const Slab<R>& slab, const Simplex& theirs) const {
    R low = R(INFINITY), high = -R(INFINITY);
    for (int k = 0; k < 3; ++k) {
      const R at = dot(slab.n, x[theirs.corner[k]] - slab.at);
      low = min(low, at), high = max(high, at);
    }
    return low > slab.high || high < slab.low;
  }
  /// Along the normal of the one at rest.
  KERNEL bool parted(const Simplex& theirs, const Simplex& mine) const {
    const int *const c = theirs.corner, *const i = mine.corner;
    const Vector3<R> a = x[c[0]], n = cross(x[c[1]] - a, x[c[2]] - a);
    R low = R(INFINITY), high = -R(INFINITY);
    for (int k = 0; k < 3; ++k) {
      const R at = dot(n, x[i[k]] - a);
      const Vector3<R> own = d[i[k]];
      low = min(low, at - farthest(n, -own)), high = max(high, at + farthest(n, own));
    }
    const R most = R(1.01) * reach * sqrt(dot(n, n));
    return low > most || high < -most;
  }
  KERNEL Box<R> of_edge(const Simplex& s, int k) const { return merge(boxes[s.from(k)], boxes[s.to(k)]); }
};

/// Of an object.
template <class R>
struct EdgeContactParams {
  R min_distance, friction;  // m, Coulomb's mu
};

/// The object of a contact, by its points' numbers; particles have number 0.
template <class R>
KERNEL int object_of(const SelfContact<R>& c, const int* object) {
  return max(object[c.i[0]], object[c.i[3]]) - 1;
}

/// Lays the contacts of candidates, each by its object's rules, and counts which of their ends are particles.
template <class R>
struct BuildEdgeContacts {
  EvaluateCandidate<R> look;
  const EdgeContactParams<R>* rules;
  const int* object;
  const int* place;
  int count, total, particles;
  SelfContact<R>* contacts;
  int* ends;
  KERNEL void operator()(int c) const {
    const int at = place[c], next = c + 1 < count ? place[c + 1] : total;
    if (next == at) return;
    const Candidate& candidate = look.candidates[c];
    EvaluateCandidate<R> own = look;
    own.rules.thickness = rules[max(object[candidate.particle(0)], object[candidate.i[3]]) - 1].min_distance;
    SelfContact<R>& contact = contacts[at];
    if (own(candidate, contact)) {
      // Faces push particles elsewhere (kernels/environment/contact.h): here they only hold them.
      if (contact.first == 1 && contact.i[0] < particles) contact.bias = -R(INFINITY);
      int own_ends = 0;
      for (int j = 0; j < 4; ++j) own_ends += contact.i[j] < particles ? 1 : 0;
      ends[at] = own_ends;
    } else {
      contact.bias = contact.gap = -R(INFINITY);
      ends[at] = 0;
    }
  }
};

template <class R>
struct ListContactEnds {
  const SelfContact<R>* contacts;
  const int* place;  // of their ends
  int particles;
  Keyed* ends;  // particle, and 4 contact + slot
  KERNEL void operator()(int k) const {
    if (!(contacts[k].gap > -R(INFINITY))) return;
    int at = place[k];
    for (int j = 0; j < 4; ++j)
      if (contacts[k].i[j] < particles) ends[at++] = {unsigned(contacts[k].i[j]), 4 * k + j};
  }
};

/// As in kernels/self_collision/contact_distance.h, of x's w: grows to the distance of the nearest contact that lacks
/// some of what its object wants, and to `most` where there is none. Returns how many have less than that still.
template <class R>
struct GrowEdgeDistances {
  ScatteredPoints<R> x;
  const SelfContact<R>* contacts;
  const Keyed* ends;
  const int* begin;  // null: there are no contacts
  const EdgeContactParams<R>* rules;
  const int* object;
  R most;
  KERNEL Sum operator()(int i) const {
    R nearest = most;
    for (int e = begin ? begin[i] : 0; e < (begin ? begin[i + 1] : 0); ++e) {
      const SelfContact<R>& c = contacts[ends[e].value / 4];
      const R distance = distance_of(c);
      if (distance < rules[object_of(c, object)].min_distance) nearest = min(nearest, distance);
    }
    R& own = x.of[i].w;
    own = max(own, nearest);
    return {own < most ? 1.0 : 0.0};
  }

 private:
  KERNEL R distance_of(const SelfContact<R>& c) const {
    Vector3<double> at[4];
    double weight[4];
    for (int j = 0; j < 4; ++j) at[j] = in_double(x[c.i[j]]);
    EvaluateCandidate<R>::weigh(c.first, at, weight);
    const Vector3<double> apart = EvaluateCandidate<R>::between(at, weight);
    return R(sqrt(dot(apart, apart)));
  }
};

/// Coulomb's mu of a contact's object.
template <class R>
struct ObjectFriction {
  const EdgeContactParams<R>* rules;
  const int* object;
  KERNEL R operator()(const SelfContact<R>& c) const { return rules[object_of(c, object)].friction; }
};

/// Impulses out of the objects' frame.
struct TurnToWorld {
  Pose pose;
  template <class R>
  KERNEL Vector3<R> operator()(const Vector3<R>& impulse) const {
    return rounded<R>(rotate(pose, in_double(impulse)));
  }
};

/// Counts the particles that may meet what was not looked at: those with contacts that left their reach, and those
/// that left the box of the search.
template <class R>
struct CountBoundsViolations {
  ScatteredPoints<R> x, moved, d, x_then, d_then;
  R margin, slack;  // m
  const unsigned char* near;
  KERNEL Sum operator()(int i) const {
    const Vector3<R> m = moved[i], own = d[i];
    if (!((m.x + m.y + m.z) * R(0) == R(0))) return {};
    const bool inside = within(m.x, own.x, margin) && within(m.y, own.y, margin) && within(m.z, own.z, margin);
    if (inside) return {};
    if (near[i]) return {1.0};
    const Vector3<R> from = x[i] + m - x_then[i], then = d_then[i];
    const R most = margin + slack;
    return {within(from.x, then.x, most) && within(from.y, then.y, most) && within(from.z, then.z, most) ? 0.0 : 1.0};
  }

 private:
  KERNEL static bool within(R at, R d, R margin) { return at >= min(d, R(0)) - margin && at <= max(d, R(0)) + margin; }
};

}  // namespace malha
