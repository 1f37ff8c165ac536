#include "host/report/heavy_on_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "host/mesh/vectors.h"
#include "host/model/pins.h"

namespace malha {

namespace {

// Blocks of tetrahedra and of springs, 0.2 m high, 1 kg below 1 to 100 kg.
constexpr double kFall = 0.01;     // of the lighter one's height: from twice that it walks off by a tenth of its width
constexpr double kDamped = 100;    // 1/s, of the lighter one's velocity: they walk by 0.06 of their width at most
constexpr double kDampsAll = 400;  // 1/s: by a hundredth of it or less, and rest after 3 s

/// What a body is here. Upwards is against gravity.
struct Placed {
  double mass = 0;                   // kg
  int weighed = 0;                   // particles that are not pinned
  bool free = true, touches = true;  // touches: takes part in self-collision
  double damped = 0;                 // 1/s, by drag
  double lowest = 0, highest = 0;    // m, upwards
  std::array<double, 2> low, high;   // m, across
  double rises = 0;                  // m, as far as its velocity at the start lets it rise
  double falls = 0;                  // m, onto the object below it; 0: none is known

  double height() const { return highest - lowest; }
  /// Nothing holds it, and it is no sheet that lies.
  bool bounces(double thickness) const { return free && height() > thickness; }
  bool overlaps(const Placed& o) const {
    return low[0] < o.high[0] && o.low[0] < high[0] && low[1] < o.high[1] && o.low[1] < high[1];
  }
};

/// All bodies of a scene with self-collision.
std::vector<Placed> placed(const Model& model, double gravity) {
  const Scene& scene = model.scene;
  const Vec3 up = {-scene.gravity[0] / gravity, -scene.gravity[1] / gravity, -scene.gravity[2] / gravity};
  const Vec3 beside = std::abs(up[0]) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 0, 1};  // far from upwards
  const Vec3 across = cross(up, beside), along = cross(across, up);
  const std::vector<int> body = bodies_of(model);
  const std::vector<bool> held = held_at_start(model, true);
  std::vector<Placed> all(scene.bodies.size());
  for (std::size_t i = 0; i < body.size(); ++i) {
    const std::vector<Pin>& pins = scene.bodies[body[i]].pins;
    const bool let_go = std::ranges::all_of(pins, [](const Pin& pin) { return pin.until.has_value(); });
    if (held[i] && (pins.empty() || !let_go)) all[body[i]].free = false;
    if (model.w[i] > 0) all[body[i]].mass += 1 / model.w[i], ++all[body[i]].weighed;
  }
  for (std::size_t b = 0; b < all.size(); ++b) {
    constexpr double none = std::numeric_limits<double>::infinity();
    Placed& of = all[b];
    of.lowest = of.low[0] = of.low[1] = none, of.highest = of.high[0] = of.high[1] = -none;
    for (int i = model.look.body_begin[b]; i < model.look.body_begin[b + 1]; ++i) {
      const Vec3& x = model.look.points[i];
      const double height = dot(x, up), sides[2] = {dot(x, across), dot(x, along)};
      of.lowest = std::min(of.lowest, height), of.highest = std::max(of.highest, height);
      for (int k = 0; k < 2; ++k)
        of.low[k] = std::min(of.low[k], sides[k]), of.high[k] = std::max(of.high[k], sides[k]);
    }
    const std::vector<std::string>& touching = scene.self_collision->bodies;  // empty: all
    const bool named = std::find(touching.begin(), touching.end(), scene.bodies[b].name) != touching.end();
    of.touches = touching.empty() || named;
    const int count = model.look.body_begin[b + 1] - model.look.body_begin[b];
    const double speed = dot(scene.bodies[b].velocity, up);
    of.rises = speed * speed / (2 * gravity);
    // What pins hold for a while weighs as much as the rest.
    of.mass = scene.bodies[b].mass.value_or(of.weighed > 0 ? of.mass * count / of.weighed : 0);
    of.damped = scene.wind ? scene.wind->drag * count / of.mass : 0;
  }
  for (const EnvironmentMesh& object : model.environment) {
    Placed ground;
    double top = -std::numeric_limits<double>::infinity();
    ground.low[0] = ground.low[1] = -top, ground.high[0] = ground.high[1] = top;
    for (const Vec3& x : object.mesh.points) {
      const double sides[2] = {dot(x, across), dot(x, along)};
      top = std::max(top, dot(x, up));
      for (int k = 0; k < 2; ++k)
        ground.low[k] = std::min(ground.low[k], sides[k]), ground.high[k] = std::max(ground.high[k], sides[k]);
    }
    for (Placed& of : all)
      if (const double gap = of.lowest - top - object.spec.thickness; gap > 0 && of.overlaps(ground))
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
  const std::vector<Placed> all = placed(model, gravity);
  const bool floats = model.environment.empty() && std::all_of(all.begin(), all.end(), [](auto& b) { return b.free; });
  if (floats) return worst;  // all fall alike
  const double thickness = scene.self_collision->thickness;
  for (std::size_t a = 0; a < all.size(); ++a) {
    const Placed& above = all[a];
    int next = -1;  // the highest below it
    for (std::size_t b = 0; b < all.size(); ++b)
      if (a != b && all[b].touches && all[b].highest < above.lowest && above.overlaps(all[b]) &&
          (next < 0 || all[b].highest > all[next].highest))
        next = static_cast<int>(b);
    if (next < 0 || !above.touches) continue;
    const Placed& below = all[next];
    const double fall = above.lowest - below.highest - thickness + above.rises + below.falls;
    if (!above.bounces(thickness) || !below.bounces(thickness) || fall < kFall * below.height()) continue;
    if (below.damped >= kDamped || scene.bodies[next].damping == 1) continue;
    const int count = model.look.body_begin[next + 1] - model.look.body_begin[next];
    if (const double ratio = above.mass / below.mass; ratio > worst.ratio)
      worst = {ratio, static_cast<int>(a), next, kDampsAll * below.mass / count};
  }
  return worst;
}

}  // namespace malha
