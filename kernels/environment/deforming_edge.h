// SPDX-License-Identifier: Apache-2.0
// Contacts of deformable bodies with edges and corners of a mesh that deforms: its points move linearly in the objects'
// frame, and no frame is at rest beside all of them. So each contact has a normal at the start of the substep, of a
// plane in front of the object's side, and one at its end, turned as the object's feature turns. The plane moves with
// the feature: bodies that are in front of it at the start and at the end have not crossed the feature in between.
//
// A body's particle that stays where it was does not stay in front of these planes, so the final guard does not shorten
// displacements. The object's points go where they go; what remains are half-spaces, of each particle by itself, and
// the guard moves it into the intersection of its own. A particle without one is jammed, between parts that close on
// it, and goes with the nearest part. Where bodies then cross the mesh, no side is the right one: their pairs are left
// out until they do not cross it any more.
#pragma once
#include "kernels/environment/deforming_mesh.h"
#include "kernels/environment/edge_detection.h"

namespace malha {

/// Normals of the points of a mesh that deforms, at the start and the end of the substep, in the objects' frame; zero
/// where there is none.
struct PointNormals {
  const Vec4<double>*before, *after;
  int first;  // number of the first point
  KERNEL Vector3<double> at_start(int i) const { return before[i - first].xyz(); }
  KERNEL Vector3<double> at_end(int i) const { return after[i - first].xyz(); }
};

/// Narrow phase of a candidate whose object deforms. The contact's normal is that at the end of the substep.
template <class R>
struct EvaluateDeformingCandidate : EvaluateCandidate<R> {
  PointNormals normals;
  Vector3<R>* carry;  // of each contact: how far the surface carries what sticks to it, beyond its own motion, m

  /// Chooses where the carry of the next contact is stored.
  KERNEL void select(int contact) { carry += contact; }

  KERNEL bool operator()(const Candidate& c, EdgeContact<R>& contact) const {
    const ParticleBounds<R>& of = this->bounds;
    for (int j = 0; j < 4; ++j)
      if (is_crossing(c.particle(j))) return false;
    if (!EvaluateCandidate<R>::operator()(c, contact)) return false;
    Vector3<double> start[4], end[4];
    double weight[4];
    for (int j = 0; j < 4; ++j) {
      start[j] = in_double(of.x[contact.i[j]]), end[j] = start[j] + in_double(of.d[contact.i[j]]);
      weight[j] = double(contact.weight[j]);
    }
    const Vector3<double> n = in_double(contact.n), offset = closest_offset(start, weight);
    const double along = dot(n, offset);
    *carry = {R(0), R(0), R(0)};
    // A normal that EvaluateCandidate has turned separates the sides at both ends of the motion.
    if (norm(offset - n * along) > 1e-4 * along) return true;
    contact.n = rounded<R>(unit_or(end_normal(contact, start, end, n), n));
    const Vector3<double> then = in_double(contact.n);
    contact.bias += R(along - dot(then, offset));
    *carry = rounded<R>((then - n) * along);
    return true;
  }

 private:
  KERNEL bool is_crossing(int i) const {
    const R distance = this->bounds.x.of[i].w, most = this->rules.thickness;
    return i < normals.first && distance > most;
  }

  KERNEL static Vector3<double> unit_or(const Vector3<double>& a, const Vector3<double>& otherwise) {
    const double length = norm(a);
    return length > 0 ? a * (1 / length) : otherwise;
  }
  /// The direction of a without its part along a unit vector, or zero.
  KERNEL static Vector3<double> across(const Vector3<double>& a, const Vector3<double>& along) {
    return unit_or_zero(a - along * dot(a, along));
  }

  KERNEL Vector3<double> end_normal(const EdgeContact<R>& contact, const Vector3<double> (&start)[4],
                                    const Vector3<double> (&end)[4], const Vector3<double>& n) const {
    if (contact.first == 2) return turn_with_edge(contact, start, end, n);
    return contact.i[0] < normals.first ? turn_with_face(start, end, n) : turn_with_corner(contact.i[0], n);
  }
  /// Turns a vector with an edge of the object and the normal of the surface at its middle.
  KERNEL Vector3<double> turn_with_edge(const EdgeContact<R>& contact, const Vector3<double> (&start)[4],
                                        const Vector3<double> (&end)[4], const Vector3<double>& v) const {
    const int a = contact.i[2], b = contact.i[3];
    const Vector3<double> e = unit_or_zero(start[3] - start[2]), f = unit_or_zero(end[3] - end[2]),
                          m = across(normals.at_start(a) + normals.at_start(b), e),
                          k = across(normals.at_end(a) + normals.at_end(b), f);
    if (!(dot(e, e) * dot(f, f) > 0)) return v;
    if (!(dot(m, m) * dot(k, k) > 0)) return across(v, f);
    return turn_axes(v, e, m, f, k);
  }
  /// Turns a vector with the normal of the surface at a corner.
  KERNEL Vector3<double> turn_with_corner(int i, const Vector3<double>& v) const {
    const Vector3<double> m = normals.at_start(i), k = normals.at_end(i), axis = cross(m, k);
    const double cosine = dot(m, k);
    if (!(cosine > -0.9)) return v;
    if (!(dot(m, m) * dot(k, k) > 0)) return v;
    return v + cross(axis, v) + cross(axis, cross(axis, v)) * (1 / (1 + cosine));
  }
  /// The normal of a plane at a triangle of the object that deforms with it: what was behind the plane remains so.
  KERNEL static Vector3<double> turn_with_face(const Vector3<double> (&start)[4], const Vector3<double> (&end)[4],
                                               const Vector3<double>& v) {
    const Vector3<double> u = start[2] - start[1], w = start[3] - start[1], m = cross(u, w);
    const Vector3<double> u_end = end[2] - end[1], w_end = end[3] - end[1], k = cross(u_end, w_end);
    const double size = dot(k, k);
    if (!(dot(m, m) * size > 0)) return v;
    return k * (dot(v, m) / sqrt(dot(m, m) * size)) +
           (cross(w_end, k) * dot(v, u) + cross(k, u_end) * dot(v, w)) * (1 / size);
  }
};

/// Friction coefficient of a contact's object, and how far its surface carries what sticks to it.
template <class R, bool mapped = false>
struct DeformingFriction : ObjectFriction<R, mapped> {
  const Vector3<R>* carries;
  KERNEL const Vector3<R>& carry(int contact) const { return carries[contact]; }
};

/// Refits nodes of the BVH, of one depth below the root, to the swept boxes of the triangles' corners.
template <class R>
struct RefitBoxNodes {
  BoxNode* nodes;
  const int* list;
  const Simplex* triangles;
  const Box<R>* boxes;  // of the points
  KERNEL void operator()(int k) const {
    BoxNode& node = nodes[list[k]];
    if (node.triangle >= 0) {
      const int* const c = triangles[node.triangle].corner;
      const Box<R> box = merge(merge(boxes[c[0]], boxes[c[1]]), boxes[c[2]]);
      const R low[3] = {box.low.x, box.low.y, box.low.z}, high[3] = {box.high.x, box.high.y, box.high.z};
      for (int axis = 0; axis < 3; ++axis)
        node.low[axis] = rounded_down(low[axis]), node.high[axis] = -rounded_down(-high[axis]);
      return;
    }
    const BoxNode &first = nodes[list[k] + 1], &second = nodes[first.next];
    for (int axis = 0; axis < 3; ++axis)
      node.low[axis] = min(first.low[axis], second.low[axis]),
      node.high[axis] = max(first.high[axis], second.high[axis]);
  }
};

/// Marks the particles of triangles and edges of the bodies that cross the mesh where the substep starts.
template <class R>
struct FindMeshCrossings {
  StacklessBvh path;
  const Simplex *bodies, *objects;
  ScatteredPoints<R> x;
  unsigned char* crossing;  // of each particle

  KERNEL void operator()(int e) const {
    const Simplex body = bodies[e];
    Vector3<double> of[3];
    for (int k = 0; k < 3; ++k) of[k] = in_double(x[body.corner[k]]);
    const Box<R> box = box_of(body);
    bool found = false;
    path.for_each_in(box, Slab<R>{{R(0), R(0), R(0)}, {R(0), R(0), R(0)}, R(0), R(0)}, [&](int t) KERNEL_LAMBDA {
      if (found || !overlap(box, box_of(objects[t]))) return;
      Vector3<double> by[3];
      for (int k = 0; k < 3; ++k) by[k] = in_double(x[objects[t].corner[k]]);
      for (int k = 0; k < 3; ++k) {
        const int next = k == 2 ? 0 : k + 1;
        found = found || goes_through(of[k], of[next], by) || goes_through(by[k], by[next], of);
      }
    });
    if (found)
      for (const int i : body.corner) store_flag(crossing + i);
  }

 private:
  KERNEL Box<R> box_of(const Simplex& s) const {
    const auto at = [this](int i) KERNEL_LAMBDA {
      const Vector3<R> a = x[i];
      const Vec4<R> row{a.x, a.y, a.z, R(0)};
      return Box<R>{row, row};
    };
    return merge(merge(at(s.corner[0]), at(s.corner[1])), at(s.corner[2]));
  }
  /// Tells whether the segment from p to q goes through a triangle, properly: not where one has no area or no length.
  KERNEL static bool goes_through(const Vector3<double>& p, const Vector3<double>& q, const Vector3<double> (&of)[3]) {
    const Vector3<double> n = cross(of[1] - of[0], of[2] - of[0]), along = q - p;
    const double from = dot(n, p - of[0]), to = dot(n, q - of[0]);
    if (!((from > 0 && to < 0) || (from < 0 && to > 0))) return false;
    const Vector3<double> a = of[0] - p, b = of[1] - p, c = of[2] - p;
    const double ab = dot(along, cross(a, b)), bc = dot(along, cross(b, c)), ca = dot(along, cross(c, a));
    return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
  }
};

/// Leaves out the pairs of the particles that cross the mesh, by a contact distance (kernels/self_collision/
/// contact_distance.h) above all others, and resets it once they do not. Counts them.
template <class R>
struct LeaveOutCrossing {
  ScatteredPoints<R> x;
  const unsigned char* crossing;
  R min_distance;  // m
  KERNEL Sum operator()(int i) const {
    R& own = x.of[i].w;
    if (crossing[i] != 0)
      own = R(2) * min_distance;
    else if (own > min_distance)
      own = R(0);
    return {crossing[i] != 0 ? 1.0 : 0.0};
  }
};

/// ProjectOntoPlanes begins where particles are, or where the nearest part of the mesh takes them; or it leaves them
/// there.
enum class GuardStart { There, Beside, Stay };

/// Final guard: moves the particles of violating contacts in front of the planes of all of their contacts, by
/// projections in turn; a particle for which they fail goes with the nearest part of the mesh. Counts those that moved.
template <class R, class SetPosition>
struct ProjectOntoPlanes {
  DivisionPlanes<R> planes;
  SetPosition set_position;
  GuardStart start;
  const EdgeContact<R>* contacts;
  const Keyed* ends;
  const int* begin;
  const unsigned char* violating;
  const R* w;
  unsigned char* truncated;  // of each particle: 1 if it goes with the mesh and stays there

  KERNEL Sum operator()(int i) const {
    if (!can_end_violation(i, ends, begin, violating, w, truncated)) return {};
    const Vector3<R> x = planes.x0[i];
    const Vector3<double> there = in_double(x) + in_double(planes.moved[i]);
    Vector3<double> to = there;
    truncated[i] = start == GuardStart::Stay;
    if (start != GuardStart::There || !project(i, to)) {
      const Vector3<double> beside = in_double(x) + motion_of_nearest(i);
      to = beside;
      if (start == GuardStart::Stay || !project(i, to)) to = beside;
    }
    const Vector3<R> moved = rounded<R>(to - in_double(x));
    if (same(moved, planes.moved[i])) return {};
    planes.moved.set(i, moved);
    set_position(i, rounded<R>(to));
    return {1.0};
  }

 private:
  static constexpr int kRounds = 32;

  /// Number of the object's points on the other side of particle `own` of a contact, of which `from` is the first.
  KERNEL static int others(const EdgeContact<R>& c, int own, int& from) {
    from = own < c.first ? c.first : 0;
    return own < c.first ? 4 - c.first : c.first;
  }

  /// Moves a position in front of all planes; returns whether it succeeded.
  KERNEL bool project(int i, Vector3<double>& to) const {
    const double more = 0.1 * double(planes.least);
    for (int round = 0; round < kRounds; ++round) {
      bool any = false;
      for (int e = begin[i]; e < begin[i + 1]; ++e) {
        const EdgeContact<R>& c = contacts[ends[e].value / 4];
        const int own = ends[e].value % 4;
        const Vector3<double> n = in_double(c.n) * (own < c.first ? 1.0 : -1.0);
        const Vector3<R> origin = planes.x0[c.i[0]];
        int from;
        const int count = others(c, own, from);
        double front = -INFINITY;  // of the object's side
        for (int j = from; j < from + count; ++j)
          front = max(front, dot(n, in_double(planes.x0[c.i[j]] - origin) + in_double(planes.moved[c.i[j]])));
        const double required = double(planes.required_gap(c)), gap = dot(n, to - in_double(origin)) - front;
        if (gap >= required + 0.5 * more) continue;
        to = to + n * ((required + more - gap) / dot(n, n));
        any = true;
      }
      if (!any) return true;
    }
    return false;
  }

  /// Motion of the object's points at the closest point of the nearest contact.
  KERNEL Vector3<double> motion_of_nearest(int i) const {
    R least = R(INFINITY);
    Vector3<double> motion{0, 0, 0};
    for (int e = begin[i]; e < begin[i + 1]; ++e) {
      const EdgeContact<R>& c = contacts[ends[e].value / 4];
      if (!(c.gap < least)) continue;
      least = c.gap, motion = {0, 0, 0};
      int from;
      const int count = others(c, ends[e].value % 4, from);
      for (int j = from; j < from + count; ++j)
        motion = motion + in_double(planes.moved[c.i[j]]) * abs(double(c.weight[j]));
    }
    return motion;
  }
};

}  // namespace malha
