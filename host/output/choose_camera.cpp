// SPDX-License-Identifier: Apache-2.0
#include "host/output/choose_camera.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/render/stage.h"

namespace malha {

namespace {

using PointList = std::vector<std::array<float, 3>>;

Eigen::Vector3f vector_of(const std::array<float, 3>& point) { return {point[0], point[1], point[2]}; }
std::array<float, 3> translated(const std::array<float, 3>& point, const Vec3& way) {
  return {point[0] + static_cast<float>(way[0]), point[1] + static_cast<float>(way[1]),
          point[2] + static_cast<float>(way[2])};
}
Vec3 scaled(const Vec3& a, double by) { return {a[0] * by, a[1] * by, a[2] * by}; }

double extent(const PointList& points) {
  if (points.empty()) return 0;
  const Eigen::Map<const Eigen::Matrix3Xf> all(points.data()->data(), 3, static_cast<Eigen::Index>(points.size()));
  return (all.rowwise().maxCoeff().cast<double>() - all.rowwise().minCoeff().cast<double>()).maxCoeff();
}

/// Returns about 400 of the points, evenly spaced in their order.
PointList subsample(const PointList& points) {
  constexpr std::size_t kMost = 400;
  PointList some;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / kMost) some.push_back(points[i]);
  return some;
}

/// Adds the corners of a box around the ball to which a pressure inflates an unconstrained body.
void add_inflated(const Model& model, PointList& points) {
  for (const PressureSet& set : model.pressures) {
    if (!(set.volume_ratio > 1)) continue;
    Vec3 centre{};
    for (const int i : set.particles)
      for (int k = 0; k < 3; ++k) centre[k] += model.x[i][k] / double(set.particles.size());
    const double volume = set.volume_ratio * std::abs(signed_volume(model.at_rest(set), set.triangles));
    const double radius = std::cbrt(3 * volume / (4 * std::numbers::pi));
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 at = centre;
      for (int k = 0; k < 3; ++k) at[k] += corner >> k & 1 ? radius : -radius;
      points.push_back(translated({0, 0, 0}, at));
    }
  }
}

/// Adds the points moved along gravity to where the bodies will be. If any particle is pinned, they hang as far below
/// as the bodies are large. Otherwise they fall by the smallest distance of a point to the objects below, also to
/// objects that are too large for the picture.
void add_fall(const Model& model, const RenderScene& environment, double bodies, PointList& points) {
  constexpr double kFarthest = 4;  // of the bodies' extent; a picture of a longer fall would show the bodies too small
  const double strength = norm(model.scene.gravity);
  if (!(strength > 0) || !(bodies > 0)) return;
  const Vec3 down = scaled(model.scene.gravity, 1 / strength);
  double way = bodies;
  if (std::find(model.w.begin(), model.w.end(), 0.0) == model.w.end()) {
    const Eigen::Vector3f ray = vector_of(translated({0, 0, 0}, down));
    const float far = static_cast<float>(kFarthest * bodies);
    way = std::numeric_limits<double>::infinity();
    for (const auto& point : subsample(points))
      if (environment.is_occluded(vector_of(point), ray, far)) {
        const SurfaceHit hit = environment.trace(vector_of(point), ray, 0);
        if (hit.drawing >= 0) way = std::min(way, static_cast<double>(hit.distance));
      }
    if (!std::isfinite(way)) return;
  }
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) points.push_back(translated(points[i], scaled(down, way)));
}

/// Returns the share of the points that no object occludes from a camera.
double visible_share(const PointList& points, const RenderScene& environment, const Camera& camera) {
  const Eigen::Vector3f eye = vector_of(translated({0, 0, 0}, camera.eye));
  double count = 0;
  for (const auto& point : points) {
    const Eigen::Vector3f way = eye - vector_of(point);
    count += !environment.is_occluded(vector_of(point) + 1e-3f * way, way, 1);
  }
  return points.empty() ? 1 : count / static_cast<double>(points.size());
}

}  // namespace

Camera choose_camera(const Model& model, const PictureSpec& spec) {
  if (spec.camera) return *spec.camera;
  constexpr double kEnough = 0.6;  // of the bodies' points
  const Vec3 directions[]{kViewDirection,       {-0.55, -0.12, -0.85}, {-0.55, 0, -0.85},
                          {0.55, -0.12, -0.85}, {-0.85, 0, 0.55},      {0, 0, -1},
                          {-1, 0, 0},           {-0.3, -1, -0.3},      {-0.55, 0.42, -0.85}};
  PointList points;
  for (const Vec3& x : model.render_mesh.points) points.push_back(translated({0, 0, 0}, x));
  const PointList start = subsample(points);
  const double bodies = extent(points);
  std::vector<Drawing> drawings;
  for (const EnvironmentMesh& mesh : model.environment) drawings.push_back(draw_environment(mesh, 0));
  const RenderScene environment(drawings, 1);
  add_inflated(model, points);
  add_fall(model, environment, bodies, points);
  for (const Drawing& drawing : drawings)
    if (extent(drawing.points) < 2 * bodies) points.insert(points.end(), drawing.points.begin(), drawing.points.end());
  const double aspect = double(spec.size[0]) / spec.size[1];
  Camera best;
  double most = -1;
  for (const Vec3& direction : directions) {
    const Camera camera = frame_all(points, aspect, direction);
    const double share = visible_share(start, environment, camera);
    if (share > most + 0.05) most = share, best = camera;
    if (share >= kEnough) break;
  }
  return best;
}

}  // namespace malha
