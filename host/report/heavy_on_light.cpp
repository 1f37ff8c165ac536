// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "host/mesh/vectors.h"
#include "host/model/pins.h"
#include "host/report/failure_boundaries.h"

namespace malha {

namespace {

// Measured with blocks of tetrahedra and of springs, 0.2 m high, 1 kg below 1 to 100 kg.
constexpr double kFall =
    0.01;  // of the lighter one's height: from twice that fall the heavier one drifts by a tenth of its width
constexpr double kDamped = 100;  // 1/s, of the lighter one: with that damping they drift by 0.06 of their width at most
constexpr double kDampsAll = 400;  // 1/s: they drift by a hundredth of their width or less, and rest after 3 s

/// Orthonormal axes of a scene; `up` is against gravity.
struct Axes {
  Vec3 up, across, along;
};
Axes axes_of(const Vec3& gravity) {
  const double g = norm(gravity);
  const Vec3 up = {-gravity[0] / g, -gravity[1] / g, -gravity[2] / g};
  const Vec3 beside = std::abs(up[0]) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 0, 1};  // far from parallel to `up`
  const Vec3 across = cross(up, beside);
  return {up, across, cross(across, up)};
}

/// The bounding box of points along these axes.
struct Extent {
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double lowest = kNone, highest = -kNone;                        // m, upwards
  std::array<double, 2> low{kNone, kNone}, high{-kNone, -kNone};  // m, across

  void add(const Axes& axes, const Vec3& x) {
    const double height = dot(x, axes.up), sides[2] = {dot(x, axes.across), dot(x, axes.along)};
    lowest = std::min(lowest, height), highest = std::max(highest, height);
    for (int k = 0; k < 2; ++k) low[k] = std::min(low[k], sides[k]), high[k] = std::max(high[k], sides[k]);
  }
  double height() const { return highest - lowest; }
  bool overlaps(const Extent& o) const {
    return low[0] < o.high[0] && o.low[0] < high[0] && low[1] < o.high[1] && o.low[1] < high[1];
  }
};

/// A body at the start: its extent, mass, motion and damping.
struct BodyAtStart : Extent {
  double mass = 0;                   // kg
  int weighed = 0;                   // particles that have a mass, because they are not pinned
  bool free = true, touches = true;  // touches: the body takes part in self-collision
  double damped = 0;                 // 1/s, by the wind's drag
  double rises = 0;                  // m, height that its initial velocity lets it gain
  double falls = 0;                  // m, onto the object below it; 0: there is none

  /// Returns whether the body is free and not a sheet that lies flat.
  bool bounces(double thickness) const { return free && height() > thickness; }
};

/// Returns whether a body has pins that are all released at some time.
bool is_released(const BodySpec& body) {
  return !body.pins.empty() &&
         std::ranges::all_of(body.pins, [](const Pin& pin) { return pin.release_time.has_value(); });
}

/// Returns all bodies of a scene with self-collision at its start.
std::vector<BodyAtStart> bodies_at_start(const Model& model, double gravity) {
  const Scene& scene = model.scene;
  const Axes axes = axes_of(scene.gravity);
  const std::vector<int> body = bodies_of(model);
  const std::vector<bool> held = fixed_at_start(model, true);
  std::vector<BodyAtStart> all(scene.bodies.size());
  for (std::size_t i = 0; i < body.size(); ++i) {
    BodyAtStart& of = all[body[i]];
    if (held[i]) of.free = false;
    if (model.w[i] > 0) of.mass += 1 / model.w[i], ++of.weighed;
  }
  for (std::size_t b = 0; b < all.size(); ++b) {
    BodyAtStart& of = all[b];
    of.free = of.free || is_released(scene.bodies[b]);
    for (int i = model.render_mesh.body_begin[b]; i < model.render_mesh.body_begin[b + 1]; ++i)
      of.add(axes, model.render_mesh.points[i]);
    const std::vector<std::string>& touching = scene.self_collision->bodies;  // empty: all
    const bool named = std::find(touching.begin(), touching.end(), scene.bodies[b].name) != touching.end();
    of.touches = touching.empty() || named;
    const int count = model.render_mesh.body_begin[b + 1] - model.render_mesh.body_begin[b];
    const double speed = dot(scene.bodies[b].velocity, axes.up);
    of.rises = speed * speed / (2 * gravity);
    // Pinned particles have no mass in the model; they count with the mean mass of the others.
    of.mass = scene.bodies[b].mass.value_or(of.weighed > 0 ? of.mass * count / of.weighed : 0);
    of.damped = scene.wind ? scene.wind->drag * count / of.mass : 0;
  }
  for (const EnvironmentMesh& object : model.environment) {
    Extent ground;
    for (const Vec3& x : object.mesh.points) ground.add(axes, x);
    for (BodyAtStart& of : all)
      if (const double gap = of.lowest - ground.highest - object.spec.thickness; gap > 0 && of.overlaps(ground))
        of.falls = of.falls > 0 ? std::min(of.falls, gap) : gap;
  }
  return all;
}

}  // namespace

HeavyOnLight worst_heavy_on_light(const Model& model) {
  HeavyOnLight worst;
  const Scene& scene = model.scene;
  const double gravity = norm(scene.gravity);
  if (!scene.self_collision || scene.bodies.size() < 2 || !(gravity > 0)) return worst;
  const std::vector<BodyAtStart> all = bodies_at_start(model, gravity);
  const bool floats = model.environment.empty() && std::all_of(all.begin(), all.end(), [](auto& b) { return b.free; });
  if (floats) return worst;  // all bodies have the same acceleration
  const double thickness = scene.self_collision->thickness;
  for (std::size_t a = 0; a < all.size(); ++a) {
    const BodyAtStart& above = all[a];
    int next = -1;  // the highest body below it
    for (std::size_t b = 0; b < all.size(); ++b)
      if (a != b && all[b].touches && all[b].highest < above.lowest && above.overlaps(all[b]) &&
          (next < 0 || all[b].highest > all[next].highest))
        next = static_cast<int>(b);
    if (next < 0 || !above.touches) continue;
    const BodyAtStart& below = all[next];
    const double fall = above.lowest - below.highest - thickness + above.rises + below.falls;
    if (!above.bounces(thickness) || !below.bounces(thickness) || fall < kFall * below.height()) continue;
    if (below.damped >= kDamped || scene.bodies[next].damping == 1) continue;
    const int count = model.render_mesh.body_begin[next + 1] - model.render_mesh.body_begin[next];
    if (const double ratio = above.mass / below.mass; ratio > worst.ratio)
      worst = {ratio, static_cast<int>(a), next, kDampsAll * below.mass / count};
  }
  return worst;
}

}  // namespace malha
