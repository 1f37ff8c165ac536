// SPDX-License-Identifier: Apache-2.0
// Heaps of cloth: cloths that fall, fold and are thrown together in the air and on the ground intersect nowhere,
// however thin the contact thickness and however coarse the substeps.
#include <gtest/gtest.h>

#include <cmath>

#include "host/measure/solver_stats.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

BodySpec sheet_in_the_air(const std::string& name, Shape shape, Random& random) {
  BodySpec body;
  body.name = name;
  body.shape = std::move(shape);
  body.density = 0.2;
  body.constraints = {stiff("distance", {"edges"}), stiff("bending", {}, 0.02)};
  const Vector3<double> axis = random.direction(), v = random.in_cube(4), spin = random.in_cube(8);
  body.transform.axis = {axis.x, axis.y, axis.z};
  body.transform.degrees = random(0, 180);
  body.velocity = {v.x, v.y - 2, v.z};
  body.spin = {spin.x, spin.y, spin.z};
  return body;
}

EnvironmentSpec heap_ground(double thickness) {
  EnvironmentSpec ground;
  ground.name = "ground";
  ground.shape = GridShape{{20, 20}, {1, 1}};
  ground.transform.translate = {-10, 0, -10};
  ground.sides = Sides::OneSided;
  ground.thickness = thickness;
  ground.friction = 0.4;
  return ground;
}

/// The most intersections at the end of a step; `held` counts the substeps in which displacements were truncated.
std::int64_t most_crossings(const Scene& scene, int steps, std::int64_t& held) {
  Simulation simulation(scene, {.threads = 1});
  std::int64_t most = 0;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    most = std::max(most, static_cast<std::int64_t>(simulation.measure().crossings));
  }
  held += simulation.solver().facts().self->substeps_truncated;
  return most;
}

/// One or two sheets above each other are thrown to the ground, with a thickness of 0.2 to 10 mm, in 1 to 10 substeps.
Scene random_heap(unsigned seed, int vertices, const TemporaryFolder& folder) {
  Random random(seed);
  const int across = static_cast<int>(std::sqrt(vertices / 1.4)) - 1, along = vertices / (across + 1) - 1;
  Scene scene =
      scene_of({}, kEarth, 1.0 / 60, 1 + random.below(10), random() < 0.5 ? Precision::Float : Precision::Double);
  for (int k = 0; k <= random.below(2); ++k) {
    const std::string name = "sheet" + std::to_string(seed) + "_" + std::to_string(k);
    MeshFile mesh;
    mesh.path = folder.write(name + ".obj", irregular_sheet(0.7, 1, across, along, random));
    scene.bodies.push_back(sheet_in_the_air(name, mesh, random));
    scene.bodies.back().transform.translate = {0, 1.2 + 2.6 * k, 0};
    scene.bodies.back().velocity[1] -= 8 * k;
  }
  const double thickness = 2e-4 * std::pow(50, random(0, 1));
  scene.self_collision = SelfCollision{thickness, std::max(0.0, random()), {}};
  scene.environment = {heap_ground(0.005)};
  return scene;
}

// These of sixty scenes with 250 vertices intersected while truncated particles could meet pairs that the broad phase
// had not found.
TEST(Heaps, OfThinClothNeverCross) {
  const TemporaryFolder folder;
  std::int64_t held = 0;
  for (const unsigned seed : {12u, 20u, 32u, 46u, 53u}) {
    const Scene scene = random_heap(seed, 250, folder);
    EXPECT_EQ(most_crossings(scene, 35, held), 0)
        << "seed " << seed << ", thickness " << scene.self_collision->thickness << ", " << scene.solver.substeps
        << " substeps";
  }
}

TEST(Heaps, DISABLED_OfAThousandVerticesNeverCross) {
  const TemporaryFolder folder;
  std::int64_t held = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Scene scene = random_heap(seed, 1364, folder);
    EXPECT_EQ(most_crossings(scene, 60, held), 0)
        << "seed " << seed << ", thickness " << scene.self_collision->thickness << ", " << scene.solver.substeps
        << " substeps";
  }
}

}  // namespace
}  // namespace malha
