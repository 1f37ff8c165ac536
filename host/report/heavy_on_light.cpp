// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "host/mesh/vectors.h"
#include "host/model/pins.h"
#include "host/model/self_surface.h"
#include "host/report/failure_boundaries.h"

namespace malha {

namespace {

// Measured with blocks of tetrahedra and of springs, 0.2 m high, 1 kg below 1 to 100 kg.
constexpr double kFall =
    0.01;  // of the lighter one's height: from twice that fall the heavier one drifts by a tenth of its width
constexpr double kDamped = 100;  // 1/s, of the lighter one: with that damping they drift by 0.06 of their width at most
constexpr double kDampsAll = 400;  // 1/s: they drift by a hundredth of their width or less, and rest after 3 s

/// A bounding box (m), whose first axis is upwards and whose others are horizontal.
using Box = Eigen::AlignedBox3d;

/// Returns orthonormal axes as rows, of which the first one is against gravity.
Eigen::Matrix3d axes_of(const Vec3& gravity) {
  const Eigen::Vector3d up = -Eigen::Vector3d(gravity.data()).normalized();
  const Eigen::Vector3d across = up.unitOrthogonal();
  return (Eigen::Matrix3d() << up, across, across.cross(up)).finished().transpose();
}

/// Returns whether the boxes overlap as seen from above.
bool overlap(const Box& a, const Box& b) {
  return (a.min().tail<2>().array() < b.max().tail<2>().array()).all() &&
         (b.min().tail<2>().array() < a.max().tail<2>().array()).all();
}

/// A body at the start: its extent, mass, motion and damping.
struct BodyAtStart {
  Box box;
  double mass = 0;                   // kg
  int weighed = 0;                   // particles that have a mass, because they are not pinned
  bool free = true, touches = true;  // touches: the body takes part in self-collision
  double damped = 0;                 // 1/s, by the wind's drag
  double rises = 0;                  // m, height that its initial velocity lets it gain
  double falls = 0;                  // m, onto the object below it; 0: there is none

  /// Returns whether the body is free and not a sheet that lies flat.
  bool bounces(double thickness) const { return free && box.sizes()[0] > thickness; }
};

/// Returns whether a body has pins that are all released at some time.
bool is_released(const BodySpec& body) {
  return !body.pins.empty() &&
         std::ranges::all_of(body.pins, [](const Pin& pin) { return pin.release_time.has_value(); });
}

/// Returns all bodies of a scene with self-collision at its start.
std::vector<BodyAtStart> bodies_at_start(const Model& model, double gravity) {
  const Scene& scene = model.scene;
  const Eigen::Matrix3d axes = axes_of(scene.gravity);
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
      of.box.extend(axes * Eigen::Vector3d(model.render_mesh.points[i].data()));
    of.touches = self_collides(scene, scene.bodies[b].name);
    const int count = model.render_mesh.body_begin[b + 1] - model.render_mesh.body_begin[b];
    const double speed = axes.row(0) * Eigen::Vector3d(scene.bodies[b].velocity.data());
    of.rises = speed * speed / (2 * gravity);
    // Pinned particles have no mass in the model; they count with the mean mass of the others.
    of.mass = scene.bodies[b].mass.value_or(of.weighed > 0 ? of.mass * count / of.weighed : 0);
    of.damped = scene.wind ? scene.wind->drag * count / of.mass : 0;
  }
  for (const EnvironmentMesh& object : model.environment) {
    Box ground;
    for (const Vec3& x : object.mesh.points) ground.extend(axes * Eigen::Vector3d(x.data()));
    for (BodyAtStart& of : all)
      if (const double gap = of.box.min()[0] - ground.max()[0] - object.spec.thickness;
          gap > 0 && overlap(of.box, ground))
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
      if (a != b && all[b].touches && all[b].box.max()[0] < above.box.min()[0] && overlap(above.box, all[b].box) &&
          (next < 0 || all[b].box.max()[0] > all[next].box.max()[0]))
        next = static_cast<int>(b);
    if (next < 0 || !above.touches) continue;
    const BodyAtStart& below = all[next];
    const double fall = above.box.min()[0] - below.box.max()[0] - thickness + above.rises + below.falls;
    if (!above.bounces(thickness) || !below.bounces(thickness) || fall < kFall * below.box.sizes()[0]) continue;
    if (below.damped >= kDamped || scene.bodies[next].damping == 1) continue;
    const int count = model.render_mesh.body_begin[next + 1] - model.render_mesh.body_begin[next];
    if (const double ratio = above.mass / below.mass; ratio > worst.ratio)
      worst = {ratio, static_cast<int>(a), next, kDampsAll * below.mass / count};
  }
  return worst;
}

}  // namespace malha
