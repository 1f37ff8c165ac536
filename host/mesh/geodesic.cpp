// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/geodesic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kSame = 1e-9;  // of the lengths at hand: far above rounding, far below what matters

/// Items of points, one list after the other.
template <class Item>
class Around {
 public:
  /// visit(add) calls add(point, item) for all, and is itself called twice.
  template <class Visit>
  Around(std::size_t points, const Visit& visit) : begin_(points + 1, 0) {
    visit([&](int point, const Item&) { ++begin_[point + 1]; });
    for (std::size_t i = 0; i < points; ++i) begin_[i + 1] += begin_[i];
    items_.resize(begin_[points]);
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    visit([&](int point, const Item& item) { items_[next[point]++] = item; });
  }
  const Item* begin(int point) const { return items_.data() + begin_[point]; }
  const Item* end(int point) const { return items_.data() + begin_[point + 1]; }

 private:
  std::vector<int> begin_;
  std::vector<Item> items_;
};

/// Straight ways through a part of a side into its triangle, from one place in the triangle's unfolded plane. The side
/// runs along x from its first corner; the triangle lies above it, the place below.
struct Window {
  int side;         // three times the triangle plus its place in it
  int source;       // the point where the way starts
  double from, to;  // of the side, m
  double x, depth;  // of the place: (x, -depth)
  double before;    // m: the way from the source to that place
  double to_place(double at) const { return std::hypot(at - x, depth); }
  double shortest() const { return before + to_place(std::clamp(x, from, to)); }
};

/// A triangle as seen from a side, and the shortest way through that side to its far corner.
struct View {
  double length = 0, x = 0, y = 0;     // of the side; where the far corner is, m
  double nearest = kInfinite, at = 0;  // m: the way's length, and where it passes the side
};

/// Windows and points in the order of their distances, as Dijkstra's (Chen and Han 1990, with the order and the
/// filters of Xin and Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", 2009).
class March {
 public:
  March(const Mesh& mesh, const std::vector<int>& sources)
      : X_(mesh.points),
        triangles_(triangles(mesh)),
        neighbours_(X_.size(),
                    [&](const auto& add) {
                      for (const auto& [a, b] : edges(mesh)) add(a, b), add(b, a);
                      for (const auto& [a, b] : shear(mesh)) add(a, b), add(b, a);
                    }),
        sides_(X_.size(),
               [&](const auto& add) {
                 for (int s = 0; s < sides(); ++s) add(std::min(first(s), last(s)), s);
               }),
        fans_(X_.size(),
              [&](const auto& add) {
                for (int s = 0; s < sides(); ++s) add(opposite(s), s);
              }),
        views_(triangles_.size() * 3),
        waiting_(triangles_.size() * 3, -1) {
    for (int s = 0; s < sides(); ++s) measure(s);
    find_turns(mesh);
    found_.distance.assign(X_.size(), kInfinite), found_.source.assign(X_.size(), -1);
    for (const int s : sources) turns_[s] = true, improve(s, 0, s);
  }

  Geodesics run() {
    while (!queue_.empty()) {
      const Event event = queue_.top();
      queue_.pop();
      if (event.window >= 0)
        pass(take(event.window));
      else if (event.distance <= found_.distance[event.point])
        leave(event.point);
    }
    for (std::size_t i = 0; i < X_.size(); ++i)  // rounding
      if (const int s = found_.source[i]; s >= 0)
        found_.distance[i] = std::max(found_.distance[i], distance(X_[i], X_[s]));
    return std::move(found_);
  }

 private:
  struct Event {
    double distance;
    int point, window;                          // one of them
    bool operator<(const Event& other) const {  // the queue's top is the largest
      return distance != other.distance ? distance > other.distance : window > other.window;
    }
  };

  int sides() const { return static_cast<int>(triangles_.size()) * 3; }
  int corner(int side, int k) const { return triangles_[side / 3][(side + k) % 3]; }
  int first(int side) const { return triangles_[side / 3][side % 3]; }
  int last(int side) const { return triangles_[side / 3][(side % 3 + 1) % 3]; }
  int opposite(int side) const { return triangles_[side / 3][(side % 3 + 2) % 3]; }
  int next(int side) const { return side / 3 * 3 + (side % 3 + 1) % 3; }

  /// The other triangles' sides that are this one.
  template <class F>
  void each_twin(int side, const F& f) const {
    const int low = std::min(first(side), last(side)), high = std::max(first(side), last(side));
    for (const int* s = sides_.begin(low); s != sides_.end(low); ++s)
      if (*s / 3 != side / 3 && std::max(first(*s), last(*s)) == high) f(*s);
  }

  /// Where shortest ways may turn: at the rim, on lines, where sides are not shared by two, and where there is more
  /// than a full turn around a point (Mitchell, Mount, Papadimitriou 1987).
  void find_turns(const Mesh& mesh) {
    turns_.assign(X_.size(), false);
    std::vector<double> angle(X_.size(), 0);
    for (int s = 0; s < sides(); ++s) {
      int twins = 0;
      each_twin(s, [&](int) { ++twins; });
      if (twins != 1) turns_[first(s)] = turns_[last(s)] = true;
      const Vec3 a = minus(X_[first(s)], X_[opposite(s)]), b = minus(X_[last(s)], X_[opposite(s)]), n = cross(a, b);
      const double area = norm(n);
      angle[opposite(s)] += std::atan2(area, dot(a, b));
      if (!(area > 1e-12 * (dot(a, a) + dot(b, b)))) turns_[first(s)] = turns_[last(s)] = turns_[opposite(s)] = true;
    }
    for (std::size_t i = 0; i < X_.size(); ++i)
      if (angle[i] > 2 * std::numbers::pi + kSame || fans_.begin(int(i)) == fans_.end(int(i))) turns_[i] = true;
    std::vector<Edge> of_faces;
    for (int s = 0; s < sides(); ++s) of_faces.push_back({std::min(first(s), last(s)), std::max(first(s), last(s))});
    std::sort(of_faces.begin(), of_faces.end());
    for (const auto& [a, b] : edges(mesh))
      if (!std::binary_search(of_faces.begin(), of_faces.end(), Edge{std::min(a, b), std::max(a, b)}))
        turns_[a] = turns_[b] = true;
  }

  void improve(int i, double d, int source) {
    // Not for rounding alone: that could go round for long.
    if (!(d < found_.distance[i] - kSame * d)) return;
    found_.distance[i] = d, found_.source[i] = source;
    queue_.push({d, i, -1});
  }

  /// Along the edges, and where ways turn into all triangles around.
  void leave(int i) {
    const double d = found_.distance[i];
    const int source = found_.source[i];
    for (const int* j = neighbours_.begin(i); j != neighbours_.end(i); ++j)
      improve(*j, d + distance(X_[i], X_[*j]), source);
    if (!turns_[i]) return;
    for (const int* s = fans_.begin(i); s != fans_.end(i); ++s) {
      const View& view = views_[*s];
      send({*s, source, 0, view.length, view.x, view.y, d});
    }
  }

  void measure(int side) {
    const Vec3 along = minus(X_[last(side)], X_[first(side)]), away = minus(X_[opposite(side)], X_[first(side)]);
    const double l = norm(along);
    const Vec3 n = cross(along, away);
    views_[side].length = l;
    if (l > 0) views_[side].x = dot(along, away) / l, views_[side].y = norm(n) / l;
  }

  /// Into the triangles behind a side: `w` as its own triangle sees it, the place on the same side as that.
  void send(const Window& w) {
    const double l = views_[w.side].length;
    if (!(w.depth > 1e-12 * l) || !(w.to - w.from > 1e-12 * l)) return;
    // What a corner's own way is shorter to, all along, leads nowhere (Xin and Wang 2009, section 3).
    const double a = found_.distance[first(w.side)], b = found_.distance[last(w.side)];
    if (w.before + w.to_place(w.to) > a + w.to || w.before + w.to_place(w.from) > b + l - w.from) return;
    each_twin(w.side, [&](int twin) {
      Window to = w;
      to.side = twin;
      if (first(twin) != first(w.side)) to.from = l - w.to, to.to = l - w.from, to.x = l - w.x;
      wait(to, l);
    });
  }

  /// Two parts of a side that are seen from the same place are one (as all are on flat meshes).
  void wait(const Window& w, double l) {
    constexpr int kLook = 8;  // on flat meshes there are no more
    int other = waiting_[w.side];
    for (int k = 0; k < kLook && other >= 0; ++k, other = after_[other]) {
      Window& o = windows_[other];
      const double size = kSame * (std::abs(w.x) + w.depth + l);
      if (o.source != w.source || o.before != w.before || std::abs(o.x - w.x) > size ||
          std::abs(o.depth - w.depth) > size || w.from > o.to + kSame * l || o.from > w.to + kSame * l)
        continue;
      o.from = std::min(o.from, w.from), o.to = std::max(o.to, w.to);
      return;
    }
    if (free_.empty())
      free_.push_back(static_cast<int>(windows_.size())), windows_.emplace_back(), after_.push_back(-1);
    const int id = free_.back();
    free_.pop_back(), windows_[id] = w;
    after_[id] = waiting_[w.side], waiting_[w.side] = id;
    queue_.push({w.shortest(), -1, id});
  }

  Window take(int id) {
    const Window w = windows_[id];
    int* link = &waiting_[w.side];
    while (*link != id) link = &after_[*link];
    *link = after_[id];
    free_.push_back(id);
    return w;
  }

  /// To the far corner, if it is seen through the window, and to the two other sides.
  void pass(const Window& w) {
    View& view = views_[w.side];
    const double l = view.length, cx = view.x, cy = view.y;
    if (!(cy > 1e-12 * l)) return;
    const double at = w.x + (cx - w.x) * w.depth / (w.depth + cy);  // where the way to the far corner passes the side
    const double slack = 1e-7 * l;
    bool left = w.from<at, right = w.to> at;
    if (at > w.from - slack && at < w.to + slack) {
      const double d = w.before + std::hypot(cx - w.x, cy + w.depth);
      improve(opposite(w.side), d, w.source);
      // Of ways to a corner through one side only the shortest goes on to both sides of it (Chen and Han 1990).
      if (d < view.nearest * (1 - kSame))
        view.nearest = d, view.at = at;
      else if (d > view.nearest * (1 + kSame))
        (at < view.at ? right : left) = false;
    }
    // How far along another side, from its near corner on, a way through `b` from that corner arrives.
    const auto part = [&](double b, double x, double c) {
      const double below = w.depth * c - cy * (b - x);
      return below > 0 ? std::clamp(b * w.depth / below, 0.0, 1.0) : b > 0 ? 1.0 : 0.0;
    };
    // Where ways from this side's other corner cross them all and are shorter to the last, they lead nowhere.
    const auto leads = [&](int other, double from_other, double x, double y) {
      const double way = w.before + std::hypot(x - w.x, y + w.depth);
      return way <= found_.distance[other] + from_other + kSame * l;
    };
    if (left) {  // to the side from the far corner to the first
      const double low = part(w.from, w.x, cx), high = w.to < at ? part(w.to, w.x, cx) : 1.0, side = std::hypot(cx, cy);
      const double x = (cx * (cx - w.x) + cy * (cy + w.depth)) / side;
      const double depth = std::abs(cx * (cy + w.depth) - cy * (cx - w.x)) / side;
      if (leads(last(w.side), std::hypot(l - low * cx, low * cy), low * cx, low * cy))
        send({next(next(w.side)), w.source, (1 - high) * side, (1 - low) * side, x, depth, w.before});
    }
    if (right) {  // to the side from the last corner to the far one
      const double dx = cx - l, side = std::hypot(dx, cy);
      const double low = part(l - w.to, l - w.x, -dx), high = w.from > at ? part(l - w.from, l - w.x, -dx) : 1.0;
      const double x = ((w.x - l) * dx - w.depth * cy) / side;
      const double depth = std::abs((w.x - l) * cy + w.depth * dx) / side;
      if (leads(first(w.side), std::hypot(l + low * dx, low * cy), l + low * dx, low * cy))
        send({next(w.side), w.source, low * side, high * side, x, depth, w.before});
    }
  }

  const std::vector<Vec3>& X_;
  std::vector<Triangle> triangles_;
  Around<int> neighbours_;  // of a point, along edges
  Around<int> sides_;       // by the lower of their ends
  Around<int> fans_;        // the sides opposite to a point
  std::vector<bool> turns_;
  std::vector<View> views_;  // of each side
  Geodesics found_;
  std::vector<Window> windows_;
  std::vector<int> waiting_, after_, free_;  // a list a side
  std::priority_queue<Event> queue_;
};

}  // namespace

Geodesics geodesics(const Mesh& mesh, const std::vector<int>& sources) { return March(mesh, sources).run(); }

}  // namespace malha
