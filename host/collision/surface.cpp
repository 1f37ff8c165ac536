#include "host/collision/surface.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/mesh/topology.h"

namespace malha {

namespace {

double length(const Point& a) { return std::sqrt(dot(a, a)); }

Point unit(const Point& a) {
  const double l = length(a);
  return l > 0 ? a * (1 / l) : a;
}

/// The feature of a triangle that a point is closest to.
struct OnTriangle {
  Point q;
  int corner = -1, edge = -1;  // both -1: the face
};

/// Ericson, Real-Time Collision Detection, section 5.1.5.
OnTriangle closest_on_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Point ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {a, 0, -1};
  if (d3 >= 0 && d4 <= d3) return {b, 1, -1};
  if (d6 >= 0 && d5 <= d6) return {c, 2, -1};
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + ab * (d1 / (d1 - d3)), -1, 0};
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6)), -1, 1};
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + ac * (d2 / (d2 - d6)), -1, 2};
  const double per = 1 / (va + vb + vc);
  return {a + ab * (vb * per) + ac * (vc * per), -1, -1};
}

std::array<float, 3> to_float(const Point& a) { return {float(a.x), float(a.y), float(a.z)}; }

}  // namespace

Surface::Surface(const Device& device, const Mesh& mesh) : triangles_(malha::triangles(mesh)) {
  Vec3 low = mesh.points[0], high = low;
  for (const Vec3& x : mesh.points)
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
  centre_ = {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
  half_ = Point{high[0], high[1], high[2]} - centre_;
  skin_ = 1e-5 * length(half_);  // some 100 roundings of float at the rim of the mesh

  std::vector<std::array<float, 3>> for_embree;
  for (const Vec3& x : mesh.points) {
    points_.push_back(Point{x[0], x[1], x[2]} - centre_);
    for_embree.push_back(to_float(points_.back()));
  }
  scene_ = std::make_unique<TriangleScene>(device, for_embree, triangles_);

  corner_normals_.assign(points_.size(), Point{});
  std::map<std::pair<int, int>, std::pair<Point, int>> edges;  // sum of normals, number of faces
  for (const Triangle& t : triangles_) {
    const Point& a = points_[t[0]];
    const Point normal = unit(cross(points_[t[1]] - a, points_[t[2]] - a));
    face_normals_.push_back(normal);
    for (int k = 0; k < 3; ++k) {
      const Point& here = points_[t[k]];
      const Point u = unit(points_[t[(k + 1) % 3]] - here), v = unit(points_[t[(k + 2) % 3]] - here);
      const double angle = std::acos(std::clamp(dot(u, v), -1.0, 1.0));
      corner_normals_[t[k]] = corner_normals_[t[k]] + normal * angle;
      auto& edge = edges[std::minmax(t[k], t[(k + 1) % 3])];
      edge.first = edge.first + normal;
      ++edge.second;
    }
  }
  for (Point& n : corner_normals_) n = unit(n);
  rim_corners_.assign(points_.size(), false);
  for (const Triangle& t : triangles_) {
    std::array<Point, 3> normals;
    std::array<bool, 3> rim;
    for (int k = 0; k < 3; ++k) {
      const auto& edge = edges[std::minmax(t[k], t[(k + 1) % 3])];
      normals[k] = unit(edge.first);
      rim[k] = edge.second == 1;
      if (rim[k]) rim_corners_[t[k]] = rim_corners_[t[(k + 1) % 3]] = true;
    }
    edge_normals_.push_back(normals);
    rim_edges_.push_back(rim);
  }
}

ClosestPoint Surface::closest(const Point& a, double radius, int known_near) const {
  const Point p = a - centre_;
  ClosestPoint best;
  best.distance = radius;
  OnTriangle where{};
  // Embree rounds the query to float: the radius that it sees is larger by that, and the test here decides.
  const double slack = skin_ + 1e-6 * length(p);
  const auto visit = [&](int t) {
    const Triangle& c = triangles_[t];
    const OnTriangle candidate = closest_on_triangle(p, points_[c[0]], points_[c[1]], points_[c[2]]);
    const double distance = length(p - candidate.q);
    // Equally near triangles (a shared edge or corner): the lowest one, whatever the order of the visits.
    if (distance < best.distance || (distance == best.distance && (!best.found || t < best.triangle))) {
      best.found = true;
      best.distance = distance;
      best.triangle = t;
      where = candidate;
    }
    return static_cast<float>(best.distance + slack);
  };
  const float start = known_near < 0 ? static_cast<float>(radius + slack) : visit(known_near);
  point_query(*scene_, to_float(p), start, visit);
  if (!best.found) return best;
  best.q = where.q + centre_;
  if (where.corner >= 0) {
    best.normal = corner_normals_[triangles_[best.triangle][where.corner]];
    best.boundary = rim_corners_[triangles_[best.triangle][where.corner]];
  } else if (where.edge >= 0) {
    best.normal = edge_normals_[best.triangle][where.edge];
    best.boundary = rim_edges_[best.triangle][where.edge];
  } else {
    best.normal = face_normals_[best.triangle];
  }
  return best;
}

Crossing Surface::crossing(const Point& a, const Point& b, double beyond, bool front_only) const {
  const Point path = b - a;
  const double l = length(path);
  if (!(l > 0)) return {};
  const Point direction = path * (1 / l);
  const Point start = a - centre_;
  const Crossing straight = along(start, direction, l + beyond, front_only);
  if (straight.hit) return straight;
  // Embree's rays leak at vertices, one in a hundred to a thousand: a second one, a skin beside the first, does not.
  const Point other = std::abs(direction.x) < 0.5 ? Point{1, 0, 0} : Point{0, 1, 0};
  return along(start + unit(cross(direction, other)) * skin_, direction, l + beyond, front_only);
}

Crossing Surface::along(const Point& start, const Point& direction, double far, bool front_only) const {
  // Only what lies within the mesh's bounding sphere, so that float is fine however long the way is.
  const double middle = -dot(start, direction), radius = length(half_) + skin_;
  const double beside = length(start + direction * middle);
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
        std::abs(towards) > 1e-9 ? dot(normal, points_[triangles_[hit.triangle][0]] - origin) / towards : hit.t;
    // Seen from both sides, what lies behind the start was not crossed: only the skin reaches there.
    if (front_only ? towards < 0 : first + t >= 0) return {true, origin + centre_ + direction * t, normal};
    from = std::nextafter(hit.t, INFINITY);
  }
}

double Surface::box_distance(const Point& a) const {
  const Point d = a - centre_;
  const Point out{std::max(std::abs(d.x) - half_.x, 0.0), std::max(std::abs(d.y) - half_.y, 0.0),
                  std::max(std::abs(d.z) - half_.z, 0.0)};
  return length(out);
}

double Surface::diagonal() const { return 2 * length(half_); }

std::size_t Surface::bytes() const {
  return points_.size() * (2 * sizeof(Point) + sizeof(std::array<float, 3>)) +
         triangles_.size() * (2 * sizeof(Triangle) + 4 * sizeof(Point) + 3);
}

}  // namespace malha
