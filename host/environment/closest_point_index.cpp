// SPDX-License-Identifier: Apache-2.0
#include "host/environment/closest_point_index.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/mesh/bounding_box.h"
#include "host/mesh/topology.h"

namespace malha {

namespace {

constexpr double kNeedle = 1e-3;  // ratio of height to longest edge

Point unit(const Point& a) {
  const double l = norm(a);
  return l > 0 ? a * (1 / l) : a;
}

std::array<float, 3> to_float(const Point& a) { return {float(a.x), float(a.y), float(a.z)}; }

}  // namespace

ClosestPointIndex::ClosestPointIndex(const Device& device, const Mesh& mesh) {
  for (const Triangle& t : malha::triangles(mesh)) triangles_.push_back(t);
  const auto [low, high] = bounds_of(mesh.points);
  view_.centre = {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
  view_.half = Point{high[0], high[1], high[2]} - view_.centre;
  skin_ = 1e-5 * norm(view_.half);  // some 100 roundings of float at the far points of the mesh

  std::vector<std::array<float, 3>> for_embree;
  for (const Vec3& x : mesh.points) {
    const Point at = Point{x[0], x[1], x[2]} - view_.centre;
    points_.push_back({at.x + 0, at.y + 0, at.z + 0, 0});  // turns -0 into 0, as packs do
    for_embree.push_back(to_float(at));
  }
  scene_ = std::make_unique<TriangleScene>(device, for_embree, triangles_);
  octree_ = std::make_unique<TriangleOctree>(*scene_, points_, triangles_, view_.half, skin_);

  corner_normals_.assign(points_.size(), Point{});
  std::map<std::pair<int, int>, std::pair<Point, int>> edges;  // sum of normals, number of faces
  for (const Triangle& t : triangles_) {
    const Point a = point(t[0]);
    const Point ab = point(t[1]) - a, ac = point(t[2]) - a, of_area = cross(ab, ac), normal = unit(of_area);
    const double longest = std::max({norm(ab), norm(ac), norm(ab - ac)});
    face_normals_.push_back(normal);
    needles_.push_back(!(norm(of_area) > kNeedle * longest * longest));
    for (int k = 0; k < 3; ++k) {
      const Point here = point(t[k]);
      const Point u = unit(point(t[(k + 1) % 3]) - here), v = unit(point(t[(k + 2) % 3]) - here);
      const double angle = std::acos(std::clamp(dot(u, v), -1.0, 1.0));
      corner_normals_[t[k]] = corner_normals_[t[k]] + normal * angle;
      auto& edge = edges[std::minmax(t[k], t[(k + 1) % 3])];
      edge.first = edge.first + normal;
      ++edge.second;
    }
  }
  for (Point& n : corner_normals_) n = unit(n);
  rim_corners_.assign(points_.size(), 0);
  for (const Triangle& t : triangles_) {
    std::array<Point, 3> normals;
    std::array<bool, 3> rim;
    for (int k = 0; k < 3; ++k) {
      const auto& edge = edges[std::minmax(t[k], t[(k + 1) % 3])];
      normals[k] = unit(edge.first);
      rim[k] = edge.second == 1;
      if (rim[k]) rim_corners_[t[k]] = rim_corners_[t[(k + 1) % 3]] = 1;
    }
    edge_normals_.push_back(normals);
    rim_edges_.push_back(rim);
  }
  view_.cells = octree_->mesh();
  view_.face_normals = face_normals_.data(), view_.corner_normals = corner_normals_.data();
  view_.edge_normals = reinterpret_cast<const Point(*)[3]>(edge_normals_.data());
  view_.rim_edges = reinterpret_cast<const bool(*)[3]>(rim_edges_.data());
  view_.rim_corners = rim_corners_.data(), view_.needles = needles_.data();
}

ClosestPoint ClosestPointIndex::closest(const Point& a, double radius, int known_near) const {
  const Point p = a - view_.centre;
  int nearest = -1;
  double least = radius;
  // Embree rounds the query to float: its radius is larger by the rounding, and the test here decides.
  const double slack = skin_ + 1e-6 * norm(p);
  const auto test = [&](int t) {
    const Triangle& c = triangles_[t];
    const double distance = norm(p - nearest_on_triangle(p, point(c[0]), point(c[1]), point(c[2])).q);
    // Equally near triangles (a shared edge or corner): the lowest one, whatever the order of traversal.
    if (distance < least || (distance == least && nearest >= 0 && t < nearest)) nearest = t, least = distance;
    return static_cast<float>(least + slack);
  };
  const float start = known_near < 0 ? static_cast<float>(radius + slack) : test(known_near);
  point_query(*scene_, to_float(p), start, test);
  queries_->fetch_add(1, std::memory_order_relaxed);
  if (nearest < 0) return {};
  const Triangle& c = triangles_[nearest];
  return view_.closest_point_on(
      view_.feature({nearest, least, nearest_on_triangle(p, point(c[0]), point(c[1]), point(c[2]))}), a);
}

Crossing ClosestPointIndex::crossing(const Point& a, const Point& b, double beyond, bool front_only) const {
  const Point path = b - a;
  const double l = norm(path);
  if (!(l > 0)) return {};
  const Point direction = path * (1 / l);
  const Point start = a - view_.centre;
  const Crossing straight = along(start, direction, l + beyond, front_only);
  if (straight.hit) return straight;
  // Embree's rays leak at vertices, one in a hundred to a thousand: a second one, a skin beside the first, does not.
  const Point other = std::abs(direction.x) < 0.5 ? Point{1, 0, 0} : Point{0, 1, 0};
  return along(start + unit(cross(direction, other)) * skin_, direction, l + beyond, front_only);
}

Crossing ClosestPointIndex::along(const Point& start, const Point& direction, double far, bool front_only) const {
  // Only what lies within the mesh's bounding sphere, so that float is fine however long the path is.
  const double middle = -dot(start, direction), radius = norm(view_.half) + skin_;
  const double beside = norm(start + direction * middle);
  if (!(beside <= radius)) return {};
  const double half_chord = std::sqrt(radius * radius - beside * beside);
  const double first = std::max(middle - half_chord, 0.0) - skin_, last = std::min(middle + half_chord, far);
  if (!(first < last)) return {};
  const Point origin = start + direction * first;
  float from = 0;
  for (;;) {
    const Hit hit = intersect(*scene_, to_float(origin), to_float(direction), from, static_cast<float>(last - first));
    if (!hit.hit) return {};
    const Point& normal = face_normals_[hit.triangle];
    // On the face's plane, in double: Embree's t is a float.
    const double towards = dot(normal, direction);
    const double t =
        std::abs(towards) > 1e-9 ? dot(normal, point(triangles_[hit.triangle][0]) - origin) / towards : hit.t;
    // Seen from both sides, what lies behind the start was not crossed: only the skin reaches there.
    if (front_only ? towards < 0 : first + t >= 0) return {true, origin + view_.centre + direction * t, normal};
    from = std::nextafter(hit.t, INFINITY);
  }
}

std::size_t ClosestPointIndex::bytes() const {
  return points_.size() * (sizeof(points_[0]) + sizeof(Point) + sizeof(std::array<float, 3>)) +
         triangles_.size() * (2 * sizeof(Triangle) + 4 * sizeof(Point) + 4) + octree_->bytes();
}

}  // namespace malha
