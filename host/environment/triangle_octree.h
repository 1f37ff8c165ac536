// SPDX-License-Identifier: Apache-2.0
// Octree of candidate triangles (kernels/environment/triangle_octree.h): builds cells when they are first needed.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <memory_resource>
#include <vector>

#include "host/base/pinned_memory.h"
#include "host/environment/embree.h"
#include "kernels/environment/triangle_octree.h"

namespace malha {

class TriangleOctree {
 public:
  /// The arguments outlive the octree. `half`: half size of the mesh's bounding box, whose centre is the origin (m);
  /// `skin`: error bound of Embree's distances (m).
  TriangleOctree(const TriangleScene& scene, ReadableVector<Vec4<double>>& corners,
                 const ReadableVector<std::array<int, 3>>& triangles, const Vector3<double>& half, double skin);

  const OctreeView& mesh() const { return mesh_; }

  /// Makes the cells down to the leaf that contains a point; from any thread. Returns false if there is no usable list:
  /// too many triangles are equally near, or the memory for cells is used up.
  bool make(const OctreeKey& key);

  /// Computes the distance of a grid cell unless it is known, from any thread.
  void measure(const OctreeKey& key);

  /// Resets the octree if its memory is used up; from one thread, between queries. Returns true if all cells are gone.
  bool reset_if_full();

  std::size_t bytes() const;

 private:
  struct Candidate;
  struct Cube;
  int make(int parent, const Cube& cube, const OctreeKey& key);
  double distance(const Vector3<double>& p, int triangle) const;
  std::pmr::vector<int> candidates_for(const Cube& cube, std::pmr::memory_resource& memory) const;
  int add(const OctreeNode& cell);
  void clear();

  const TriangleScene& scene_;
  OctreeView mesh_{};
  std::vector<double> error_;       // m, of computed distances to each triangle; large for slivers alone
  double rounding_ = 0, skin_ = 0;  // m
  int max_cells_ = 0, max_listed_ = 0;
  ReadableArray<GridCell> grid_{nullptr, nullptr};
  ReadableMemory memory_ = readable_memory;  // where all data that kernels read is allocated
  ReadableArray<OctreeNode> cells_;
  ReadableArray<int> lists_;
  std::atomic<int> cells_used_{0};
  std::atomic<long> listed_{0};
  std::atomic<bool> full_{false};
};

}  // namespace malha
