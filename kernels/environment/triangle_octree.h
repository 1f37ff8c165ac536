// SPDX-License-Identifier: Apache-2.0
// Octree of candidate triangles around a mesh: a cell lists all triangles that are closest to any of its points. The
// lists depend on the mesh alone, so that all particles in all substeps use them; a query by a list gives the same
// result as one of all triangles, whichever cells exist.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/simd/rows.h"

namespace malha {

/// A cell: its children (by the signs of x, y, z as bits 0, 1, 2), and its list of triangles. Inner cells keep their
/// lists, because the lists of children are made from them.
struct alignas(64) OctreeNode {
  int child[8];      // cell numbers; 0: not made yet
  int first, count;  // its list: triangles in ascending order
  int depth;
  int failed_splits;  // number of consecutive splits that hardly shortened the list
  int x, y, z;        // position in cells of its depth
  float error;        // m, upper bound of the error of computed distances from listed triangles
};

/// A cell of the grid over the root; its side is that of a few triangles.
struct GridCell {
  float distance;  // lower bound of the distance of its centre from the mesh, m; 0: not known yet
  int cell;        // cell number; 0: not made yet
};

// Numbers of triangles: lists up to kShortList (kLeafList in large meshes) are not split. In small meshes many
// particles share each cell.
inline constexpr int kSmallMesh = 8192, kShortList = 16, kLeafList = 32;
inline constexpr int kMaxListLength = 64;  // a longer list that cannot be split is not used
inline constexpr int kMaxDepth = 18, kMaxFailedSplits = 3;

/// View of the octree of a mesh, in the mesh's frame relative to the centre of its box (m).
struct OctreeView {
  Vec4<double>* corners;
  const int (*triangles)[3];
  const GridCell* grid;  // the cells of depth `start`, in z, y, x order
  int start;
  int leaf;  // triangles: lists up to this length are not split
  const OctreeNode* cells;
  const int* lists;
  double half;      // m, half of the root's side
  double per_cell;  // deepest cells per metre
  double side;      // m, of the grid's cells
};

KERNEL bool is_leaf(const OctreeView& mesh, const OctreeNode& cell) {
  return cell.count <= mesh.leaf || cell.failed_splits >= kMaxFailedSplits || cell.depth >= kMaxDepth;
}

/// Reads a number that another thread may be writing.
KERNEL int published(const int& number) {
#if defined(__CUDA_ARCH__)
  return number;
#else
  return __atomic_load_n(&number, __ATOMIC_ACQUIRE);
#endif
}

/// Octree key of a point: its bits say, level by level, in which child the point lies.
struct OctreeKey {
  int x, y, z;
  bool inside;  // whether the point lies in the root
  KERNEL int child_index(int depth) const {
    const int bit = kMaxDepth - 1 - depth;
    return (x >> bit & 1) | (y >> bit & 1) << 1 | (z >> bit & 1) << 2;
  }
};

KERNEL OctreeKey octree_key(const OctreeView& mesh, const Vector3<double>& p) {
  const double h = mesh.half;
  if (!(p.x > -h && p.x < h && p.y > -h && p.y < h && p.z > -h && p.z < h)) return {0, 0, 0, false};
  const int last = (1 << kMaxDepth) - 1;
  const auto coordinate = [&](double x) KERNEL_LAMBDA {
    const int i = int((x + h) * mesh.per_cell);
    return i < last ? i : last;
  };
  return {coordinate(p.x), coordinate(p.y), coordinate(p.z), true};
}

KERNEL int grid_index(const OctreeView& mesh, const OctreeKey& key) {
  const int bits = kMaxDepth - mesh.start;
  return ((key.z >> bits) << mesh.start | key.y >> bits) << mesh.start | key.x >> bits;
}

KERNEL Vector3<double> grid_cell_centre(const OctreeView& mesh, const OctreeKey& key) {
  const int bits = kMaxDepth - mesh.start;
  const auto middle = [&](int i) KERNEL_LAMBDA { return ((i >> bits) + 0.5) * mesh.side - mesh.half; };
  return {middle(key.x), middle(key.y), middle(key.z)};
}

/// Lower bound of the distance of p from the mesh (m), by the distance of its grid cell's centre; below 0: not known.
KERNEL double distance_lower_bound(const OctreeView& mesh, const OctreeKey& key, const Vector3<double>& p) {
  float bound;
#if defined(__CUDA_ARCH__)
  bound = mesh.grid[grid_index(mesh, key)].distance;
#else
  __atomic_load(&mesh.grid[grid_index(mesh, key)].distance, &bound, __ATOMIC_RELAXED);
#endif
  const Vector3<double> d = p - grid_cell_centre(mesh, key);
  return bound > 0 ? double(bound) - sqrt(dot(d, d)) : -1;
}

/// The leaf that contains a point; 0: none, or not made yet.
KERNEL int find_leaf(const OctreeView& mesh, const OctreeKey& key) {
  int at = published(mesh.grid[grid_index(mesh, key)].cell);
  while (at > 0 && !is_leaf(mesh, mesh.cells[at]))
    at = published(mesh.cells[at].child[key.child_index(mesh.cells[at].depth)]);
  return at > 0 ? at : 0;
}

/// Distance of a point from the boundary of a cell that contains it, m.
KERNEL double distance_to_cell_boundary(const OctreeView& mesh, const OctreeNode& cell, const Vector3<double>& p) {
  const double side = 2 * mesh.half / double(1 << cell.depth);
  const auto from = [&](double x, int cell_coordinate) KERNEL_LAMBDA {
    const double d = x + mesh.half - cell_coordinate * side, other = side - d;
    return d < other ? d : other;
  };
  const double x = from(p.x, cell.x), y = from(p.y, cell.y), z = from(p.z, cell.z), xy = x < y ? x : y;
  return xy < z ? xy : z;
}

/// The closest points to p on `count` listed triangles; further lanes of a pack repeat the last one.
template <class S>
KERNEL NearestPoint<S> closest_points_on(const OctreeView& mesh, const Vector3<S>& p, const int* list, int count) {
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
  int triangle = -1;  // -1: no list answers
  double distance = 0;
  OnTriangle where{};
};

}  // namespace malha
