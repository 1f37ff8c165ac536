#include "host/mesh/geodesic.h"

#include <cmath>
#include <limits>
#include <queue>

#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"

namespace malha {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

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

class March {
 public:
  March(const Mesh& mesh, const std::vector<int>& sources)
      : X_(mesh.points),
        neighbours_(X_.size(),
                    [&](const auto& add) {
                      for (const auto& list : {edges(mesh), shear(mesh)})
                        for (const auto& [a, b] : list) add(a, b), add(b, a);
                    }),
        triangles_(X_.size(), [&](const auto& add) {
          const auto each = [&add](int a, int b, int c) { add(a, Edge{b, c}), add(b, Edge{c, a}), add(c, Edge{a, b}); };
          for (const Quad& q : mesh.faces) {
            each(q[0], q[1], q[2]);
            if (q[3] < 0) continue;
            each(q[0], q[2], q[3]), each(q[0], q[1], q[3]), each(q[1], q[2], q[3]);
          }
        }) {
    found_.distance.assign(X_.size(), kInfinite), found_.source.assign(X_.size(), -1);
    for (const int s : sources) improve(s, 0, s);
  }

  /// Dijkstra's order. A way across a triangle may come after its corner had its turn: then it has another.
  Geodesics run() {
    while (!queue_.empty()) {
      const auto [d, i] = queue_.top();
      queue_.pop();
      if (d > found_.distance[i]) continue;
      const int source = found_.source[i];
      for (const int* j = neighbours_.begin(i); j != neighbours_.end(i); ++j)
        improve(*j, d + distance(X_[i], X_[*j]), source);
      for (const Edge* t = triangles_.begin(i); t != triangles_.end(i); ++t) {
        cross(i, (*t)[0], (*t)[1]);
        cross(i, (*t)[1], (*t)[0]);
      }
    }
    return std::move(found_);
  }

 private:
  void improve(int i, double d, int source) {
    d = std::max(d, distance(X_[i], X_[source]));
    // Not for rounding alone: that could go round for long.
    if (!(d < found_.distance[i] - 1e-9 * d)) return;
    found_.distance[i] = d, found_.source[i] = source;
    queue_.push({d, i});
  }

  /// To corner c from a and b, in the plane with a at the origin and b on the x axis: the source lies below that axis.
  void cross(int a, int b, int c) {
    const int source = found_.source[a];
    if (source < 0 || found_.source[b] != source) return;
    const double base = distance(X_[a], X_[b]), da = found_.distance[a], db = found_.distance[b];
    if (!(base > 0)) return;
    const double sx = (da * da - db * db + base * base) / (2 * base), sy2 = da * da - sx * sx;
    const double ca = distance(X_[a], X_[c]), cb = distance(X_[b], X_[c]);
    const double cx = (ca * ca - cb * cb + base * base) / (2 * base), cy2 = ca * ca - cx * cx;
    if (!(sy2 >= 0) || !(cy2 > 0)) return;
    const double sy = std::sqrt(sy2), cy = std::sqrt(cy2);
    const double at = sx + (cx - sx) * sy / (sy + cy);  // where the straight way passes the side a-b
    if (at < 0 || at > base) return;                    // round a corner: the edges' own way
    improve(c, std::hypot(cx - sx, cy + sy), source);
  }

  const std::vector<Vec3>& X_;
  Around<int> neighbours_;
  Around<Edge> triangles_;
  Geodesics found_;
  struct Farther {
    bool operator()(const std::pair<double, int>& a, const std::pair<double, int>& b) const { return a > b; }
  };
  std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, Farther> queue_;
};

}  // namespace

Geodesics geodesics(const Mesh& mesh, const std::vector<int>& sources) { return March(mesh, sources).run(); }

}  // namespace malha
