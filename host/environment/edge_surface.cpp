// SPDX-License-Identifier: Apache-2.0
#include "host/environment/edge_surface.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "host/attachments/object_motion.h"
#include "host/mesh/bounding_box.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

/// Height of one triangle over the plane of the other, relative: below it the edge counts as flat.
constexpr double kFlat = 1e-7;

/// Finds the edges and corners of an object that can touch.
class Features {
 public:
  /// `all`: every one of them can.
  Features(const Mesh& mesh, Sides sides, bool all, int first, EdgeSurface& to)
      : mesh_(mesh), sides_(sides), all_(all), to_(to) {
    begin_ = to.triangles.size();
    for (const Triangle& t : triangles(mesh)) to.triangles.push_back({{t[0], t[1], t[2]}, 1 << 6});
    sharp_.assign(mesh.points.size(), 0), rim_.assign(mesh.points.size(), 0);
    find_edges();
    find_corners();
    for (std::size_t t = begin_; t < to.triangles.size(); ++t)
      for (int& corner : to.triangles[t].corner) corner += first;
  }

 private:
  void find_edges() {
    const auto visit = [&](const auto& add) {
      for (std::size_t t = begin_; t < to_.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) add(to_.triangles[t].from(k), to_.triangles[t].to(k));
    };
    for_each_edge(sorted_sides(mesh_.points.size(), visit), [&](auto first, auto last) {
      const bool two = last - first == 2;
      if (two && !all_ && !can_touch(first[0], first[1])) return;
      to_.triangles[begin_ + first->number / 3].has |= 1 << (3 + first->number % 3);
      ++to_.edges;
      for (const int i : {first->low, first->high}) ++sharp_[i], rim_[i] = rim_[i] || !two;
    });
  }

  /// Returns true if an edge between two triangles can be the first to touch.
  bool can_touch(const Side& a, const Side& b) const {
    const Simplex &s = to_.triangles[begin_ + a.number / 3], &t = to_.triangles[begin_ + b.number / 3];
    const auto opposite = [](const Simplex& of, const Side& side) { return of.corner[(side.number + 2) % 3]; };
    const auto at = [&](int i) { return mesh_.points[i]; };
    const Vec3 n = cross(minus(at(s.corner[1]), at(s.corner[0])), minus(at(s.corner[2]), at(s.corner[0])));
    const Vec3 out = minus(at(opposite(t, b)), at(a.low));
    const double height = dot(n, out), size = std::sqrt(dot(n, n) * dot(out, out));
    if (std::abs(height) <= kFlat * size) {
      // Flat, or folded back onto itself.
      const Vec3 own = minus(at(opposite(s, a)), at(a.low)), along = minus(at(a.high), at(a.low));
      return dot(cross(along, own), cross(along, out)) >= 0;
    }
    const bool wound_alike = a.forward != b.forward;
    return sides_ != Sides::Solid || !wound_alike || height < 0;
  }

  /// A pointed corner has three sharp edges or more; others lie on an edge or between edges.
  void find_corners() {
    std::vector<bool> is_owned(mesh_.points.size(), false);
    for (std::size_t t = begin_; t < to_.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const int i = to_.triangles[t].corner[k];
        if (is_owned[i] || !(all_ || rim_[i] || sharp_[i] >= 3)) continue;
        is_owned[i] = true;
        to_.triangles[t].has |= 1 << k;
        ++to_.corners;
      }
  }

  const Mesh& mesh_;
  Sides sides_;
  bool all_;
  EdgeSurface& to_;
  std::size_t begin_ = 0;
  std::vector<int> sharp_;
  std::vector<unsigned char> rim_;
};

/// Builds the BVH by median splits along the longest side of the bounding box of the triangles' centres.
class BvhBuilder {
 public:
  explicit BvhBuilder(EdgeSurface& surface) : surface_(surface) {
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      Vec3 middle{};
      for (const int i : surface.triangles[t].corner)
        for (int k = 0; k < 3; ++k) middle[k] += surface.points[i][k];
      middles_.push_back(middle), order_.push_back(static_cast<int>(t));
    }
    surface.path.reserve(2 * order_.size());
    build(0, static_cast<int>(order_.size()));
  }

 private:
  BoxNode build(int begin, int end) {
    const std::size_t own = surface_.path.size();
    surface_.path.emplace_back();
    BoxNode node;
    if (end - begin == 1) {
      node = leaf(order_[begin]);
    } else {
      const int axis = longest_side(bounds_of(middles_, std::span(order_).subspan(begin, end - begin)));
      const int middle = (begin + end) / 2;
      std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
        return middles_[a][axis] != middles_[b][axis] ? middles_[a][axis] < middles_[b][axis] : a < b;
      });
      node = build(begin, middle);
      const BoxNode second = build(middle, end);
      for (int k = 0; k < 3; ++k)
        node.low[k] = std::min(node.low[k], second.low[k]), node.high[k] = std::max(node.high[k], second.high[k]);
      node.triangle = -1;
    }
    node.next = static_cast<int>(surface_.path.size());
    return surface_.path[own] = node;
  }

  BoxNode leaf(int triangle) const {
    BoxNode node;
    node.triangle = triangle;
    const auto [low, high] = bounds_of(surface_.points, std::span(surface_.triangles[triangle].corner));
    for (int k = 0; k < 3; ++k) {
      node.low[k] = std::nextafter(static_cast<float>(low[k]), -INFINITY);
      node.high[k] = std::nextafter(static_cast<float>(high[k]), INFINITY);
    }
    return node;
  }

  EdgeSurface& surface_;
  std::vector<Vec3> middles_;
  std::vector<int> order_;
};

}  // namespace

EdgeSurface edge_surface(const std::vector<const EnvironmentMesh*>& objects) {
  EdgeSurface surface;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const Mesh& mesh = objects[o]->mesh;
    Features(mesh, objects[o]->spec.sides, deforms(*objects[o]), static_cast<int>(surface.points.size()), surface);
    surface.points.insert(surface.points.end(), mesh.points.begin(), mesh.points.end());
    surface.object.resize(surface.points.size(), static_cast<int>(o));
  }
  const auto [low, high] = bounds_of(surface.points);
  for (int k = 0; k < 3; ++k) surface.centre[k] = (low[k] + high[k]) / 2;
  for (Vec3& x : surface.points) x = minus(x, surface.centre);
  BvhBuilder{surface};
  return surface;
}

std::vector<std::vector<const EnvironmentMesh*>> edge_groups(const Model& model) {
  std::vector<std::vector<const EnvironmentMesh*>> groups, deforming;
  for (const EnvironmentMesh& mesh : model.environment) {
    if (!mesh.spec.edges) continue;
    if (deforms(mesh)) {
      deforming.push_back({&mesh});
      continue;
    }
    const bool rests = mesh.spec.motion.empty();
    const auto same =
        std::ranges::find_if(groups, [rests](const auto& group) { return rests && group[0]->spec.motion.empty(); });
    if (same == groups.end())
      groups.push_back({&mesh});
    else
      same->push_back(&mesh);
  }
  groups.insert(groups.end(), deforming.begin(), deforming.end());
  return groups;
}

}  // namespace malha
