// SPDX-License-Identifier: Apache-2.0
#include "host/render/light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace malha {

namespace {

constexpr int kKeyRays = 8, kSkyRays = 8;
constexpr float kKeyWidth = 0.09f;  // tangent of half the angular size of the key light

const Vec kKeyColour(0.98f, 0.92f, 0.83f), kSkyColour(0.43f, 0.48f, 0.55f), kFloorColour(0.25f, 0.235f, 0.22f);

/// Returns point i of a low-discrepancy sequence in the unit square: multiples of the inverses of the plastic number
/// (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
std::array<float, 2> even_point(int i) {
  const double x = 0.7548776662466927 * (i + 0.5), y = 0.5698402909980532 * (i + 0.5);
  return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

/// Returns two unit vectors perpendicular to a unit vector and each other.
std::array<Vec, 2> across(const Vec& n) {
  const Vec axis = std::fabs(n[0]) < 0.6f ? Vec::UnitX() : Vec::UnitZ();
  const Vec a = n.cross(axis).normalized();
  return {a, n.cross(a)};
}

}  // namespace

Light::Light(const Lens& view, float unit) : sky_reach_(0.7f * unit) {
  const Vec back = -Vec(view.forward[0], 0, view.forward[2]).stableNormalized();
  key_ = (Vec(0, 0.9f, 0) - 0.85f * view.right + 0.35f * back).normalized();
  const auto [a, b] = across(key_);
  key_right_ = a;
  key_up_ = b;
}

Visibility Light::visibility_at(const RenderScene& scene, const SurfaceHit& surface, int pattern) const {
  Visibility visibility;
  if (surface.normal.dot(key_) > -kKeyWidth) {
    int clear = 0;
    for (int i = 0; i < kKeyRays; ++i) {
      const auto [u, v] = even_point(pattern * kKeyRays + i);
      const float radius = kKeyWidth * std::sqrt(u), turn = 2 * std::numbers::pi_v<float> * v;
      const Vec direction = key_ + radius * (std::cos(turn) * key_right_ + std::sin(turn) * key_up_);
      clear += !scene.is_occluded(surface.shadow_origin, direction, std::numeric_limits<float>::infinity());
    }
    visibility.key = static_cast<float>(clear) / kKeyRays;
  }
  const auto [a, b] = across(surface.normal);
  int clear = 0;
  for (int i = 0; i < kSkyRays; ++i) {  // with a density proportional to the cosine
    const auto [u, v] = even_point(pattern * kSkyRays + i);
    const float radius = std::sqrt(u), turn = 2 * std::numbers::pi_v<float> * v;
    Vec direction = radius * (std::cos(turn) * a + std::sin(turn) * b) + std::sqrt(1 - u) * surface.normal;
    const float under = direction.dot(surface.geometric_normal);
    if (under < 0)
      direction -= 2 * under * surface.geometric_normal;  // directions into the triangle itself are mirrored
    clear += !scene.is_occluded(surface.shadow_origin, direction, sky_reach_);
  }
  visibility.sky = static_cast<float>(clear) / kSkyRays;
  return visibility;
}

Vec Light::shade(const RenderScene& scene, const SurfaceHit& surface, const Visibility& visibility,
                 const Vec& towards_eye) const {
  constexpr float kIndirect = 0.18f;  // share of the sky's light that other surfaces reflect
  const Vec albedo = scene.colour(surface.drawing) * (1 - 0.55f * surface.wire);
  const Vec key = visibility.key * std::max(0.0f, surface.normal.dot(key_)) * kKeyColour;
  const float up = 0.5f + 0.5f * surface.normal[1];
  const Vec sky = (kIndirect + (1 - kIndirect) * visibility.sky) * (up * kSkyColour + (1 - up) * kFloorColour);
  const float gloss = std::pow(std::max(0.0f, surface.normal.dot((key_ + towards_eye).normalized())), 40.0f);
  return albedo.cwiseProduct(key + sky) + 0.07f * gloss * visibility.key * kKeyColour;
}

Vec background(float height) { return (1 - height) * Vec(0.62f, 0.63f, 0.65f) + height * Vec(0.90f, 0.91f, 0.93f); }

}  // namespace malha
