// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/polygons.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/mesh/bounding_box.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"

namespace malha {
namespace {

using Point = std::array<double, 2>;

constexpr double kZeroArea = 1e-12;  // area over the square of the diagonal of the face's bounding box
constexpr double kApart = 0.01;      // distance over the shortest side of a quad

/// Twice the signed area of a triangle.
double orientation(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// The squared distance of two points.
double squared(const Point& a, const Point& b) { return (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]); }

/// A face in the coordinates of its best-fit plane.
struct FlatFace {
  std::vector<Point> points;  // its corners
  double zero = 0;            // twice the area up to which a triangle has none
  bool has_area = false;      // the face as a whole has an area
  bool has_triangles = false;

  int next(int i) const { return i + 1 < static_cast<int>(points.size()) ? i + 1 : 0; }
};

FlatFace flatten(const std::vector<Vec3>& points, const std::vector<int>& corners) {
  FlatFace flat;
  const Vec3& origin = points[corners[0]];
  Vec3 newell{}, largest{};
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3 n = normal(origin, points[corners[i - 1]], points[corners[i]]);
    for (int k = 0; k < 3; ++k) newell[k] += n[k];
    if (norm(n) > norm(largest)) largest = n;
  }
  const auto [low, high] = bounds_of(points, corners);
  flat.zero = kZeroArea * squared_distance(low, high);
  flat.has_area = norm(newell) > flat.zero;
  flat.has_triangles = norm(largest) > flat.zero;
  const Vec3 n = flat.has_area ? newell : largest;
  const double length = norm(n);
  if (!(length > 0)) {
    flat.points.resize(corners.size());
    return flat;
  }
  int axis = 0;  // along which the normal is smallest
  for (int k = 1; k < 3; ++k)
    if (std::abs(n[k]) < std::abs(n[axis])) axis = k;
  Vec3 e{};
  e[axis] = 1;
  Vec3 u = cross(e, n);
  const double across = norm(u);
  for (double& x : u) x /= across;
  Vec3 v = cross(n, u);
  for (double& x : v) x /= length;
  for (const int corner : corners) {
    const Vec3 r = minus(points[corner], origin);
    flat.points.push_back({dot(r, u), dot(r, v)});
  }
  return flat;
}

/// Sweeps over the sides in the order of their lowest abscissas, and compares each with those that begin before it
/// ends.
std::array<int, 2> crossing_sides(const FlatFace& face) {
  const auto& p = face.points;
  const auto count = static_cast<int>(p.size());
  const auto begin = [&](int i) { return std::min(p[i][0], p[face.next(i)][0]); };
  const auto end = [&](int i) { return std::max(p[i][0], p[face.next(i)][0]); };
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](int i, int j) { return std::pair(begin(i), i) < std::pair(begin(j), j); });
  const auto apart = [&](double a, double b) {
    return (a > face.zero && b < -face.zero) || (a < -face.zero && b > face.zero);
  };
  for (int s = 0; s < count; ++s)
    for (int t = s + 1; t < count && begin(order[t]) <= end(order[s]); ++t) {
      const auto [i, j] = std::minmax(order[s], order[t]);
      if (face.next(i) == j || face.next(j) == i) continue;
      const Point &a = p[i], &b = p[face.next(i)], &c = p[j], &d = p[face.next(j)];
      if (apart(orientation(a, b, c), orientation(a, b, d)) && apart(orientation(c, d, a), orientation(c, d, b)))
        return {i, j};
    }
  return {-1, -1};
}

/// Ear clipping of a face whose sides do not cross. An ear is a convex corner whose triangle with its neighbours has no
/// other corner inside or on it. The corner that blocks an ear is remembered: the ear is classified again when that is
/// clipped.
class EarClipper {
 public:
  explicit EarClipper(const FlatFace& face)
      : face_(face), count_(static_cast<int>(face.points.size())), previous_(count_), next_(count_), ears_(count_) {
    for (int i = 0; i < count_; ++i) next_[i] = face.next(i), previous_[face.next(i)] = i;
  }

  /// The triangles as indices of corners; empty if it fails.
  std::vector<Triangle> clip() {
    std::vector<Triangle> found;
    classify_all();
    while (clipped_ + 2 < count_) {
      int best = -1;
      for (int i = 0; i < count_; ++i)
        if (ears_[i].state == State::Ear && (best < 0 || ears_[i].shape > ears_[best].shape)) best = i;
      if (best < 0) {
        if (strictness_ == Strictness::ZeroAreas) return {};
        strictness_ = strictness_ == Strictness::Apart ? Strictness::Touching : Strictness::ZeroAreas;
        classify_all();
        continue;
      }
      found.push_back({previous_[best], best, next_[best]});
      clip_off(best);
    }
    return found;
  }

 private:
  enum class State { None, Ear, Blocked, Clipped };
  /// Conditions for an ear. At first no other corner may touch it; then other corners may lie on its sides within
  /// rounding; at last it may have no area.
  enum class Strictness { Apart, Touching, ZeroAreas };
  struct Corner {
    State state = State::None;
    int blocker = -1;
    double shape = 0;  // twice the area over the square of the longest side
  };

  void classify_all() {
    for (int i = 0; i < count_; ++i)
      if (ears_[i].state != State::Clipped) classify(i);
  }

  void classify(int tip) {
    const int before = previous_[tip], after = next_[tip];
    const Point &a = face_.points[before], &b = face_.points[tip], &c = face_.points[after];
    const double area = orientation(a, b, c);
    Corner& ear = ears_[tip];
    ear.state = State::None;
    if (strictness_ == Strictness::ZeroAreas ? area < -face_.zero : area <= face_.zero) return;
    ear.shape = area / std::max({squared(a, b), squared(b, c), squared(c, a)});
    const double inside = strictness_ == Strictness::Apart ? -face_.zero : face_.zero;
    for (int i = next_[after]; i != before; i = next_[i]) {
      const Point& p = face_.points[i];
      if (p == a || p == b || p == c) continue;  // the corners of sides that lead to a hole and back occur twice
      if (orientation(a, b, p) < inside || orientation(b, c, p) < inside || orientation(c, a, p) < inside) continue;
      ear.state = State::Blocked, ear.blocker = i;
      return;
    }
    ear.state = State::Ear;
  }

  void clip_off(int tip) {
    const int before = previous_[tip], after = next_[tip];
    next_[before] = after, previous_[after] = before;
    ears_[tip].state = State::Clipped, ++clipped_;
    classify(before), classify(after);
    for (int i = 0; i < count_; ++i)
      if (ears_[i].state == State::Blocked && ears_[i].blocker == tip) classify(i);
  }

  const FlatFace& face_;
  int count_, clipped_ = 0;  // number of corners, and of those that are clipped
  std::vector<int> previous_, next_;
  std::vector<Corner> ears_;
  Strictness strictness_ = Strictness::Apart;
};

/// True if a side of a quad and the opposite one, which cross in its best-fit plane, are apart in space by more than a
/// hundredth of its shortest side; those of a flat quad are apart by rounding only.
bool are_apart_in_space(const std::vector<Vec3>& points, const std::vector<int>& corners, int side) {
  const auto corner = [&](int k) -> const Vec3& { return points[corners[(side + k) % 4]]; };
  double shortest = squared_distance(corner(3), corner(0));
  for (int k = 0; k < 3; ++k) shortest = std::min(shortest, squared_distance(corner(k), corner(k + 1)));
  const Vec3 across = cross(minus(corner(1), corner(0)), minus(corner(3), corner(2)));
  return std::abs(dot(across, minus(corner(2), corner(0)))) > kApart * std::sqrt(shortest) * norm(across);
}

/// A fan from the first corner.
std::vector<Triangle> fan(int corners) {
  std::vector<Triangle> found;
  for (int i = 2; i < corners; ++i) found.push_back({0, i - 1, i});
  return found;
}

}  // namespace

std::array<int, 2> crossing_sides(const std::vector<Vec3>& points, const std::vector<int>& corners) {
  const auto [i, j] = crossing_sides(flatten(points, corners));
  if (i >= 0 && corners.size() == 4 && are_apart_in_space(points, corners, i)) return {-1, -1};
  return {i, j};
}

std::vector<Triangle> triangulate(const std::vector<Vec3>& points, const std::vector<int>& corners) {
  const auto count = static_cast<int>(corners.size());
  std::vector<Triangle> found = fan(count);
  if (const FlatFace face = flatten(points, corners); count > 3 && face.has_triangles) {
    if (!face.has_area || crossing_sides(face)[0] >= 0) return {};
    const auto& p = face.points;
    const bool valid = std::ranges::all_of(
        found, [&](const Triangle& t) { return orientation(p[t[0]], p[t[1]], p[t[2]]) > face.zero; });
    if (!valid) found = EarClipper(face).clip();
  }
  for (Triangle& triangle : found)
    for (int& corner : triangle) corner = corners[corner];
  return found;
}

Polygons polygons_of(const std::vector<Quad>& faces) {
  Polygons polygons;
  for (const Quad& face : faces) polygons.add(std::span<const int>(face).first(is_triangle(face) ? 3 : 4));
  return polygons;
}

void add_faces(const Polygons& polygons, Mesh& mesh, const std::string& file, std::vector<Quad>* added) {
  mesh.faces.reserve(mesh.faces.size() + polygons.count());
  std::vector<int> corners;
  int begin = 0;
  const auto append = [&](const Quad& face) {
    mesh.faces.push_back(face);
    if (!added) return;
    Quad numbers{-1, -1, -1, -1};
    for (int k = 0; k < 4; ++k)
      if (face[k] >= 0) numbers[k] = begin + static_cast<int>(std::ranges::find(corners, face[k]) - corners.begin());
    added->push_back(numbers);
  };
  std::string place, found;  // of the first polygon without a triangulation
  int faults = 0;
  for (std::size_t f = 0; f < polygons.count(); ++f) {
    const std::span<const int> polygon = polygons.corners_of(f);
    corners.assign(polygon.begin(), polygon.end()), begin = polygons.begin[f];
    if (corners.size() == 3) {
      append({corners[0], corners[1], corners[2], -1});
      continue;
    }
    if (corners.size() > 4) {
      const std::vector<Triangle> triangles = triangulate(mesh.points, corners);
      for (const auto& [a, b, c] : triangles) append({a, b, c, -1});
      if (!triangles.empty()) continue;
    }
    const auto [i, j] = crossing_sides(mesh.points, corners);
    if (i < 0 && corners.size() == 4) {
      append({corners[0], corners[1], corners[2], corners[3]});
      continue;
    }
    if (++faults > 1) continue;
    const auto side = [&](int k) {
      return std::to_string(corners[k]) + "-" + std::to_string(corners[(k + 1) % corners.size()]);
    };
    place = (polygons.line.empty() ? "" : "line " + std::to_string(polygons.line[f]) + ", ") + "face " +
            std::to_string(f) + " (0-based)";
    found = "a face of " + std::to_string(corners.size()) + " corners " +
            (i < 0 ? "that folds onto itself"
                   : "whose sides " + side(i) + " and " + side(j) + " (vertices, 0-based) cross");
  }
  if (faults > 0)
    refuse(file, place, found + " (faces like it: " + std::to_string(faults) + ")",
           "faces whose sides meet at their corners only");
}

}  // namespace malha
