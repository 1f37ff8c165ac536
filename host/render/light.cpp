// SPDX-License-Identifier: Apache-2.0
#include "host/render/light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace malha {

namespace {

constexpr int kKeyRays = 8, kSkyRays = 8;
constexpr float kKeyWidth = 0.09f;  // tangent of half the angle under which the key light is seen

const Vec kKeyColour(0.98f, 0.92f, 0.83f), kSkyColour(0.43f, 0.48f, 0.55f), kFloorColour(0.25f, 0.235f, 0.22f);

/// Point i of an even sequence in the unit square, any run of which is even too: multiples of the inverses of the
/// plastic number (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
std::array<float, 2> even_point(int i) {
  const double x = 0.7548776662466927 * (i + 0.5), y = 0.5698402909980532 * (i + 0.5);
  return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

/// Two unit vectors across a unit vector.
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

Lit Light::reach(const Stage& stage, const SurfaceHit& surface, int pattern) const {
  Lit lit;
  if (surface.normal.dot(key_) > -kKeyWidth) {
    int clear = 0;
    for (int i = 0; i < kKeyRays; ++i) {
      const auto [u, v] = even_point(pattern * kKeyRays + i);
      const float radius = kKeyWidth * std::sqrt(u), turn = 2 * std::numbers::pi_v<float> * v;
      const Vec direction = key_ + radius * (std::cos(turn) * key_right_ + std::sin(turn) * key_up_);
      clear += !stage.shadowed(surface.start, direction, std::numeric_limits<float>::infinity());
    }
    lit.key = static_cast<float>(clear) / kKeyRays;
  }
  const auto [a, b] = across(surface.normal);
  int clear = 0;
  for (int i = 0; i < kSkyRays; ++i) {  // density proportional to the cosine
    const auto [u, v] = even_point(pattern * kSkyRays + i);
    const float radius = std::sqrt(u), turn = 2 * std::numbers::pi_v<float> * v;
    Vec direction = radius * (std::cos(turn) * a + std::sin(turn) * b) + std::sqrt(1 - u) * surface.normal;
    const float under = direction.dot(surface.flat);
    if (under < 0) direction -= 2 * under * surface.flat;  // into the triangle itself: mirrored out
    clear += !stage.shadowed(surface.start, direction, sky_reach_);
  }
  lit.sky = static_cast<float>(clear) / kSkyRays;
  return lit;
}

Vec Light::shade(const Stage& stage, const SurfaceHit& surface, const Lit& lit, const Vec& towards_eye) const {
  constexpr float kIndirect = 0.18f;  // share of the sky's light that arrives by way of other surfaces
  const Vec albedo = stage.colour(surface.drawing) * (1 - 0.55f * surface.wire);
  const Vec key = lit.key * std::max(0.0f, surface.normal.dot(key_)) * kKeyColour;
  const float up = 0.5f + 0.5f * surface.normal[1];
  const Vec sky = (kIndirect + (1 - kIndirect) * lit.sky) * (up * kSkyColour + (1 - up) * kFloorColour);
  const float gloss = std::pow(std::max(0.0f, surface.normal.dot((key_ + towards_eye).normalized())), 40.0f);
  return albedo.cwiseProduct(key + sky) + 0.07f * gloss * lit.key * kKeyColour;
}

Vec background(float height) { return (1 - height) * Vec(0.62f, 0.63f, 0.65f) + height * Vec(0.90f, 0.91f, 0.93f); }

}  // namespace malha
