// SPDX-License-Identifier: Apache-2.0
// Closest-point index of a triangle mesh: signed closest points, crossings of paths, and bounds of the distance, in the
// mesh's frame. Candidates come from an octree with lists of triangles and, where that has none, from Embree, which
// computes in float; the arithmetic on them is in double. Which of both answers makes no difference to the bits.
#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "host/base/pinned_memory.h"
#include "host/environment/embree.h"
#include "host/environment/triangle_octree.h"
#include "kernels/environment/closest_point_index_view.h"
#include "malha/mesh.h"

namespace malha {

struct Crossing {
  bool hit = false;
  Point q{};
  Point normal{};  // unit, of the face
};

class ClosestPointIndex {
 public:
  /// `mesh` has faces. Normals are angle-weighted pseudonormals (Baerentzen, Aanaes 2005, "Signed distance computation
  /// using the angle weighted pseudonormal"): that of the closest feature tells inside from outside without error, face
  /// normals do not.
  ClosestPointIndex(const Device& device, const Mesh& mesh);

  /// The nearest surface point within `radius` of a (both in the mesh's frame, m). A triangle that is known to be near
  /// makes the search short and changes nothing else.
  ClosestPoint closest(const Point& a, double radius, int known_near = -1) const;

  /// The view for kernels that do not use Embree.
  const ClosestPointIndexView& view() const { return view_; }

  /// Makes the octree leaf of a, from any thread; null where no list is usable.
  const OctreeNode* make_leaf(const Point& a) const {
    const OctreeKey key = octree_key(view_.cells, view_.relative_to_centre(a));
    return key.inside && octree_->make(key) ? view_.leaf_of(a) : nullptr;
  }
  /// Lower bound of the distance of a by a grid over the mesh's box, which is measured where it is not known yet; below
  /// 0: none.
  double distance_lower_bound(const Point& a) const {
    if (const double known = view_.known_lower_bound(a); known >= 0) return known;
    const OctreeKey key = octree_key(view_.cells, view_.relative_to_centre(a));
    if (key.inside) octree_->measure(key);
    return view_.known_lower_bound(a);
  }
  /// Resets the octree when its memory is used up. Returns true if it was reset.
  bool reset_if_full() {
    if (!octree_->reset_if_full()) return false;
    view_.cells = octree_->mesh();
    return true;
  }

  /// The first crossing on the path from a to b and `beyond` metres further. With front_only, crossings from behind a
  /// face do not count and do not hide what lies behind them. A path that passes the boundary by less than the skin may
  /// count.
  Crossing crossing(const Point& a, const Point& b, double beyond, bool front_only) const;

  double box_distance(const Point& a) const { return view_.box_distance(a); }
  double diagonal() const { return view_.diagonal(); }
  int triangles() const { return static_cast<int>(triangles_.size()); }
  std::size_t bytes() const;
  std::size_t cell_bytes() const { return octree_->bytes(); }
  /// Number of queries of the whole mesh since the start.
  long long queries() const { return queries_->load(); }

 private:
  /// The first crossing from `start` (relative to the centre) over `far` metres. The ray starts a skin earlier, since
  /// rays that start on a surface miss it half the time.
  Crossing along(const Point& start, const Point& direction, double far, bool front_only) const;

  Point point(int i) const { return points_[i].xyz(); }
  ReadableVector<Vec4<double>> points_;  // relative to the centre, so that float is fine wherever the mesh lies
  ReadableVector<Triangle> triangles_;
  ReadableVector<Point> face_normals_, corner_normals_;
  ReadableVector<std::array<Point, 3>> edge_normals_;
  ReadableVector<std::array<bool, 3>> rim_edges_;
  ReadableVector<unsigned char> rim_corners_, needles_;
  double skin_ = 0;
  ClosestPointIndexView view_{};
  std::unique_ptr<TriangleScene> scene_;
  std::unique_ptr<TriangleOctree> octree_;
  std::unique_ptr<std::atomic<long long>> queries_ = std::make_unique<std::atomic<long long>>(0);
};

}  // namespace malha
