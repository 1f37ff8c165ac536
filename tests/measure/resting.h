// SPDX-License-Identifier: Apache-2.0
// Bodies that lie on the ground, and the displacement of their particles from step to step.
#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "tests/scene_builders.h"
#include "tests/small_scenes.h"

namespace malha {

/// The body on a solid, or on a one-sided plane. The faces of neither are aligned with the body's cells.
inline Scene resting(const BodySpec& body, const std::string& solver, Precision precision, bool solid) {
  EnvironmentSpec ground = solid ? obstacle("ground", BoxShape{{6, 1, 6}, {{3, 1, 3}}})
                                 : obstacle("ground", GridShape{{6, 6}, {3, 3}}, Sides::OneSided);
  ground.transform.translate = solid ? Vec3{0.03, -0.5, 0.02} : Vec3{-3.03, 0, -3.02};
  ground.friction = 0.5;
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10, precision);
  scene.environment = {ground};
  scene.solver.type = solver;
  return scene;
}

/// The largest displacement (m) of a particle in a step after `settle` seconds, of the particles that touch the ground
/// and of all.
struct Jitter {
  double touching = 0, all = 0;
  std::size_t contacts = 0;
};
inline Jitter jitter(const Scene& scene, double settle, int steps) {
  Simulation simulation = after(scene, settle);
  std::vector<Vec3> before = simulation.positions();
  Jitter found;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    const std::vector<Vec3> now = simulation.positions();
    found.contacts = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double moved = length(now[i] - before[i]);
      found.all = std::max(found.all, moved);
      if (now[i][1] > 1.01 * scene.environment[0].thickness) continue;
      found.touching = std::max(found.touching, moved), ++found.contacts;
    }
    before = now;
  }
  return found;
}

}  // namespace malha
