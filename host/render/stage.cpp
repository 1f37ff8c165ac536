// SPDX-License-Identifier: Apache-2.0
#include "host/render/stage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace malha {

namespace {

Vec linear(const std::array<float, 3>& srgb) {
  const auto [red, green, blue] = linear_colour(srgb);
  return {red, green, blue};
}

std::array<float, 3> plain(const Vec& v) { return {v[0], v[1], v[2]}; }

bool finite(const std::array<float, 3>& p) { return embree_detail::is_valid(p); }

}  // namespace

std::array<float, 3> linear_colour(const std::array<float, 3>& srgb) {
  const auto one = [](float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); };
  return {one(srgb[0]), one(srgb[1]), one(srgb[2])};
}

RenderScene::RenderScene(std::span<const Drawing> drawings, float unit) : scene_(device_) {
  for (const auto& drawing : drawings) {
    const int number = static_cast<int>(parts_.size());
    parts_.push_back({&drawing, linear(drawing.colour), corner_normals(drawing.points, drawing.triangles)});
    add(number, true, scene_.add_triangles(drawing.points, drawing.triangles));
    add_round(number, drawing, unit);
  }
  scene_.commit();
}

void RenderScene::add(int drawing, bool triangles, int geometry) {
  if (geometry < 0) return;
  if (sources_.size() <= static_cast<std::size_t>(geometry)) sources_.resize(geometry + 1);
  sources_[geometry] = {drawing, triangles};
}

void RenderScene::add_round(int number, const Drawing& drawing, float unit) {
  constexpr float kRod = 0.003f, kBall = 0.005f;  // radii, in units
  using Ball = std::array<float, 4>;
  const auto& points = drawing.points;
  std::vector<Ball> rods, balls;
  std::vector<bool> used(points.size(), !drawing.loose);
  for (const auto& triangle : drawing.triangles) {
    for (const int corner : triangle) used[corner] = true;
  }
  const auto ball = [&](int i, float radius) { return Ball{points[i][0], points[i][1], points[i][2], radius * unit}; };
  for (const auto& [a, b] : drawing.lines) {
    used[a] = used[b] = true;
    if (!finite(points[a]) || !finite(points[b])) continue;
    for (const int end : {a, b}) {
      rods.push_back(ball(end, kRod));
      balls.push_back(rods.back());  // round joints, and end caps, which rays along the rod would miss otherwise
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used[i] && finite(points[i])) balls.push_back(ball(static_cast<int>(i), kBall));
  }
  add(number, false, scene_.add_spheres(balls));
  add(number, false, scene_.add_capsules(rods));
}

SurfaceHit RenderScene::trace(const Vec& origin, const Vec& direction, float pixel) const {
  const Hit hit = intersect(scene_, plain(origin), plain(direction), 0, std::numeric_limits<float>::infinity());
  SurfaceHit surface;
  if (!hit.hit) return surface;
  const Source& source = sources_[hit.geometry];
  surface.drawing = source.drawing;
  surface.distance = hit.t;
  surface.point = origin + hit.t * direction;
  surface.geometric_normal = Vec(hit.normal.data()).stableNormalized();
  if (!surface.geometric_normal.allFinite() || surface.geometric_normal.isZero()) surface.geometric_normal = -direction;
  surface.normal = surface.geometric_normal;
  surface.shadow_origin = surface.point;
  const bool behind = surface.geometric_normal.dot(direction) > 0;
  if (source.triangles) on_triangle(parts_[source.drawing], hit, pixel, behind, surface);
  if (behind) {
    surface.geometric_normal = -surface.geometric_normal;
    surface.normal = -surface.normal;
  }
  const float skin = 1e-4f * hit.t + 1e-6f * surface.point.cwiseAbs().maxCoeff();
  surface.shadow_origin += skin * surface.geometric_normal;
  return surface;
}

/// Computes the normal, the origin of shadow rays and the wire coverage of a hit on a triangle.
void RenderScene::on_triangle(const Part& part, const Hit& hit, float pixel, bool behind, SurfaceHit& surface) const {
  const Triangle& triangle = part.drawing->triangles[hit.triangle];
  const std::array<float, 3> weight{1 - hit.u - hit.v, hit.u, hit.v};
  const Vec* normals = &part.normals[3 * static_cast<std::size_t>(hit.triangle)];
  std::array<Vec, 3> corner;
  Vec normal = Vec::Zero();
  for (int k = 0; k < 3; ++k) {
    corner[k] = Vec(part.drawing->points[triangle[k]].data());
    normal += weight[k] * normals[k];
  }
  if (normal.squaredNorm() > 0) surface.normal = normal.normalized();

  // Shadow rays start on the planes that the corner normals span, because otherwise triangles become visible at the
  // shadow terminator (Hanika, "Hacking the shadow terminator", Ray Tracing Gems II, 2021).
  const float side = behind ? -1.0f : 1.0f;
  for (int k = 0; k < 3; ++k) {
    const float below = std::min(0.0f, (surface.point - corner[k]).dot(side * normals[k]));
    surface.shadow_origin -= weight[k] * below * side * normals[k];
  }

  if (!part.drawing->wire) return;
  const float area = (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();             // doubled
  const float width = std::max(pixel * surface.distance, std::numeric_limits<float>::min());  // of a pixel there, m
  float nearest = std::numeric_limits<float>::infinity(), smallest = nearest;
  for (int k = 0; k < 3; ++k) {  // edge k runs from corner k to k + 1, opposite corner k + 2
    const float height = area / (corner[(k + 1) % 3] - corner[k]).norm();
    smallest = std::min(smallest, height);
    const bool hidden = !part.drawing->hidden.empty() && (part.drawing->hidden[hit.triangle] >> k & 1);
    if (!hidden) nearest = std::min(nearest, weight[(k + 2) % 3] * height);
  }
  const float fade =
      std::clamp(smallest / width / 8 - 0.5f, 0.0f, 1.0f);  // without it cells of a few pixels would turn dark
  surface.wire = fade * std::clamp(1.1f - nearest / width, 0.0f, 1.0f);
}

bool RenderScene::is_occluded(const Vec& origin, const Vec& direction, float reach) const {
  return occluded(scene_, plain(origin), plain(direction), 0, reach);
}

}  // namespace malha
