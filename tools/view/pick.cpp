// SPDX-License-Identifier: Apache-2.0
#include "tools/view/pick.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "host/attachments/object_motion.h"

namespace malha::view {

namespace {

Eigen::Vector3d vector(const Point3f& a) { return {a[0], a[1], a[2]}; }

/// Returns the distance along the ray to a triangle, or infinity (Möller and Trumbore 1997).
double distance_along(const Ray& ray, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d ab = b - a, ac = c - a, p = ray.direction.cross(ac), to = ray.from - a;
  const double det = ab.dot(p), u = to.dot(p) / det;
  if (det == 0 || !(u >= 0 && u <= 1)) return kNever;
  const Eigen::Vector3d q = to.cross(ab);
  const double v = ray.direction.dot(q) / det, t = ac.dot(q) / det;
  return v >= 0 && u + v <= 1 && t > 0 ? t : kNever;
}

/// Returns twice the signed area of a triangle on the screen; positive if c is to the right of a to b, as y points
/// down.
double signed_area(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

}  // namespace

std::optional<int> pick(const Frame& frame, const OrbitCamera& camera, const Viewport& port, double x, double y,
                        double reach) {
  const Ray ray = camera.ray(port, x, y);
  double nearest = std::numeric_limits<double>::infinity();
  std::optional<int> found;
  const std::array<unsigned, 3>* face = nullptr;
  for (const auto& t : frame.body->triangles) {
    const double along = distance_along(ray, vector(frame.x[t[0]]), vector(frame.x[t[1]]), vector(frame.x[t[2]]));
    if (along < nearest) nearest = along, face = &t;
  }
  const auto away = [&](unsigned i) {
    const Eigen::Vector3d at = camera.on_screen(port, vector(frame.x[i]));
    return at.z() > 0 ? std::hypot(at.x() - x, at.y() - y) : std::numeric_limits<double>::infinity();
  };
  double best = face ? std::numeric_limits<double>::infinity() : reach;
  const auto consider = [&](unsigned i) {
    if (const double pixels = away(i); pixels < best) best = pixels, found = static_cast<int>(i);
  };
  if (face)
    for (const unsigned i : *face) consider(i);
  else
    for (unsigned i = 0; i < frame.x.size(); ++i) consider(i);
  return found;
}

std::vector<Edge> edges_crossed(const Frame& frame, const OrbitCamera& camera, const Viewport& port,
                                const std::array<double, 2>& from, const std::array<double, 2>& to) {
  std::vector<std::array<double, 2>> screen;
  std::vector<bool> seen;
  for (const Point3f& x : frame.x) {
    const Eigen::Vector3d at = camera.on_screen(port, vector(x));
    screen.push_back({at.x(), at.y()}), seen.push_back(at.z() > 0);
  }
  std::vector<Edge> edges;
  for (const auto& [a, b] : frame.body->edges) {
    if (!seen[a] || !seen[b]) continue;
    const double of_a = signed_area(from, to, screen[a]), of_b = signed_area(from, to, screen[b]);
    if (of_a * of_b >= 0 || signed_area(screen[a], screen[b], from) * signed_area(screen[a], screen[b], to) > 0)
      continue;
    edges.push_back(of_a < 0 ? Edge{int(a), int(b)} : Edge{int(b), int(a)});
  }
  return edges;
}

std::vector<Point3f> points_to_frame(const std::vector<std::shared_ptr<const Frame>>& sides) {
  constexpr double kMuchLarger = 2;
  std::vector<Point3f> all;
  for (const auto& frame : sides) {
    Eigen::AlignedBox3d bodies;
    for (const Point3f& x : frame->x)
      if (vector(x).allFinite()) bodies.extend(vector(x)), all.push_back(x);
    if (bodies.isEmpty()) continue;
    for (const EnvironmentMesh& object : *frame->environment) {
      std::vector<Point3f> places;
      Eigen::AlignedBox3d box;
      for (const Vec3& x : points_at(object, frame->time)) {
        places.push_back(to_point3f(x));
        box.extend(Eigen::Vector3d(x[0], x[1], x[2]));
      }
      if (box.sizes().maxCoeff() > kMuchLarger * bodies.sizes().maxCoeff()) {
        const Eigen::Vector3d nearest = bodies.center().cwiseMax(box.min()).cwiseMin(box.max());
        places = {{float(nearest.x()), float(nearest.y()), float(nearest.z())}};
      }
      all.insert(all.end(), places.begin(), places.end());
    }
  }
  return all;
}

}  // namespace malha::view
