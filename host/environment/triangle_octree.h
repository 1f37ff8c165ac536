// SPDX-License-Identifier: Apache-2.0
// The cells around a mesh that list its nearest triangles (kernels/environment/triangle_octree.h), made where they are
// first needed.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "host/base/pinned_memory.h"
#include "host/environment/embree.h"
#include "kernels/environment/triangle_octree.h"

namespace malha {

class TriangleOctree {
 public:
  /// All outlive this. `half`: of the box around the mesh, whose centre is the origin (m); `skin`: by how much Embree's
  /// distances may be off (m).
  TriangleOctree(const TriangleScene& scene, ReadableVector<Vec4<double>>& corners,
                 const ReadableVector<std::array<int, 3>>& triangles, const Vector3<double>& half, double skin);

  const OctreeView& mesh() const { return mesh_; }

  /// Makes the cells down to the last one at a place; from any thread. False where there is no list: too many triangles
  /// are equally near, or memory for cells is used up.
  bool make(const OctreeKey& key);

  /// Makes the distance of a cell of the grid known, from any thread. False: it was.
  bool measure(const OctreeKey& key);

  /// From one thread, between looks: starts anew when memory for cells is used up. True: no cell is what it was.
  bool reset_if_full();

  std::size_t bytes() const;

 private:
  struct Candidate;
  struct Cube;
  int make(int parent, const Cube& cube, const OctreeKey& key);
  double distance(const Vector3<double>& p, int triangle) const;
  std::vector<int> near(const Cube& cube) const;
  int add(const OctreeNode& cell);
  void clear();

  const TriangleScene& scene_;
  OctreeView mesh_{};
  std::vector<double> error_;       // m, of a computed distance: far from 0 for slivers alone
  double rounding_ = 0, skin_ = 0;  // m
  int most_cells_ = 0, most_listed_ = 0;
  ReadableArray<GridCell> grid_{nullptr, nullptr};
  ReadableMemory memory_ = readable_memory;  // of all that kernels read
  ReadableArray<OctreeNode> cells_;
  ReadableArray<int> lists_;
  std::atomic<int> cells_used_{0};
  std::atomic<long> listed_{0};
  std::atomic<bool> full_{false};
};

}  // namespace malha
