// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/self/cases.h"

#include <algorithm>
#include <cmath>

namespace malha::bench {

namespace {

constexpr int kLayers = 4;

ConstraintSpec stiff(const char* type, std::vector<std::string> on = {}, double stiffness = 1) {
  ConstraintSpec spec;
  spec.type = type, spec.elements = std::move(on), spec.stiffness = stiffness;
  return spec;
}

/// A scene with steps of `dt` (s), `substeps` substeps of one iteration each, in float.
Scene scene_of(const std::string& name, double dt, int substeps, std::vector<BodySpec> bodies, double thickness,
               double friction) {
  Scene scene;
  scene.name = name;
  scene.gravity = {0, -9.81, 0};
  scene.solver.dt = dt, scene.solver.substeps = substeps;
  scene.bodies = std::move(bodies);
  scene.self_collision = SelfCollision{thickness, friction, {}};
  return scene;
}

BodySpec cloth(double width, double length, int across, int along, double bending) {
  BodySpec body;
  body.name = "cloth";
  body.shape = GridShape{{width, length}, {across, along}};
  body.density = 0.3;
  body.constraints = {stiff("distance", {"edges", "shear"}), stiff("bending", {}, bending)};
  return body;
}

EnvironmentSpec ground() {
  EnvironmentSpec spec;
  spec.name = "ground";
  spec.shape = GridShape{{8, 8}, {1, 1}};
  spec.transform.translate = {-4, 0, -4};
  spec.sides = Sides::OneSided;
  spec.friction = 0.5;
  return spec;
}

EnvironmentSpec ball(const Vec3& at, double radius) {
  EnvironmentSpec spec;
  spec.name = "ball", spec.shape = SphereShape{radius, 4}, spec.transform.translate = at, spec.friction = 0.3;
  return spec;
}

int cells_of_square(int n) { return std::max(1, static_cast<int>(std::lround(std::sqrt(double(n)))) - 1); }

/// Layers slide over each other and rest on the lowest, which is pinned. They start a little closer than the thickness,
/// which is 0.4 of a cell's side.
Scene stack(int n) {
  const double side = 0.02, thickness = 0.008;
  const int cells = cells_of_square(n / kLayers);
  std::vector<BodySpec> sheets;
  for (int layer = 0; layer < kLayers; ++layer) {
    BodySpec body;
    body.name = "layer " + std::to_string(layer);
    body.shape = GridShape{{side * cells, side * cells}, {cells, cells}};
    body.density = 0.2;
    body.transform.translate = {0.3 * side * layer, 0.95 * thickness * layer, 0.4 * side * layer};
    if (layer == 0) body.pins = {BoxPin{{-1, -1, -1}, {side * (cells - 0.5), 1, side * (cells + 1)}}};
    body.velocity = {layer % 2 == 0 ? 0.2 : -0.2, 0, 0};
    body.constraints = {stiff("distance", {"edges", "shear"})};
    sheets.push_back(body);
  }
  return scene_of("stack", 1.0 / 60, 10, sheets, thickness, 0.3);
}

Scene heap(int n) { return cloth_of_2006(n, false, 10); }

/// A square of 2 m falls over a ball of 0.3 m and onto the ground.
Scene drape(int n) {
  const int cells = cells_of_square(n);
  BodySpec body = cloth(2, 2, cells, cells, 0.3);
  body.transform.translate = {-1, 0.7, -1};
  Scene scene = scene_of("sphere", 1.0 / 60, 10, {body}, 1.0 / cells, 0.2);
  scene.environment = {ground(), ball({0, 0.31, 0}, 0.3)};
  return scene;
}

/// A square of 1 m, 5 mm thick, is twisted by half a circle between two sides, which also approach each other.
Scene twist(int n) {
  const int cells = cells_of_square(n);
  BodySpec body = cloth(1, 1, cells, cells, 0.1);
  body.transform.translate = {-0.5, 0, -0.5};
  for (const bool last : {false, true}) {
    Keyframe start, end;
    end.time = 1, end.axis = {0, 0, 1}, end.degrees = last ? 90 : -90, end.translate = {0, 0, last ? -0.1 : 0.1};
    Pin pin = RowPin{last};
    pin.motion = {start, end};
    body.pins.push_back(pin);
  }
  Scene scene = scene_of("twist", 1.0 / 60, 10, {body}, 0.005, 0.2);
  scene.gravity = {};
  return scene;
}

/// Soft springs pull a sheet to a point.
Scene crumple(int n) {
  const int cells = cells_of_square(n);
  BodySpec body = cloth(0.5, 0.5, cells, cells, 0.02);
  body.transform.translate = {-0.25, 0.3, -0.25};
  Attachment pull;
  pull.at = BoxPin{{-1, -1, -1}, {1, 1, 1}};
  // m/N; the stiffness of the whole sheet does not depend on n.
  pull.point = Vec3{0, 0.3, 0}, pull.compliance = 40 * n / 361.0;
  body.attachments = {pull};
  return scene_of("crumple", 1.0 / 60, 20, {body}, 0.15 / cells, 0.4);
}

/// Two balls under pressure collide.
Scene balls(int n) {
  const int subdivisions = std::max(1, static_cast<int>(std::lround(std::log2(n / 20.0) / 2)));
  std::vector<BodySpec> both;
  for (const int side : {-1, 1}) {
    BodySpec body;
    body.name = side < 0 ? "left" : "right";
    body.shape = SphereShape{0.25, subdivisions};
    body.mass = 0.5;
    body.transform.translate = {0.27 * side, 0, 0};
    body.velocity = {-2.0 * side, 0, 0};
    body.constraints = {stiff("distance", {"edges"}), stiff("pressure")};
    both.push_back(body);
  }
  Scene scene = scene_of("balls", 1.0 / 60, 10, both, 0.3 * 0.25 / std::pow(2, subdivisions), 0.2);
  scene.gravity = {};
  return scene;
}

/// Fifty squares of 1 m, 5 mm apart, fall over a ball and onto the ground.
Scene layers(int n) {
  constexpr int kSheets = 50;
  const int cells = cells_of_square(n / kSheets);
  std::vector<BodySpec> sheets;
  for (int layer = 0; layer < kSheets; ++layer) {
    BodySpec body = cloth(1, 1, cells, cells, 0.1);
    body.name = "layer " + std::to_string(layer);
    // Each is turned differently, so that no two have their particles above each other.
    body.transform.degrees = 2 * layer;
    body.transform.translate = {-0.5, 0.52 + 0.005 * layer, -0.5};
    sheets.push_back(body);
  }
  Scene scene = scene_of("layers", 1.0 / 60, 10, sheets, 0.004, 0.2);
  scene.environment = {ground(), ball({0, 0.25, 0}, 0.25)};
  return scene;
}

}  // namespace

Scene cloth_of_2006(int n, bool drapes, int substeps) {
  const double finer = std::sqrt(1364.0 / n);
  const auto cells = [&](int of) { return static_cast<int>(std::lround(of / finer)); };
  BodySpec body = cloth(0.86, 0.6, cells(43), cells(30), 0.3);
  body.transform.translate = {-0.43, 0.55, -0.3};
  if (!drapes)
    body.transform.axis = {0, 0, 1}, body.transform.degrees = 84, body.transform.translate = {-0.04, 0.02, -0.3};
  Scene scene = scene_of(drapes ? "drape" : "heap", 1.0 / 30, substeps, {body}, 0.01 * finer, 0.2);
  scene.environment = {ground()};
  if (drapes) scene.environment.push_back(ball({0, 0.3, 0}, 0.2));
  return scene;
}

const std::vector<SelfCase>& self_cases() {
  static const std::vector<SelfCase> all{
      {"stack",
       "four sheets, 0.95 of the thickness apart, lie and slide on each other",
       {10'000, 100'000, 1'000'000},
       0,
       stack},
      {"heap", "the cloth of Mueller et al. 2006 falls on edge; frames of 1/30 s", {1364, 10'000, 100'000}, 60, heap},
      {"sphere", "a square of 2 m falls over a ball and onto the ground", {10'000}, 78, drape},
      {"twist", "a square of 1 m, 5 mm thick, is turned by half a circle between its sides", {40'000}, 60, twist},
      {"crumple", "soft springs pull a sheet to a point", {2500}, 60, crumple},
      {"balls", "two balls under pressure collide", {5124}, 40, balls},
      {"layers", "fifty sheets fall over a ball and onto the ground", {24'600}, 30, layers}};
  return all;
}

}  // namespace malha::bench
