// SPDX-License-Identifier: Apache-2.0
// Small scenes made in code, for tests whose answer is a formula.
#pragma once
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kG = 9.81;  // m/s^2
inline constexpr Vec3 kEarth{0, -kG, 0};

inline double length(const Vec3& a) { return std::hypot(a[0], a[1], a[2]); }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// One loose particle.
inline BodySpec particle(const Vec3& at, const Vec3& velocity = {}, double mass = 1) {
  BodySpec body;
  body.name = "particle";
  body.shape = LatticeShape{at, at, {1, 1, 1}};
  body.velocity = velocity;
  body.mass = mass;
  return body;
}

/// A tumbling ellipsoid of 10 * 4^subdivisions + 2 particles with unequal masses.
inline BodySpec tumbling_ellipsoid(int subdivisions, std::vector<ConstraintSpec> constraints) {
  BodySpec body;
  body.name = "ellipsoid";
  body.shape = SphereShape{0.5, subdivisions};
  body.transform.scale = {1, 2, 0.5};
  body.transform.translate = {0.3, 1, 0.2};
  body.mass = 2;
  body.velocity = {1, 0.5, -0.3};
  body.spin = {1, 2, -3};
  body.constraints = std::move(constraints);
  return body;
}

/// A chain whose first particle is pinned; `mass` (kg) is that of each of its segments' ends on average, so that a
/// single segment ends in a mass of exactly this.
inline BodySpec hung_chain(const Vec3& from, const Vec3& to, int segments, double mass = 1) {
  BodySpec body;
  body.name = "chain";
  body.shape = ChainShape{from, to, segments};
  body.mass = mass * (segments == 1 ? 2 : segments + 1);
  body.pins = {ListPin{{0}}};
  return body;
}

inline ConstraintSpec stiff(const std::string& type, std::vector<std::string> on = {}, double stiffness = 1,
                            double parameter = 1) {
  return {type, std::move(on), stiffness, std::nullopt, parameter};
}
inline ConstraintSpec compliant(const std::string& type, double compliance, std::vector<std::string> on = {},
                                double parameter = 1) {
  return {type, std::move(on), 1, compliance, parameter};
}

inline Scene scene_of(std::vector<BodySpec> bodies, const Vec3& gravity, double dt, int substeps = 1,
                      Precision precision = Precision::Double) {
  Scene scene;
  scene.name = "small";
  scene.solver.dt = dt;
  scene.solver.substeps = substeps;
  scene.solver.precision = precision;
  scene.gravity = gravity;
  scene.bodies = std::move(bodies);
  return scene;
}

/// A scene of the folder scenes/.
inline Scene load_shipped(const std::string& name) { return load_scene(MALHA_SOURCE_DIR "/scenes/" + name + ".json"); }

/// The names of all that ship, ascending.
inline std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(MALHA_SOURCE_DIR "/scenes"))
    if (entry.path().extension() == ".json" && entry.path().stem() != "schema")
      names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Steps until `seconds` have passed, to the nearest step.
inline void run_for(Simulation& simulation, const Scene& scene, double seconds) {
  for (long long left = std::llround(seconds / scene.solver.dt); left > 0; --left) simulation.step();
}

inline Simulation after(const Scene& scene, double seconds, const SimulationOptions& options = {.threads = 1}) {
  Simulation simulation(scene, options);
  run_for(simulation, scene, seconds);
  return simulation;
}

}  // namespace malha
