// SPDX-License-Identifier: Apache-2.0
// Batch of closest-triangle queries, each point with a list of candidates of its own: point-triangle pairs fill packs,
// so that short lists leave no lane empty, and memory is prefetched. A batch of one point answers a single query.
#pragma once
#include "kernels/environment/feature_cache.h"
#include "kernels/parallel/compute.h"
#include "kernels/simd/rows.h"

namespace malha {

/// The default limits let the batch fit in the L1 cache.
template <class Isa, int kPoints = 64, int kPairs = 256>
class PointTriangleBatch {
 public:
  KERNEL PointTriangleBatch(const OctreeView& mesh) : mesh_(mesh) {}

  KERNEL bool has_capacity(const OctreeNode* leaf) const {
    return points_ < kPoints && pairs_ + (leaf ? leaf->count : 0) <= kPairs;
  }

  /// Adds a point and the list of its leaf; null: no list.
  KERNEL void add(const Vector3<double>& p, const OctreeNode* leaf) {
    if (leaf)
      add(p, mesh_.lists + leaf->first, leaf->count);
    else
      add(p, nullptr, 0);
  }
  /// Adds a point. `list`: at most kMaxListLength triangles, in ascending order.
  KERNEL void add(const Vector3<double>& p, const int* list, int count) {
    position_[points_] = {p.x, p.y, p.z, 0};
    first_[points_] = pairs_;
    for (int k = 0; k < count; ++k, ++pairs_) {
      triangle_[pairs_] = list[k], point_[pairs_] = kIndexScale<double> * points_;
      prefetch(mesh_.triangles + list[k]);
    }
    first_[++points_] = pairs_;
  }

  /// Computes all distances; further lanes of the last pack repeat the last pair.
  KERNEL void measure() {
    if (pairs_ == 0) return;
    for (int k = pairs_; k < pairs_ + lanes - 1; ++k)
      triangle_[k] = triangle_[pairs_ - 1], point_[k] = point_[pairs_ - 1];
    for (int k = 0; k < pairs_; ++k) {
      const int* corner = mesh_.triangles[triangle_[k]];
      for (int c = 0; c < 3; ++c) prefetch(mesh_.corners + corner[c]);
    }
    for (int k = 0; k < pairs_; k += lanes) {
      Vector3<S> p;
      S w;
      gather_rows(position_, point_ + k, p, w);
      const NearestPoint<S> near = closest_points_on(mesh_, p, triangle_ + k, lanes);
      const Vector3<S> d = p - near.q;
      store(dot(d, d), d2_ + k), store(near.q.x, x_ + k), store(near.q.y, y_ + k), store(near.q.z, z_ + k);
      store(near.feature, feature_ + k);
    }
  }

  /// The closest triangle to the `which`th point; of equally near ones the lowest.
  KERNEL ClosestTriangle nearest(int which) const {
    const int begin = first_[which], end = first_[which + 1];
    double least = INFINITY;
    for (int k = begin; k < end; ++k) least = d2_[k] < least ? d2_[k] : least;
    const double distance = sqrt(least);
    for (int k = begin; k < end; ++k)  // squares may differ where their roots do not
      if (d2_[k] <= least * (1 + 1e-15) && sqrt(d2_[k]) == distance)
        return {triangle_[k], distance, on_triangle({x_[k], y_[k], z_[k]}, int(feature_[k]))};
    return {};
  }

  /// Radius (m) around the `which`th point within which its closest feature stays the same; below 0: none. `wall`:
  /// distance from the boundary of the cell; `error`: of computed distances.
  KERNEL double validity_radius(int which, const ClosestTriangle& near, double wall, double error) const {
    const FeatureValidityRadius validity(mesh_, position_[which].xyz(), near, error);
    double radius = wall - error;
    for (int k = first_[which]; k < first_[which + 1] && radius > 0; ++k) {
      const double margin = validity.radius_for(triangle_[k], {x_[k], y_[k], z_[k]}, d2_[k], radius);
      if (!(margin >= radius)) radius = margin > 0 ? margin : -1;
    }
    return radius;
  }

 private:
  using S = Lane<double, Isa>;
  static constexpr int lanes = kLanes<double, Isa>;

  OctreeView mesh_;
  int points_ = 0, pairs_ = 0;
  int first_[kPoints + 1];
  alignas(64) Vec4<double> position_[kPoints];
  int triangle_[kPairs + lanes], point_[kPairs + lanes];
  double d2_[kPairs + lanes], x_[kPairs + lanes], y_[kPairs + lanes], z_[kPairs + lanes], feature_[kPairs + lanes];
};

/// Answers one query by the list of an octree leaf.
template <class Isa>
using LeafQuery = PointTriangleBatch<Isa, 1, kMaxListLength>;

}  // namespace malha
