// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/geodesic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "host/mesh/compressed_lists.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kSame = 1e-9;  // relative tolerance: far above rounding, far below relevant differences

/// A part of a side through which straight paths from one pseudo-source enter the side's triangle. In the unfolded
/// plane of the triangle the side runs along x from its first corner; the triangle lies above it, the pseudo-source
/// below.
struct Window {
  int side;                // three times the triangle plus the index of the side in it
  int source;              // point where the paths start
  double from, to;         // m, range on the side
  double x, depth;         // m, the pseudo-source is at (x, -depth)
  double source_distance;  // m, length of the path from the source to the pseudo-source
  double to_pseudo_source(double at) const { return std::hypot(at - x, depth); }
  double shortest() const { return source_distance + to_pseudo_source(std::clamp(x, from, to)); }
};

/// The triangle of a side in the frame of the side, and the shortest path through the side to the opposite corner.
struct UnfoldedTriangle {
  double length = 0, x = 0, y = 0;     // m, of the side; position of the opposite corner
  double nearest = kInfinite, at = 0;  // m, length of that path, and where it crosses the side
};

/// Propagates windows and points in the order of their distances, as in Dijkstra's algorithm (Chen and Han 1990, with
/// the order and the filters of Xin and Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem",
/// 2009).
class WindowPropagation {
 public:
  WindowPropagation(const RestShape& shape, const std::vector<int>& sources)
      : WindowPropagation(shape, shape.mesh(), sources) {}

  Geodesics run() {
    while (!queue_.empty()) {
      const Event event = queue_.top();
      queue_.pop();
      if (event.window >= 0)
        propagate(pop_window(event.window));
      else if (event.distance <= found_.distance[event.point])
        propagate_from(event.point);
    }
    // Rounding may make a distance shorter than the straight line, where a point has one place only.
    for (std::size_t i = 0; i < points_ && !shape_.has_seams(); ++i)
      if (const int s = found_.source[i]; s >= 0)
        found_.distance[i] = std::max(found_.distance[i], shape_.length(static_cast<int>(i), s));
    return std::move(found_);
  }

 private:
  WindowPropagation(const RestShape& shape, const Mesh& mesh, const std::vector<int>& sources)
      : shape_(shape),
        points_(mesh.points.size()),
        triangles_(triangles(mesh)),
        neighbours_(points_,
                    [&](const auto& add) {
                      for (const auto& [a, b] : edges(mesh)) add(a, b), add(b, a);
                      for (const auto& [a, b] : shear(mesh)) add(a, b), add(b, a);
                    }),
        sides_(points_,
               [&](const auto& add) {
                 for (int s = 0; s < sides(); ++s) add(std::min(first(s), last(s)), s);
               }),
        fans_(points_,
              [&](const auto& add) {
                for (int s = 0; s < sides(); ++s) add(opposite(s), s);
              }),
        unfolded_(triangles_.size() * 3),
        queued_(triangles_.size() * 3, -1) {
    for (int s = 0; s < sides(); ++s) unfold(s);
    find_pseudo_sources(mesh);
    found_.distance.assign(points_, kInfinite), found_.source.assign(points_, -1);
    for (const int s : sources) is_pseudo_source_[s] = true, relax(s, 0, s);
  }

  struct Event {
    double distance;
    int point, window;                          // one of them is -1
    bool operator<(const Event& other) const {  // the queue's top is the largest
      return distance != other.distance ? distance > other.distance : window > other.window;
    }
  };

  int sides() const { return static_cast<int>(triangles_.size()) * 3; }
  int first(int side) const { return triangles_[side / 3][side % 3]; }
  int last(int side) const { return triangles_[side / 3][(side % 3 + 1) % 3]; }
  int opposite(int side) const { return triangles_[side / 3][(side % 3 + 2) % 3]; }
  /// The places of first(), last() and opposite() in the side's triangle.
  std::array<Vec3, 3> corners_of(int side) const {
    const int points[3] = {first(side), last(side), opposite(side)};
    std::array<Vec3, 3> X;
    shape_.corners(Element::Triangles, points, X.data());
    return X;
  }
  int next(int side) const { return side / 3 * 3 + (side % 3 + 1) % 3; }

  /// Calls f for the sides of other triangles at the same edge.
  template <class F>
  void for_each_twin(int side, const F& f) const {
    const int low = std::min(first(side), last(side)), high = std::max(first(side), last(side));
    for (const int s : sides_[low])
      if (s / 3 != side / 3 && std::max(first(s), last(s)) == high) f(s);
  }

  /// Finds the points at which shortest paths may turn: on the boundary, on lines, at non-manifold edges, and where the
  /// angles around a point sum to more than a full turn (Mitchell, Mount, Papadimitriou 1987).
  void find_pseudo_sources(const Mesh& mesh) {
    is_pseudo_source_.assign(points_, false);
    std::vector<double> angle(points_, 0);
    for (int s = 0; s < sides(); ++s) {
      int twins = 0;
      for_each_twin(s, [&](int) { ++twins; });
      if (twins != 1) is_pseudo_source_[first(s)] = is_pseudo_source_[last(s)] = true;
      const auto [from, to, beyond] = corners_of(s);
      const Vec3 a = minus(from, beyond), b = minus(to, beyond), n = cross(a, b);
      const double area = norm(n);
      angle[opposite(s)] += std::atan2(area, dot(a, b));
      if (!(area > 1e-12 * (dot(a, a) + dot(b, b))))
        is_pseudo_source_[first(s)] = is_pseudo_source_[last(s)] = is_pseudo_source_[opposite(s)] = true;
    }
    for (std::size_t i = 0; i < points_; ++i)
      if (angle[i] > 2 * std::numbers::pi + kSame || fans_[int(i)].empty()) is_pseudo_source_[i] = true;
    std::vector<Edge> of_faces;
    for (int s = 0; s < sides(); ++s) of_faces.push_back({std::min(first(s), last(s)), std::max(first(s), last(s))});
    std::ranges::sort(of_faces);
    for (const auto& [a, b] : edges(mesh))
      if (!std::ranges::binary_search(of_faces, Edge{std::min(a, b), std::max(a, b)}))
        is_pseudo_source_[a] = is_pseudo_source_[b] = true;
  }

  /// Lowers the distance of point i to d, if it is larger.
  void relax(int i, double d, int source) {
    // Improvements within rounding are ignored: they could circulate for a long time.
    if (!(d < found_.distance[i] - kSame * d)) return;
    found_.distance[i] = d, found_.source[i] = source;
    queue_.push({d, i, -1});
  }

  /// Propagates from a point along the edges, and from a pseudo-source into all triangles around it.
  void propagate_from(int i) {
    const double d = found_.distance[i];
    const int source = found_.source[i];
    for (const int j : neighbours_[i]) relax(j, d + shape_.length(i, j), source);
    if (!is_pseudo_source_[i]) return;
    for (const int s : fans_[i]) {
      const UnfoldedTriangle& triangle = unfolded_[s];
      cross_side({s, source, 0, triangle.length, triangle.x, triangle.y, d});
    }
  }

  /// Unfolds the triangle of a side.
  void unfold(int side) {
    const auto [from, to, beyond] = corners_of(side);
    const Vec3 along = minus(to, from), away = minus(beyond, from);
    const double l = norm(along);
    const Vec3 n = cross(along, away);
    unfolded_[side].length = l;
    if (l > 0) unfolded_[side].x = dot(along, away) / l, unfolded_[side].y = norm(n) / l;
  }

  /// Passes a window on to the triangles beyond its side. `w` is in the frame of the triangle that it leaves, with the
  /// pseudo-source on the side of that triangle.
  void cross_side(const Window& w) {
    const double l = unfolded_[w.side].length;
    if (!(w.depth > 1e-12 * l) || !(w.to - w.from > 1e-12 * l)) return;
    // A window is useless if paths along the side from one of its corners are shorter all over it (Xin and Wang 2009,
    // section 3).
    const double a = found_.distance[first(w.side)], b = found_.distance[last(w.side)];
    if (w.source_distance + w.to_pseudo_source(w.to) > a + w.to ||
        w.source_distance + w.to_pseudo_source(w.from) > b + l - w.from)
      return;
    for_each_twin(w.side, [&](int twin) {
      Window to = w;
      to.side = twin;
      if (first(twin) != first(w.side)) to.from = l - w.to, to.to = l - w.from, to.x = l - w.x;
      enqueue(to, l);
    });
  }

  /// Queues a window, or merges it with a queued one of the same side and pseudo-source (as all are on flat meshes).
  void enqueue(const Window& w, double l) {
    constexpr int kMaxTests = 8;  // flat meshes have no more windows on a side
    int other = queued_[w.side];
    for (int k = 0; k < kMaxTests && other >= 0; ++k, other = next_queued_[other]) {
      Window& o = windows_[other];
      const double size = kSame * (std::abs(w.x) + w.depth + l);
      if (o.source != w.source || o.source_distance != w.source_distance || std::abs(o.x - w.x) > size ||
          std::abs(o.depth - w.depth) > size || w.from > o.to + kSame * l || o.from > w.to + kSame * l)
        continue;
      o.from = std::min(o.from, w.from), o.to = std::max(o.to, w.to);
      return;
    }
    if (free_.empty())
      free_.push_back(static_cast<int>(windows_.size())), windows_.emplace_back(), next_queued_.push_back(-1);
    const int id = free_.back();
    free_.pop_back(), windows_[id] = w;
    next_queued_[id] = queued_[w.side], queued_[w.side] = id;
    queue_.push({w.shortest(), -1, id});
  }

  /// Removes a window from the list of its side.
  Window pop_window(int id) {
    const Window w = windows_[id];
    int* link = &queued_[w.side];
    while (*link != id) link = &next_queued_[*link];
    *link = next_queued_[id];
    free_.push_back(id);
    return w;
  }

  /// Propagates a window through its triangle: to the opposite corner, if it is visible through the window, and to the
  /// two other sides.
  void propagate(const Window& w) {
    UnfoldedTriangle& triangle = unfolded_[w.side];
    const double l = triangle.length, cx = triangle.x, cy = triangle.y;
    if (!(cy > 1e-12 * l)) return;
    const double at =
        w.x + (cx - w.x) * w.depth / (w.depth + cy);  // where the path to the opposite corner crosses the side
    const double slack = 1e-7 * l;
    bool left = w.from<at, right = w.to> at;
    if (at > w.from - slack && at < w.to + slack) {
      const double d = w.source_distance + std::hypot(cx - w.x, cy + w.depth);
      relax(opposite(w.side), d, w.source);
      // Of the windows of a side, only that with the shortest path to the opposite corner continues on both sides of it
      // (Chen and Han 1990).
      if (d < triangle.nearest * (1 - kSame))
        triangle.nearest = d, triangle.at = at;
      else if (d > triangle.nearest * (1 + kSame))
        (at < triangle.at ? right : left) = false;
    }
    // The fraction of another side, from the common corner on, at which a path that crosses this side at distance b
    // from that corner arrives.
    const auto part = [&](double b, double x, double c) {
      const double below = w.depth * c - cy * (b - x);
      return below > 0 ? std::clamp(b * w.depth / below, 0.0, 1.0) : b > 0 ? 1.0 : 0.0;
    };
    // The window on another side is useless if a path from the other corner of this side crosses all its paths and is
    // shorter to the last point.
    const auto is_useful = [&](int other, double from_other, double x, double y) {
      const double length = w.source_distance + std::hypot(x - w.x, y + w.depth);
      return length <= found_.distance[other] + from_other + kSame * l;
    };
    if (left) {  // to the side from the opposite corner to the first one
      const double low = part(w.from, w.x, cx), high = w.to < at ? part(w.to, w.x, cx) : 1.0, side = std::hypot(cx, cy);
      const double x = (cx * (cx - w.x) + cy * (cy + w.depth)) / side;
      const double depth = std::abs(cx * (cy + w.depth) - cy * (cx - w.x)) / side;
      if (is_useful(last(w.side), std::hypot(l - low * cx, low * cy), low * cx, low * cy))
        cross_side({next(next(w.side)), w.source, (1 - high) * side, (1 - low) * side, x, depth, w.source_distance});
    }
    if (right) {  // to the side from the last corner to the opposite one
      const double dx = cx - l, side = std::hypot(dx, cy);
      const double low = part(l - w.to, l - w.x, -dx), high = w.from > at ? part(l - w.from, l - w.x, -dx) : 1.0;
      const double x = ((w.x - l) * dx - w.depth * cy) / side;
      const double depth = std::abs((w.x - l) * cy + w.depth * dx) / side;
      if (is_useful(first(w.side), std::hypot(l + low * dx, low * cy), l + low * dx, low * cy))
        cross_side({next(w.side), w.source, low * side, high * side, x, depth, w.source_distance});
    }
  }

  const RestShape& shape_;
  std::size_t points_;
  std::vector<Triangle> triangles_;
  CompressedLists<int> neighbours_;  // neighbours of a point along edges and diagonals
  CompressedLists<int> sides_;       // sides by the lower of their ends
  CompressedLists<int> fans_;        // sides opposite to a point
  std::vector<bool> is_pseudo_source_;
  std::vector<UnfoldedTriangle> unfolded_;  // of each side
  Geodesics found_;
  std::vector<Window> windows_;
  std::vector<int> queued_, next_queued_, free_;  // a linked list of windows for each side; free entries of windows_
  std::priority_queue<Event> queue_;
};

}  // namespace

Geodesics geodesics(const RestShape& shape, const std::vector<int>& sources) {
  return WindowPropagation(shape, sources).run();
}

}  // namespace malha
