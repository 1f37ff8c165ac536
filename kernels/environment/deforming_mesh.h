// SPDX-License-Identifier: Apache-2.0
// A triangle mesh of the environment that deforms: its vertices move linearly over a substep. A tree over the swept
// boxes of its triangles answers which of them a particle may come near, wherever both go; the closest point, its
// normal, and the first crossing by a path are computed on those.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/geometry/wide_bvh.h"
#include "kernels/simd/elementary_functions.h"

namespace malha {

struct DeformingMesh {
  Vec4<double>*before, *after;   // vertices at the start and the end of the substep, m
  const int* corner[3];          // of each triangle, in the order of the tree, times kIndexScale<double>
  const int* neighbour[3];       // triangle across the edge from corner k to the next; none: -1
  const int *star_begin, *star;  // triangles at each vertex
  const unsigned char* rim;      // of each vertex: 1 at the boundary of an open mesh
  int triangles;
  WideBvh<float> tree;                    // over blocks of kBranch triangles
  BoxRows<float> box;                     // of each triangle, swept
  Box<float>*vertex_box, *vertex_motion;  // of each vertex: swept, and of its displacement
  BoxRows<float> motion;                  // of each block: of the displacements of its vertices in the substep

  KERNEL int vertex(int triangle, int k) const { return corner[k][triangle] / kIndexScale<double>; }
  KERNEL Vector3<double> at(const Vec4<double>* vertices, int triangle, int k) const {
    return vertices[vertex(triangle, k)].xyz();
  }
};

/// A float below the number.
KERNEL float rounded_down(double a) {
  const auto near = float(a);
  return near - (abs(near) * 1.2e-7f + 1e-37f);
}

/// The box around a segment, larger by `margin` in every direction, rounded outwards.
KERNEL Box<float> box_of_segment(const Vector3<double>& a, const Vector3<double>& b, double margin) {
  const auto low = [&](double u, double v) KERNEL_LAMBDA { return rounded_down(min(u, v) - margin); };
  const auto high = [&](double u, double v) KERNEL_LAMBDA { return -rounded_down(-max(u, v) - margin); };
  return {{low(a.x, b.x), low(a.y, b.y), low(a.z, b.z), 0.0f}, {high(a.x, b.x), high(a.y, b.y), high(a.z, b.z), 0.0f}};
}

/// Computes the swept box of a vertex, and that of its displacement, which has no size.
struct ComputeVertexBounds {
  DeformingMesh mesh;
  KERNEL void operator()(int v) const {
    const Vector3<double> from = mesh.before[v].xyz(), to = mesh.after[v].xyz(), way = to - from;
    mesh.vertex_box[v] = box_of_segment(from, to, 0), mesh.vertex_motion[v] = box_of_segment(way, way, 0);
  }
};

/// Refits a block of the tree: the swept boxes of its triangles, the box of all, and that of their vertices' motion.
struct RefitBlock {
  DeformingMesh mesh;
  KERNEL void operator()(int block) const {
    Box<float> whole = empty_box<float>(), motion = empty_box<float>();
    for (int t = block * kBranch; t < (block + 1) * kBranch; ++t) {
      Box<float> box = empty_box<float>();
      for (int k = 0; k < 3 && t < mesh.triangles; ++k) {
        const int v = mesh.vertex(t, k);
        box = merge(box, mesh.vertex_box[v]), motion = merge(motion, mesh.vertex_motion[v]);
      }
      mesh.box.set(t, box);
      whole = merge(whole, box);
    }
    mesh.tree.node.set(block, whole), mesh.motion.set(block, motion);
  }
};

/// Calls use(triangles, count) for packs of the triangles whose swept boxes overlap `box`; further lanes repeat one.
/// `on_block`: called for every block with triangles that may be among them.
template <class Isa, class Use, class OnBlock>
KERNEL void for_each_triangle_pack(const DeformingMesh& mesh, const Box<float>& box, const Use& use,
                                   const OnBlock& on_block) {
  constexpr int lanes = kLanes<double, Isa>;
  int list[lanes], count = 0;
  for_each_overlap<Isa>(mesh.tree, box, [&](int block) KERNEL_LAMBDA {
    const Box<float>& within = on_block(block);
    unsigned bits = overlaps<Isa>(mesh.box, block * kBranch, kBranch, within);
    for (; bits != 0; bits &= bits - 1) {
      list[count++] = block * kBranch + lowest_bit(bits);
      if (count == lanes) use(list, count), count = 0;
    }
  });
  if (count == 0) return;
  for (int k = count; k < lanes; ++k) list[k] = list[0];
  use(list, count);
}

/// The corners of a pack of triangles.
template <class S>
KERNEL void gather_corners(const DeformingMesh& mesh, Vec4<double>* vertices, const int* triangles,
                           Vector3<S> (&corner)[3]) {
  constexpr int lanes = int(sizeof(S) / sizeof(double));
  for (int k = 0; k < 3; ++k) {
    int index[lanes];
    S w;
    for (int l = 0; l < lanes; ++l) index[l] = mesh.corner[k][triangles[l]];
    gather_rows(vertices, index, corner[k], w);
  }
}

/// The closest point of a mesh.
struct ClosestOnMesh {
  int triangle = -1;            // none: -1
  int feature = 0;              // as in NearestPoint
  double distance2 = INFINITY;  // m^2
  Vector3<double> q{};
  Box<float> motion = empty_box<float>();  // of the displacements of all triangles that overlap the searched box
};

/// The box of both.
KERNEL Box<float> intersection(const Box<float>& a, const Box<float>& b) {
  return {{max(a.low.x, b.low.x), max(a.low.y, b.low.y), max(a.low.z, b.low.z), 0.0f},
          {min(a.high.x, b.high.x), min(a.high.y, b.high.y), min(a.high.z, b.high.z), 0.0f}};
}

/// The closest point to p of the triangles whose swept boxes overlap `box`, with vertices `before` or `after`; of equal
/// distances that of the lowest triangle. `hint`: a triangle that is likely to be near, which spares most others
/// without changing the result; below 0: none.
template <class Isa>
KERNEL ClosestOnMesh closest_point(const DeformingMesh& mesh, Vec4<double>* vertices, const Box<float>& box,
                                   const Vector3<double>& p, int hint) {
  using S = Lane<double, Isa>;
  ClosestOnMesh least;
  const auto measure = [&](const int* triangles, int count) KERNEL_LAMBDA {
    Vector3<S> corner[3];
    gather_corners(mesh, vertices, triangles, corner);
    const Vector3<S> at{S(p.x), S(p.y), S(p.z)};
    const NearestPoint<S> near = nearest_point(at, corner[0], corner[1], corner[2]);
    const Vector3<S> d = at - near.q;
    const S d2 = dot(d, d);
    for (int l = 0; l < count; ++l) {
      const double found = lane(d2, l);
      if (found > least.distance2 || (found == least.distance2 && triangles[l] > least.triangle)) continue;
      least.triangle = triangles[l], least.feature = int(lane(near.feature, l)), least.distance2 = found;
      least.q = {lane(near.q.x, l), lane(near.q.y, l), lane(near.q.z, l)};
    }
  };
  Box<float> within = box;
  if (hint >= 0) {
    const Vector3<double> a = mesh.at(vertices, hint, 0), b = mesh.at(vertices, hint, 1),
                          c = mesh.at(vertices, hint, 2);
    const double distance = norm(p - nearest_on_triangle(p, a, b, c).q);
    within = intersection(box, box_of_segment(p, p, distance * (1 + 1e-9)));
  }
  for_each_triangle_pack<Isa>(mesh, box, measure, [&](int block) KERNEL_LAMBDA -> const Box<float>& {
    least.motion = merge(least.motion, mesh.motion[block]);
    return within;
  });
  return least;
}

KERNEL Vector3<double> unit_or_zero(const Vector3<double>& a) {
  const double length = norm(a);
  return length > 0 ? a * (1 / length) : Vector3<double>{0, 0, 0};
}

/// The unit normal of a triangle; zero if it has no area.
KERNEL Vector3<double> face_normal(const DeformingMesh& mesh, const Vec4<double>* vertices, int triangle) {
  const Vector3<double> a = mesh.at(vertices, triangle, 0);
  return unit_or_zero(cross(mesh.at(vertices, triangle, 1) - a, mesh.at(vertices, triangle, 2) - a));
}

/// The angle-weighted pseudonormal of a feature (Bærentzen and Aanæs 2005), whose sign tells inside from outside.
KERNEL Vector3<double> pseudonormal(const DeformingMesh& mesh, const Vec4<double>* vertices, int triangle,
                                    int feature) {
  const Vector3<double> of_face = face_normal(mesh, vertices, triangle);
  if (feature == 6) return of_face;
  if (feature >= 3) {
    const int other = mesh.neighbour[feature - 3][triangle];
    return other < 0 ? of_face : unit_or_zero(of_face + face_normal(mesh, vertices, other));
  }
  const int v = mesh.vertex(triangle, feature);
  Vector3<double> sum{0, 0, 0};
  for (int s = mesh.star_begin[v]; s < mesh.star_begin[v + 1]; ++s) {
    const int t = mesh.star[s];
    int k = 0;
    while (mesh.vertex(t, k) != v) ++k;
    const Vector3<double> at = vertices[v].xyz(), to = unit_or_zero(mesh.at(vertices, t, (k + 1) % 3) - at),
                          from = unit_or_zero(mesh.at(vertices, t, (k + 2) % 3) - at);
    sum = sum + face_normal(mesh, vertices, t) * atan2(norm(cross(to, from)), dot(to, from));
  }
  return unit_or_zero(sum);
}

/// Tells whether a feature lies at the boundary of an open mesh.
KERNEL bool is_rim(const DeformingMesh& mesh, int triangle, int feature) {
  if (feature == 6) return false;
  return feature >= 3 ? mesh.neighbour[feature - 3][triangle] < 0 : mesh.rim[mesh.vertex(triangle, feature)] != 0;
}

/// Turns a vector as the orthogonal unit vectors e and n turn into f and m.
KERNEL Vector3<double> turn_axes(const Vector3<double>& v, const Vector3<double>& e, const Vector3<double>& n,
                                 const Vector3<double>& f, const Vector3<double>& m) {
  return f * dot(e, v) + m * dot(n, v) + cross(m, f) * dot(cross(n, e), v);
}

/// Turns a vector with a triangle, from the start to the end of the substep: by the rotation of its first edge and its
/// normal.
KERNEL Vector3<double> turn_with(const DeformingMesh& mesh, int triangle, const Vector3<double>& v) {
  const Vector3<double> n = face_normal(mesh, mesh.before, triangle), m = face_normal(mesh, mesh.after, triangle);
  const Vector3<double> e = unit_or_zero(mesh.at(mesh.before, triangle, 1) - mesh.at(mesh.before, triangle, 0));
  const Vector3<double> f = unit_or_zero(mesh.at(mesh.after, triangle, 1) - mesh.at(mesh.after, triangle, 0));
  if (!(dot(n, n) > 0 && dot(m, m) > 0)) return v;
  return turn_axes(v, e, n, f, m);
}

/// The point of a triangle with the weights 1 - wb - wc, wb and wc.
struct PointOnMesh {
  int triangle;
  double wb, wc;
  KERNEL Vector3<double> on(const DeformingMesh& mesh, const Vec4<double>* vertices) const {
    const Vector3<double> a = mesh.at(vertices, triangle, 0);
    return a + (mesh.at(vertices, triangle, 1) - a) * wb + (mesh.at(vertices, triangle, 2) - a) * wc;
  }
};

KERNEL PointOnMesh closest_on(const DeformingMesh& mesh, const Vec4<double>* vertices, int triangle,
                              const Vector3<double>& p) {
  const Vector3<double> a = mesh.at(vertices, triangle, 0);
  const Vector3<double> weights =
      closest_on_triangle(mesh.at(vertices, triangle, 1) - a, mesh.at(vertices, triangle, 2) - a, p - a);
  return {triangle, weights.y, weights.z};
}

/// The crossing of a deforming mesh by a path.
struct MovingCrossing {
  double t = INFINITY;  // of the substep, 0 to 1; infinite: none
  PointOnMesh at{-1, 0, 0};
  bool from_front = true;
};

/// Tells whether a point is inside a closed mesh: whether its winding number is above 0, which stays right where the
/// mesh crosses itself. It is the sum of the signs of the crossings of a ray along x.
KERNEL bool is_inside(const DeformingMesh& mesh, const Vec4<double>* vertices, const Vector3<double>& p) {
  Box<float> ray = box_of_segment(p, p, 0);
  ray.high.x = INFINITY;
  int winding = 0;
  const auto cross_one = [&](int t) KERNEL_LAMBDA {
    // Which side of each edge the ray passes on, in the plane of y and z. Both triangles at an edge compute it from the
    // same numbers, with its lower vertex first, so that a ray through it crosses one of them.
    const auto side = [&](int k) KERNEL_LAMBDA {
      int a = mesh.vertex(t, k), b = mesh.vertex(t, (k + 1) % 3);
      const bool turned = a > b;
      if (turned) {
        const int swap = a;
        a = b, b = swap;
      }
      const Vector3<double> from = vertices[a].xyz() - p, to = vertices[b].xyz() - p;
      const bool left = from.y * to.z - from.z * to.y >= 0;
      return left != turned;
    };
    const bool first = side(0);
    if (side(1) != first || side(2) != first) return;
    const Vector3<double> a = mesh.at(vertices, t, 0),
                          n = cross(mesh.at(vertices, t, 1) - a, mesh.at(vertices, t, 2) - a);
    // The ray meets the plane at the distance dot(n, a - p) / n.x.
    if (dot(n, a - p) * n.x > 0) winding += first ? 1 : -1;
  };
  for_each_overlap<OneLane>(mesh.tree, ray, [&](int block) KERNEL_LAMBDA {
    unsigned bits = overlaps<OneLane>(mesh.box, block * kBranch, kBranch, ray);
    for (; bits != 0; bits &= bits - 1) cross_one(block * kBranch + lowest_bit(bits));
  });
  return winding > 0;
}

/// Coefficients in Bernstein's basis of F(t) = (x - a) . ((b - a) x (c - a)), six times the signed volume of a point
/// and a triangle that move linearly. The point is in the triangle's plane where F is 0; where all coefficients have
/// one sign it never is.
template <class S>
KERNEL void coplanarity(const Vector3<S> (&before)[3], const Vector3<S> (&after)[3], const Vector3<S>& x,
                        const Vector3<S>& p, S (&of)[4]) {
  const S third(1.0 / 3);
  const Vector3<S> u0 = before[1] - before[0], v0 = before[2] - before[0], w0 = x - before[0];
  const Vector3<S> u1 = after[1] - after[0], v1 = after[2] - after[0], w1 = p - after[0];
  const Vector3<S> n0 = cross(u0, v0), n1 = cross(u1, v1), m = cross(u0, v1) + cross(u1, v0);
  of[0] = dot(w0, n0), of[3] = dot(w1, n1);
  of[1] = (dot(w1, n0) + dot(w0, m)) * third, of[2] = (dot(w0, n1) + dot(w1, m)) * third;
}

/// A cubic in Bernstein's basis at t.
KERNEL double bernstein(const double (&f)[4], double t) {
  const double s = 1 - t;
  return s * s * (s * f[0] + 3 * t * f[1]) + t * t * (3 * s * f[2] + t * f[3]);
}

/// Calls found(t, falls) for the roots at which the cubic changes its sign in [0, 1], in ascending order, until it
/// returns true. A start at 0 counts as positive.
template <class Found>
KERNEL void for_each_root(const double (&f)[4], const Found& found) {
  // Between the zeros of the derivative, whose coefficients are these differences, the cubic is monotonic.
  const double d0 = f[1] - f[0], d1 = f[2] - f[1], d2 = f[3] - f[2], a = d0 - 2 * d1 + d2, b = d1 - d0;
  double ends[4] = {0, 1, 1, 1};
  int count = 1;
  const double discriminant = b * b - a * d0;
  if (discriminant > 0) {
    const double q = b < 0 ? -b + sqrt(discriminant) : -b - sqrt(discriminant);
    double first = a != 0 ? q / a : 2.0, second = q != 0 ? d0 / q : 2.0;
    if (first > second) {
      const double swap = first;
      first = second, second = swap;
    }
    if (first > 0 && first < 1) ends[count++] = first;
    if (second > 0 && second < 1) ends[count++] = second;
  }
  ends[count] = 1;
  double low = f[0];
  for (int k = 0; k < count; ++k) {
    const double high = bernstein(f, ends[k + 1]);
    const bool falls = low >= 0;
    if (falls != (high >= 0)) {
      double from = ends[k], to = ends[k + 1];
      for (int halving = 0; halving < 52; ++halving) {
        const double middle = 0.5 * (from + to);
        if ((bernstein(f, middle) >= 0) == falls)
          from = middle;
        else
          to = middle;
      }
      if (found(to, falls)) return;
    }
    low = high;
  }
}

/// The first crossing of the triangles by a point that moves linearly from x to p, of those whose swept boxes overlap
/// `box`. `front_only`: crossings from the back of a triangle do not count.
template <class Isa>
KERNEL MovingCrossing first_crossing(const DeformingMesh& mesh, const Box<float>& box, const Vector3<double>& x,
                                     const Vector3<double>& p, bool front_only) {
  using S = Lane<double, Isa>;
  constexpr double kEdge = 1e-6;  // weights: a path through an edge crosses at least one of its triangles
  MovingCrossing first;
  const auto cross_one = [&](int triangle, const double(&f)[4]) KERNEL_LAMBDA {
    for_each_root(f, [&](double t, bool falls) KERNEL_LAMBDA {
      if (t >= first.t) return true;
      if (front_only && !falls) return false;
      Vector3<double> corner[3];
      for (int k = 0; k < 3; ++k)
        corner[k] = mesh.at(mesh.before, triangle, k) * (1 - t) + mesh.at(mesh.after, triangle, k) * t;
      const Vector3<double> b = corner[1] - corner[0], c = corner[2] - corner[0], n = cross(b, c),
                            at = x * (1 - t) + p * t - corner[0];
      const double n2 = dot(n, n), wb = dot(cross(at, c), n) / n2, wc = dot(cross(b, at), n) / n2;
      if (!(n2 > 0 && wb >= -kEdge && wc >= -kEdge && wb + wc <= 1 + kEdge)) return false;
      first = {t, {triangle, wb, wc}, falls};
      return true;
    });
  };
  const auto measure = [&](const int* triangles, int count) KERNEL_LAMBDA {
    Vector3<S> before[3], after[3];
    gather_corners(mesh, mesh.before, triangles, before), gather_corners(mesh, mesh.after, triangles, after);
    S f[4];
    coplanarity(before, after, Vector3<S>{S(x.x), S(x.y), S(x.z)}, Vector3<S>{S(p.x), S(p.y), S(p.z)}, f);
    const S least = min(min(f[0], f[1]), min(f[2], f[3])), most = max(max(f[0], f[1]), max(f[2], f[3]));
    const unsigned both = movemask((least <= S(0.0)) & (S(0.0) <= most));
    for (int l = 0; l < count; ++l)
      if (both >> l & 1) cross_one(triangles[l], {lane(f[0], l), lane(f[1], l), lane(f[2], l), lane(f[3], l)});
  };
  for_each_triangle_pack<Isa>(mesh, box, measure, [&](int) KERNEL_LAMBDA -> const Box<float>& { return box; });
  return first;
}

}  // namespace malha
