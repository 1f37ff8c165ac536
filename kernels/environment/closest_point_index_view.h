// SPDX-License-Identifier: Apache-2.0
// View of the closest-point index of a mesh (host/environment/closest_point_index.h) for queries without Embree, on the
// host and on a device: its octree, and the normals of its features. In the mesh's frame, m.
#pragma once
#include "kernels/environment/feature_cache.h"

namespace malha {

using Point = Vector3<double>;

struct ClosestPoint {
  bool found = false;
  int triangle = -1;
  double distance = 0;    // m, >= 0
  Point q{};              // on the surface
  Point normal{};         // unit angle-weighted pseudonormal of the closest face, edge or corner
  bool boundary = false;  // on an edge or corner at the boundary of an open mesh
};

struct ClosestPointIndexView {
  OctreeView cells;                            // the octree, with the corners and triangles
  const Point *face_normals, *corner_normals;  // unit
  const Point (*edge_normals)[3];              // unit; edge k joins corners k and k + 1
  const bool (*rim_edges)[3];
  const unsigned char *rim_corners, *needles;
  Point centre, half;  // of the bounding box

  KERNEL Point point(int i) const { return cells.corners[i].xyz(); }
  KERNEL Point relative_to_centre(const Point& a) const { return a - centre; }
  KERNEL double diagonal() const { return 2 * norm(half); }

  /// The leaf that contains a and has a usable list; null: none.
  KERNEL const OctreeNode* leaf_of(const Point& a) const {
    const OctreeKey key = octree_key(cells, a - centre);
    const int found = key.inside ? find_leaf(cells, key) : 0;
    return found > 0 && cells.cells[found].count <= kMaxListLength ? cells.cells + found : nullptr;
  }
  /// Prefetches the normal of a closest triangle.
  KERNEL void prefetch_normal(const ClosestTriangle& near) const {
    if (near.triangle >= 0 && near.where.corner < 0)
      prefetch(near.where.edge < 0 ? &face_normals[near.triangle] : &edge_normals[near.triangle][near.where.edge]);
  }
  /// The closest point within `radius` as a query of the whole mesh would find it, on the closest triangle.
  KERNEL ClosestPoint within(double radius, const ClosestTriangle& near, const Point& a) const {
    if (!(near.distance < radius) || near.triangle < 0) return {};
    return closest_point_on(feature(near), a);
  }

  /// The closest feature on a triangle. On a face of a needle, whose normal is too inexact, it is the closest point
  /// alone.
  KERNEL ClosestFeature feature(const ClosestTriangle& near) const {
    const int* c = cells.triangles[near.triangle];
    const int corner = near.where.corner, edge = near.where.edge;
    ClosestFeature f;
    f.triangle = near.triangle, f.o = near.where.q;
    if (corner >= 0) {
      f.kind = ClosestFeature::Corner, f.normal = corner_normals[c[corner]], f.boundary = rim_corners[c[corner]] != 0;
    } else if (edge >= 0) {  // the same from either of its triangles
      const int a = c[edge], b = c[(edge + 1) % 3], first = a < b ? a : b;
      const Point way = point(a < b ? b : a) - point(first);
      const double l = sqrt(dot(way, way));
      if (l > 1e-150)
        f.kind = ClosestFeature::Edge, f.o = point(first), f.d = way * (1 / l);  // shorter edges: squares underflow
      f.normal = edge_normals[near.triangle][edge], f.boundary = rim_edges[near.triangle][edge];
    } else {
      f.normal = face_normals[near.triangle];
      if (!needles[near.triangle]) f.kind = ClosestFeature::Face, f.o = point(c[0]), f.d = f.normal;
    }
    return f;
  }
  /// The closest point to a on a feature, if that is the closest feature to a.
  KERNEL ClosestPoint closest_point_on(const ClosestFeature& f, const Point& a) const {
    const Point p = a - centre, q = f.nearest(p), d = p - q;
    return {true, f.triangle, sqrt(dot(d, d)), q + centre, f.normal, f.boundary};
  }

  /// Lower bound of the distance of a: that of the bounding box; 0 inside it.
  KERNEL double box_distance(const Point& a) const {
    const Point d = a - centre;
    return norm(Point{max(0.0, abs(d.x) - half.x), max(0.0, abs(d.y) - half.y), max(0.0, abs(d.z) - half.z)});
  }
  /// Lower bound of the distance of a by the grid over the box, as far as it is computed; below 0: unknown.
  KERNEL double known_lower_bound(const Point& a) const {
    const Point p = a - centre;
    const OctreeKey key = octree_key(cells, p);
    return key.inside ? malha::distance_lower_bound(cells, key, p) : -1;
  }
};

}  // namespace malha
