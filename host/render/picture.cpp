// SPDX-License-Identifier: Apache-2.0
#include "host/render/picture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/base/parallel_tasks.h"
#include "host/render/light.h"

namespace malha {

namespace {

/// The surface at the centre of a pixel, and the visibility of the lights there.
struct Middle {
  SurfaceHit surface;
  Visibility visibility;
};

/// Renders a picture in two passes over the pixels: first the visibility of the lights at each pixel's centre, by few
/// rays whose directions differ within every 4 x 4 pixels; then the colours, with the visibility averaged over
/// neighbours on the same surface.
class Film {
 public:
  Film(const RenderScene& scene, const Lens& view, const Light& light, int width, int height)
      : scene_(scene), view_(view), light_(light), width_(width), height_(height) {
    middles_.resize(static_cast<std::size_t>(width) * height);
  }

  void light_row(int y) {
    for (int x = 0; x < width_; ++x) {
      Middle& middle = middles_[static_cast<std::size_t>(y) * width_ + x];
      middle.surface = trace(x + 0.5f, y + 0.5f);
      if (middle.surface.drawing >= 0) middle.visibility = light_.visibility_at(scene_, middle.surface, pattern(x, y));
    }
  }

  void colour_row(int y, unsigned char* row) const {
    for (int x = 0; x < width_; ++x) {
      const Vec colour = pixel(x, y);
      for (int k = 0; k < 3; ++k) row[3 * x + k] = encode(colour[k]);
    }
  }

 private:
  static constexpr int kFine = 4;  // a pixel on an edge takes kFine x kFine samples

  SurfaceHit trace(float x, float y) const { return scene_.trace(view_.eye, view_.direction(x, y), view_.pixel); }

  const Middle& middle(int x, int y) const { return middles_[static_cast<std::size_t>(y) * width_ + x]; }

  static int pattern(int x, int y) {
    static constexpr int kBayer[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    return kBayer[y % 4][x % 4];
  }

  /// Returns whether two hits lie on one smooth piece of surface.
  bool same_surface(const SurfaceHit& a, const SurfaceHit& b) const {
    if (a.drawing != b.drawing) return false;
    if (a.drawing < 0) return true;
    const float apart = std::fabs(a.normal.dot(b.point - a.point));
    return a.normal.dot(b.normal) > 0.9f && apart < 2 * view_.pixel * a.distance;
  }

  /// Returns the visibility of the lights in pixel (x, y): the mean over the pixels of the 5 x 5 around it that show
  /// the same surface. With the outer ones at half weight each of the 4 x 4 patterns has the same weight.
  Visibility gather(int x, int y, const SurfaceHit& surface) const {
    Visibility sum;
    float total = 0;
    for (int j = std::max(0, y - 2); j <= std::min(height_ - 1, y + 2); ++j) {
      for (int i = std::max(0, x - 2); i <= std::min(width_ - 1, x + 2); ++i) {
        const Middle& other = middle(i, j);
        if (!same_surface(surface, other.surface)) continue;
        const float weight = (std::abs(i - x) == 2 ? 0.5f : 1.0f) * (std::abs(j - y) == 2 ? 0.5f : 1.0f);
        sum.key += weight * other.visibility.key;
        sum.sky += weight * other.visibility.sky;
        total += weight;
      }
    }
    if (total == 0) return light_.visibility_at(scene_, surface, pattern(x, y));
    return {sum.key / total, sum.sky / total};
  }

  Vec colour(const SurfaceHit& surface, const Visibility& visibility, float y) const {
    if (surface.drawing < 0) return background(1 - y / static_cast<float>(height_));
    const Vec bright = light_.shade(scene_, surface, visibility, (view_.eye - surface.point).stableNormalized());
    return bright.cwiseMin(1.0f);
  }

  Vec pixel(int x, int y) const {
    const Middle& centre = middle(x, y);
    // Four more samples, one in each quarter; a pixel inside a surface takes only these five.
    static constexpr float kPlaces[4][2] = {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.625f, 0.875f}, {0.125f, 0.625f}};
    std::array<SurfaceHit, 4> around;
    bool even = true;
    for (int k = 0; k < 4 && even; ++k) {
      around[k] = trace(x + kPlaces[k][0], y + kPlaces[k][1]);
      even = same_surface(centre.surface, around[k]);
    }
    Vec sum = Vec::Zero();
    if (even) {
      const Visibility visibility = centre.surface.drawing < 0 ? Visibility{} : gather(x, y, centre.surface);
      for (int k = 0; k < 4; ++k) sum += colour(around[k], visibility, y + kPlaces[k][1]);
      return 0.2f * (sum + colour(centre.surface, visibility, y + 0.5f));
    }
    for (int k = 0; k < kFine * kFine; ++k) {
      const float sub_x = x + (k % kFine + 0.5f) / kFine, sub_y = y + (k / kFine + 0.5f) / kFine;
      const SurfaceHit surface = trace(sub_x, sub_y);
      sum += colour(surface, surface.drawing < 0 ? Visibility{} : gather(x, y, surface), sub_y);
    }
    return sum / (kFine * kFine);
  }

  /// sRGB (IEC 61966-2-1).
  static unsigned char encode(float linear) {
    const float c = std::min(1.0f, std::max(0.0f, linear));  // this order of min and max turns NaN into 0
    const float srgb = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
    return static_cast<unsigned char>(srgb * 255 + 0.5f);
  }

  const RenderScene& scene_;
  const Lens& view_;
  const Light& light_;
  int width_, height_;
  std::vector<Middle> middles_;
};

}  // namespace

Image render(std::span<const Drawing> drawings, const Camera& camera, int width, int height, int threads,
             const std::atomic<bool>* stop) {
  if (width < 1 || height < 1) throw std::invalid_argument("a picture needs at least one pixel");
  const Lens view(camera, width, height);
  const float distance = (Vec(Eigen::Vector3d(camera.target.data()).cast<float>()) - view.eye).norm();
  const float unit = distance * view.pixel * view.height;
  const RenderScene scene(drawings, unit);
  const Light light(view, unit);
  Film film(scene, view, light, width, height);
  Image image{width, height, std::vector<unsigned char>(std::size_t{3} * width * height)};
  // Rows differ in cost: interleaved, each thread gets its share of the cheap ones and the dear ones.
  const OpenMP executor{std::max(1, threads)};
  const int groups = std::min(height, 4 * executor.threads);
  const auto goes_on = [stop] { return stop == nullptr || !*stop; };
  parallel_tasks(
      executor, groups,
      [&](int g) {
        for (int y = g; y < height && goes_on(); y += groups) film.light_row(y);
      },
      1);
  parallel_tasks(
      executor, groups,
      [&](int g) {
        for (int y = g; y < height && goes_on(); y += groups)
          film.colour_row(y, image.pixels.data() + std::size_t{3} * y * width);
      },
      1);
  return goes_on() ? image : Image{};
}

void add_faces(Drawing& drawing, std::span<const Quad> faces) {
  constexpr std::size_t kWires = 3000;
  constexpr unsigned char kLast = 4, kFirst = 1;  // the edges c a and a c
  drawing.hidden.resize(drawing.triangles.size(), 0);
  for (const auto& [a, b, c, d] : faces) {
    drawing.triangles.push_back({a, b, c});
    drawing.hidden.push_back(d < 0 ? 0 : kLast);
    if (d < 0) continue;
    drawing.triangles.push_back({a, c, d});
    drawing.hidden.push_back(kFirst);
  }
  drawing.wire = faces.size() < kWires;
}

std::array<float, 3> body_colour(int body) {
  static constexpr std::array<float, 3> kColours[] = {
      {0.27f, 0.51f, 0.80f}, {0.90f, 0.47f, 0.35f}, {0.26f, 0.66f, 0.57f}, {0.95f, 0.71f, 0.27f},
      {0.60f, 0.45f, 0.77f}, {0.53f, 0.71f, 0.33f}, {0.88f, 0.50f, 0.66f}, {0.62f, 0.49f, 0.40f}};
  return kColours[body % 8];
}

std::array<float, 3> stone_colour() { return {0.74f, 0.725f, 0.70f}; }

}  // namespace malha
