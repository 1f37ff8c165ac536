// SPDX-License-Identifier: Apache-2.0
// Collisions at any speed add no energy and conserve momentum: contacts, truncation and the restoration of momenta only
// ever dissipate.
#include <gtest/gtest.h>

#include "host/measure/solver_stats.h"
#include "host/report/launches.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A sheet of `cells` by `cells`, a shell or a block, with one of three masses.
BodySpec sheet_shell_or_block(Random& random, const TemporaryFolder& folder, std::size_t number, int cells) {
  constexpr double masses[] = {0.1, 0.5, 2};
  BodySpec body;
  body.name = "body" + std::to_string(number);
  const int kind = random.below(3);
  if (kind == 0)
    body.shape = MeshFile{folder.write(body.name + ".obj", irregular_sheet(0.5, 0.5, cells, cells, random))};
  else if (kind == 1)
    body.shape = SphereShape{0.2, 1};
  else
    body.shape = TetBoxShape{{0.3, 0.3, 0.3}, {2, 2, 2}};
  body.mass = masses[random.below(3)];
  return body;
}

/// Two to four sheets, shells and blocks of different masses fly at each other at 1 to 150 m/s, with a step of one
/// substep, 1 to 20 of them in a sixtieth of a second. There are no other forces.
Scene jamming(Random& random, const TemporaryFolder& folder, const std::vector<ConstraintSpec>& constraints) {
  const auto between = [&](double least, double most) { return least * std::pow(most / least, random(0, 1)); };
  const double thickness = between(0.0005, 0.01), speed = between(1, 150);
  const int substeps = 1 + random.below(20), last = 1 + random.below(3);
  std::vector<BodySpec> bodies;
  for (int b = 0; b <= last; ++b) {
    BodySpec body = sheet_shell_or_block(random, folder, static_cast<std::size_t>(b), 5);
    const bool sheet = std::holds_alternative<MeshFile>(body.shape);
    const Vector3<double> axis = random.direction();
    body.transform.axis = {axis.x, axis.y, axis.z};
    body.transform.degrees = random(0, sheet ? 25 : 180);
    const double corner = sheet ? 0.25 : 0;  // the origin of a sheet is its corner
    body.transform.translate = {random(-0.1, 0.1) - corner, 0.5 * b, random(-0.1, 0.1) - corner};
    body.velocity = {0.2 * speed * random(), speed * (b == 0 ? 1 : b == last ? -1 : random()), 0.2 * speed * random()};
    if (random.below(3) == 0) body.spin = {random(-3, 3), random(-3, 3), random(-3, 3)};
    body.constraints = constraints;
    bodies.push_back(body);
  }
  const Precision precision = random.below(2) == 0 ? Precision::Float : Precision::Double;
  Scene scene = scene_of(bodies, {}, 1.0 / 60 / substeps, 1, precision);
  scene.self_collision = SelfCollision{thickness, random.below(2) == 0 ? 0 : 0.3, {}};
  return scene;
}

struct Collided {
  int scenes = 0, touching = 0;
  std::int64_t held = 0;
};

/// `most_gain`: of the initial kinetic energy, in one substep. `rounds`: the displacement due to float's rounding of
/// positions in the substeps without truncation, m.
Collided collide(unsigned seed, const std::vector<ConstraintSpec>& constraints, double most_gain, double rounds) {
  const TemporaryFolder folder;
  Random random(seed);
  Collided found;
  while (found.scenes < 40) {
    const Scene scene = jamming(random, folder, constraints);
    SCOPED_TRACE("scene " + std::to_string(found.scenes));
    Simulation simulation(scene, {.threads = 1});
    const Measures start = simulation.measure();
    Measures before = start;
    double momentum = 0, mass = 0;
    for (const BodySpec& body : scene.bodies) momentum += *body.mass * length(body.velocity), mass += *body.mass;
    const double rounding = scene.solver.precision == Precision::Float
                                ? 1e-6 * momentum + mass * rounds / scene.solver.dt
                                : 1e-12 * momentum;
    int contacts = 0;
    for (int step = 0; step < std::min(40, 8 + static_cast<int>(0.06 / scene.solver.dt)); ++step) {
      simulation.step();
      const Measures now = simulation.measure();
      EXPECT_LE(now.kinetic, before.kinetic + most_gain * start.kinetic) << "step " << step;
      EXPECT_LE(now.kinetic, start.kinetic * 1.02) << "step " << step;
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(now.momentum[k], start.momentum[k], rounding) << "step " << step;
      contacts += now.self_contacts, before = now;
    }
    EXPECT_EQ(before.crossings, 0);
    found.held += simulation.solver().facts().self->substeps_truncated;
    found.touching += contacts > 0 ? 1 : 0, ++found.scenes;
  }
  return found;
}

// Bodies without constraints: only contacts change their energy. In float positions are rounded to 1e-7 m. In both
// precisions pairs that are nearer than the thickness are pushed apart by a tenth of the deficit: up to 1e-7 of the
// energy here.
TEST(Jammed, NoContactAddsEnergyAtAnySpeed) {
  const Collided found = collide(21, {}, 1e-5, 6e-8);
  EXPECT_GT(found.touching, 30);
  EXPECT_GT(found.held, 300);
}

// Energy that an impact stores in springs is released as motion: a twentieth at once, in all no more than was stored.
// Each projection rounds positions once more.
TEST(Jammed, BodiesThatSeparateAgainHaveNoMoreEnergyThanBefore) {
  const Collided found = collide(22, {stiff("distance", {"edges"})}, 0.1, 5e-7);
  EXPECT_GT(found.touching, 30);
  EXPECT_GT(found.held, 300);
}

/// One to three bodies: pins push the first one into the others, into itself, and, in some scenes, into the edges of a
/// ground or a box. The number is an upper bound of the speed of these pins, m/s.
std::pair<Scene, double> driven_jam(Random& random, const TemporaryFolder& folder) {
  const auto between = [&](double least, double most) { return least * std::pow(most / least, random(0, 1)); };
  const Vec3 at{random(-3, 3), random(0, 2), random(-3, 3)};
  std::vector<BodySpec> bodies(1 + random.below(3));
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    BodySpec& body = bodies[b] = sheet_shell_or_block(random, folder, b, 6);
    body.transform.translate = {at[0], at[1] + 0.5 * static_cast<double>(b), at[2]};
    body.constraints = {random.below(2) == 0 ? stiff("distance", {"edges"})
                                             : compliant("distance", between(1e-5, 3e-2), {"edges"})};
  }
  ListPin list;
  for (int i = 0, first = random.below(8), count = 1 + random.below(5); i < count; ++i)
    list.particles.push_back(first + i);
  Pin pin(list);
  Keyframe start, end;
  const Vector3<double> axis = random.direction();
  end.time = random(0.03, 0.3), end.degrees = random(30, 180), start.axis = end.axis = {axis.x, axis.y, axis.z};
  end.translate = {random(), random(), random()};
  pin.motion = {start, end}, bodies[0].pins = {pin};
  const double farthest = length(at) + 0.7;  // the largest distance of a body's particles from the origin
  const double fastest = (length(end.translate) + end.degrees * kPi / 180 * farthest) / end.time;
  const Precision precision = random.below(2) == 0 ? Precision::Float : Precision::Double;
  Scene scene = scene_of(bodies, kEarth, 1.0 / 60, 4 + random.below(9), precision);
  scene.self_collision = SelfCollision{between(0.001, 0.01), random.below(2) == 0 ? 0 : 0.3, {}};
  if (random.below(2) == 0) {
    EnvironmentSpec ground;
    ground.name = "ground", ground.shape = BoxShape{{20, 1, 20}, {{4, 1, 4}}},
    ground.transform.translate = {0, -1.3, 0};
    ground.friction = 0.3, ground.edges = random.below(2) == 0;
    scene.environment = {ground};
  }
  return {scene, fastest};
}

// No particle is pushed to more than twice the speed of what pushes it, whatever jams between the two.
TEST(Jammed, WhatPinsPushIsNotMuchFasterThanThePins) {
  const TemporaryFolder folder;
  Random random(31);
  std::int64_t held = 0;
  for (int k = 0; k < 24; ++k) {
    const auto [scene, fastest] = driven_jam(random, folder);
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 18; ++step) {
      simulation.step();
      EXPECT_LE(simulation.measure().speed_max, 2 * fastest) << "scene " << k << ", step " << step;
    }
    held += simulation.solver().facts().self->substeps_truncated;
  }
  EXPECT_GT(held, 300);
}

// Three sheets lie above the edges of a ground, and a row of the middle one is torn through the others in one substep.
// Each pass of projection, pushing and moving along applies displacements (ApplyDisplacements): once for the
// projection, and at most 8, 8 and 16 times for the others, however often bodies and edges are truncated in turns.
TEST(Jammed, ARoundOfPushesIsNotRepeatedWithoutEndAndTheRunReportsWhatStaysJammed) {
  const TemporaryFolder folder;
  for (const unsigned seed : {26u, 60u}) {
    Random random(seed);
    std::vector<BodySpec> bodies(3);
    for (int b = 0; b < 3; ++b) {
      bodies[b].name = "sheet" + std::to_string(b);
      bodies[b].shape = MeshFile{folder.write(bodies[b].name + ".obj", irregular_sheet(0.5, 0.5, 6, 6, random))};
      bodies[b].mass = 0.2, bodies[b].transform.translate = {0.01 * b, 0.03 * b + 0.03, 0.01 * b};
      bodies[b].constraints = {stiff("distance", {"edges"})};
    }
    Pin pin(ListPin{{0, 1, 2, 3, 4, 5, 6}});
    Keyframe start, end;
    end.time = random(0.02, 0.06), end.degrees = random(60, 180);
    const Vector3<double> axis = random.direction();
    start.axis = end.axis = {axis.x, axis.y, axis.z}, end.translate = {random(), random(), random()};
    pin.motion = {start, end}, bodies[1].pins = {pin};
    Scene scene = scene_of(bodies, kEarth, 1.0 / 60, 1);
    scene.self_collision = SelfCollision{0.01, 0.3, {}};
    EnvironmentSpec ground;
    ground.name = "ground", ground.shape = BoxShape{{2, 1, 2}, {{8, 1, 8}}},
    ground.transform.translate = {0.2, -0.51, 0.2};
    ground.edges = true, ground.friction = 0.3;
    scene.environment = {ground};
    Simulation simulation(scene, {.threads = 1});
    simulation.step();
    std::int64_t rounds = 0;
    for (const Launches& one : simulation.times().launches)
      if (one.kernel.starts_with("ApplyDisplacements")) rounds += one.launches;
    EXPECT_GT(rounds, 1 + 8) << "it jams";
    EXPECT_LE(rounds, 1 + 8 + 8 + 16) << "seed " << seed;
    EXPECT_GT(simulation.solver().facts().self->substeps_kinematic_penetration, 0);
  }
}

/// An irregular sheet of weak springs.
BodySpec weak_sheet(Random& random, const TemporaryFolder& folder, const std::string& name, double y, double mass) {
  BodySpec body;
  body.name = name, body.mass = mass, body.transform.translate = {-0.2, y, -0.2};
  body.shape = MeshFile{folder.write(name + ".obj", irregular_sheet(0.4, 0.4, 4, 4, random))};
  body.constraints = {compliant("distance", 0.01, {"edges"})};
  return body;
}

// Pins pull a sheet through a free one into a static box. The box moves particles out of it, and self-collision
// truncates that: the velocity is no more than the displacement that was made.
TEST(Jammed, WhatABoxLiftsAndABodyHoldsBackHasNoSpeed) {
  const TemporaryFolder folder;
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const unsigned seed : {1u, 2u, 3u}) {
      Random random(seed);
      BodySpec drawn = weak_sheet(random, folder, "drawn", 0.08, 6);
      Pin pins = ListPin{{7, 8, 2, 5, 22}};
      pins.motion = {{.time = 0}, {.time = 0.2, .translate = {-0.11, -0.35, 0.47}}};
      drawn.pins = {pins};
      EnvironmentSpec box;
      box.name = "box", box.shape = BoxShape{{3, 0.5, 3}, {{1, 1, 1}}}, box.transform.translate = {0, -0.3, 0};
      Scene scene = scene_of({weak_sheet(random, folder, "free", 0, 1.6), drawn}, kEarth, 1.0 / 600, 1, precision);
      scene.environment = {box}, scene.self_collision = SelfCollision{0.005, 0.5, {}};
      Simulation simulation(scene, {.threads = 1});
      double fastest = 0, phantom = 0;  // m/s; the second is the part of the velocity without a displacement
      std::vector<Vec3> before = simulation.positions();
      for (int step = 0; step < 180; ++step) {
        simulation.step();
        const std::vector<Vec3> after = simulation.positions(), v = simulation.velocities();
        for (std::size_t i = 0; i < v.size(); ++i) {
          fastest = std::max(fastest, length(v[i]));
          phantom = std::max(phantom, length(v[i]) - 600 * length(after[i] - before[i]));
        }
        before = after;
      }
      EXPECT_LT(phantom, precision == Precision::Float ? 1e-3 : 1e-9) << seed;  // m/s: rounding of positions, 600 times
      EXPECT_GT(fastest, 1) << "nothing was drawn: the case does not occur";
    }
}

}  // namespace
}  // namespace malha
