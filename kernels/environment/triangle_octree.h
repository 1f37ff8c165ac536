// SPDX-License-Identifier: Apache-2.0
// The nearest of many triangles, by lists: the space around a mesh is cut into cells (an octree), and a cell lists all
// triangles that are nearest to any point of it. The lists belong to the mesh alone, so that every particle that comes
// by in any substep uses them, and what they answer is what all triangles would, whichever cells exist.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/simd/pack.h"

namespace malha {

/// Its parts, by the signs of x, y, z as bits 0, 1, 2, and its list. Inner cells keep theirs: their parts are cut from
/// it.
struct alignas(64) OctreeNode {
  int child[8];      // its number; not made yet: 0
  int first, count;  // of its list: triangles, ascending
  int depth;
  int failed_splits;  // how many cuts in a row have hardly shortened the list
  int x, y, z;        // in cells of its depth
  float error;        // m, at most, of a computed distance from a triangle of its list
};

/// A cell of the grid over the root, of a side of some triangles.
struct GridCell {
  float distance;  // below that of its centre from the mesh, m; 0: not known yet
  int cell;        // its number; not made yet: 0
};

// Triangles: a list that is no longer is not cut further. Of small meshes many particles share each cell.
inline constexpr int kSmallMesh = 8192, kShortList = 16, kLeafList = 32;
inline constexpr int kMostListed = 64;  // a longer one that cannot be cut is no list
inline constexpr int kDeepest = 18, kMostStuck = 3;

/// A mesh in its own frame, relative to the centre of its box (m), and its cells.
struct OctreeView {
  Vec4<double>* corners;
  const int (*triangles)[3];
  const GridCell* grid;  // the cells of depth `start`, in rows of z, y, x
  int start;
  int leaf;  // triangles: a list that is no longer is not cut further
  const OctreeNode* cells;
  const int* lists;
  double half;      // m, of the root's side
  double per_cell;  // deepest cells a metre
  double side;      // m, of the grid's cells
};

KERNEL bool is_leaf(const OctreeView& mesh, const OctreeNode& cell) {
  return cell.count <= mesh.leaf || cell.failed_splits >= kMostStuck || cell.depth >= kDeepest;
}

/// A number that another thread may be writing.
KERNEL int published(const int& number) {
#if defined(__CUDA_ARCH__)
  return number;
#else
  return __atomic_load_n(&number, __ATOMIC_ACQUIRE);
#endif
}

/// Whose bits say, level by level, in which part of its cell a point lies.
struct OctreeKey {
  int x, y, z;
  bool inside;  // the root
  KERNEL int part(int depth) const {
    const int bit = kDeepest - 1 - depth;
    return (x >> bit & 1) | (y >> bit & 1) << 1 | (z >> bit & 1) << 2;
  }
};

KERNEL OctreeKey path_to(const OctreeView& mesh, const Vector3<double>& p) {
  const double h = mesh.half;
  if (!(p.x > -h && p.x < h && p.y > -h && p.y < h && p.z > -h && p.z < h)) return {0, 0, 0, false};
  const int last = (1 << kDeepest) - 1;
  const auto place = [&](double x) KERNEL_LAMBDA {
    const int i = int((x + h) * mesh.per_cell);
    return i < last ? i : last;
  };
  return {place(p.x), place(p.y), place(p.z), true};
}

KERNEL int place_in_grid(const OctreeView& mesh, const OctreeKey& path) {
  const int bits = kDeepest - mesh.start;
  return ((path.z >> bits) << mesh.start | path.y >> bits) << mesh.start | path.x >> bits;
}

KERNEL Vector3<double> centre_in_grid(const OctreeView& mesh, const OctreeKey& path) {
  const int bits = kDeepest - mesh.start;
  const auto middle = [&](int i) KERNEL_LAMBDA { return ((i >> bits) + 0.5) * mesh.side - mesh.half; };
  return {middle(path.x), middle(path.y), middle(path.z)};
}

/// How far p is from the mesh at least (m), by the distance of its cell's centre: below 0 where that is not known.
KERNEL double least_distance(const OctreeView& mesh, const OctreeKey& path, const Vector3<double>& p) {
  float known;
#if defined(__CUDA_ARCH__)
  known = mesh.grid[place_in_grid(mesh, path)].distance;
#else
  __atomic_load(&mesh.grid[place_in_grid(mesh, path)].distance, &known, __ATOMIC_RELAXED);
#endif
  const Vector3<double> d = p - centre_in_grid(mesh, path);
  return known > 0 ? double(known) - sqrt(dot(d, d)) : -1;
}

/// The last cell at a point; none, or not made yet: 0.
KERNEL int find_leaf(const OctreeView& mesh, const OctreeKey& path) {
  int at = published(mesh.grid[place_in_grid(mesh, path)].cell);
  while (at > 0 && !is_leaf(mesh, mesh.cells[at]))
    at = published(mesh.cells[at].child[path.part(mesh.cells[at].depth)]);
  return at > 0 ? at : 0;
}

KERNEL bool holds(const OctreeNode& cell, const OctreeKey& path) {
  const int bits = kDeepest - cell.depth;
  return path.x >> bits == cell.x && path.y >> bits == cell.y && path.z >> bits == cell.z;
}

/// How far a point is from the walls of a cell that holds it (m).
KERNEL double distance_to_cell_boundary(const OctreeView& mesh, const OctreeNode& cell, const Vector3<double>& p) {
  const double side = 2 * mesh.half / double(1 << cell.depth);
  const auto from = [&](double x, int place) KERNEL_LAMBDA {
    const double d = x + mesh.half - place * side, other = side - d;
    return d < other ? d : other;
  };
  const double x = from(p.x, cell.x), y = from(p.y, cell.y), z = from(p.z, cell.z), xy = x < y ? x : y;
  return xy < z ? xy : z;
}

/// The nearest points of the listed triangles to p, the last one again where a pack has more lanes.
template <class S>
KERNEL NearestPoint<S> nearest_of_listed(const OctreeView& mesh, const Vector3<S>& p, const int* list, int count) {
  constexpr int lanes = int(sizeof(S) / sizeof(double));
  int a[lanes], b[lanes], c[lanes];
  for (int l = 0; l < lanes; ++l) {
    const int* corner = mesh.triangles[list[l < count ? l : count - 1]];
    a[l] = kIndexScale<double> * corner[0], b[l] = kIndexScale<double> * corner[1];
    c[l] = kIndexScale<double> * corner[2];
  }
  Vector3<S> at_a, at_b, at_c;
  S w;
  gather_rows(mesh.corners, a, at_a, w), gather_rows(mesh.corners, b, at_b, w), gather_rows(mesh.corners, c, at_c, w);
  return nearest_point(p, at_a, at_b, at_c);
}

struct ClosestTriangle {
  int triangle = -1;  // none: no list answers
  double distance = 0;
  OnTriangle where{};
};

/// Of triangles begin .. end - 1 with these nearest points, squared distances and features the nearest; of several that
/// are equally near the lowest. `least`: of the squared distances.
KERNEL ClosestTriangle nearest_of(const int* triangle, const double* d2, const double* x, const double* y, const double* z,
                               const double* feature, int begin, int end, double least) {
  const double distance = sqrt(least);
  for (int k = begin; k < end; ++k)  // squares may differ where their roots do not
    if (d2[k] <= least * (1 + 1e-15) && sqrt(d2[k]) == distance)
      return {triangle[k], distance, on_triangle({x[k], y[k], z[k]}, int(feature[k]))};
  return {};
}

/// The nearest triangle to p by the list of a last cell that holds it; of several that are equally near the lowest.
template <class Isa>
KERNEL ClosestTriangle nearest_listed(const OctreeView& mesh, const OctreeNode& cell, const Vector3<double>& p) {
  using S = Lane<double, Isa>;
  constexpr int lanes = kLanes<double, Isa>;
  const int* const list = mesh.lists + cell.first;
  double d2[kMostListed + lanes], x[kMostListed + lanes], y[kMostListed + lanes], z[kMostListed + lanes],
      feature[kMostListed + lanes];
  const Vector3<S> at{S(p.x), S(p.y), S(p.z)};
  for (int k = 0; k < cell.count; k += lanes) {
    const NearestPoint<S> near = nearest_of_listed(mesh, at, list + k, cell.count - k);
    const Vector3<S> d = at - near.q;
    store(dot(d, d), d2 + k), store(near.q.x, x + k), store(near.q.y, y + k), store(near.q.z, z + k);
    store(near.feature, feature + k);
  }
  double least = INFINITY;
  for (int k = 0; k < cell.count; ++k) least = d2[k] < least ? d2[k] : least;
  return nearest_of(list, d2, x, y, z, feature, 0, cell.count, least);
}

}  // namespace malha
