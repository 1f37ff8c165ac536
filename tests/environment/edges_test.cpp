// SPDX-License-Identifier: Apache-2.0
// Contacts with edges of the environment: spikes, rods and corners that are finer than a cloth do not go through it.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "host/environment/edge_crossings.h"
#include "host/measure/solver_stats.h"
#include "host/model/model.h"
#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "tests/environment/edged_solids.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Nails `spacing` apart, their tips at y = 0.
EdgedSolids bed_of_nails(double spacing, double radius) {
  EdgedSolids bed;
  for (double x = -0.31; x < 0.3; x += spacing)
    for (double z = -0.29; z < 0.3; z += spacing) bed.nail({x, 0, z}, 0.2, radius, 4, 31 * x);
  return bed;
}

Scene falls_on(const EnvironmentSpec& object, const BodySpec& cloth, int substeps = 5) {
  Scene scene = scene_of({cloth}, kEarth, 1.0 / 60, substeps, Precision::Float);
  scene.environment = {object};
  return scene;
}

/// The most intersections after any of the first `steps` steps, counted as for an object that names its edges.
std::int64_t most_crossings(Scene scene, bool edges, int steps) {
  for (EnvironmentSpec& object : scene.environment) object.edges = true;
  const Model counted_with = build_model(scene);
  for (EnvironmentSpec& object : scene.environment) object.edges = edges;
  Simulation simulation(scene, {.threads = 1});
  std::int64_t most = 0;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    const std::vector<Vec3> user = simulation.positions();
    std::vector<Vec3> x(user.size());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = user[counted_with.user_index[i]];
    const std::int64_t now = count_edge_crossings(counted_with, x, simulation.solver().time());
    if (edges) {
      EXPECT_EQ(simulation.measure().crossings, now);
    }
    most = std::max(most, now);
  }
  return most;
}

void expect_held_by_edges_alone(const Scene& scene, int steps) {
  EXPECT_GT(most_crossings(scene, false, steps), 0);
  EXPECT_EQ(most_crossings(scene, true, steps), 0);
}

TEST(EnvironmentEdges, ABedOfNailsHoldsACloth) {
  const TemporaryFolder folder;
  expect_held_by_edges_alone(falls_on(bed_of_nails(0.13, 0.02).object(folder, "bed"), cloth_above(0.03)), 25);
}

TEST(EnvironmentEdges, FinerNailsHoldAFastIrregularCloth) {
  const TemporaryFolder folder;
  BodySpec cloth = cloth_above(0.15, folder.write("cloth.obj", irregular_obj(1, 1, 10, 10, 0.3, 5)));
  cloth.velocity = {1, -10, 0};
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    Scene scene = falls_on(bed_of_nails(0.07, 0.01).object(folder, "bed"), cloth, 2);
    scene.solver.precision = precision;
    expect_held_by_edges_alone(scene, 10);
  }
}

TEST(EnvironmentEdges, APicketOfRodsHoldsAClothByBothMethods) {
  const TemporaryFolder folder;
  EdgedSolids rods;
  for (double x = -0.33; x < 0.4; x += 0.23)
    for (double z = -0.33; z < 0.4; z += 0.23) rods.box({x, -0.3, z}, {x + 0.004, 0, z + 0.004});
  Scene scene = falls_on(rods.object(folder, "rods"), cloth_above(0.03));
  expect_held_by_edges_alone(scene, 20);
  scene.solver.type = "desbrun";
  scene.solver.substeps = 4;
  scene.bodies[0].constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
  expect_held_by_edges_alone(scene, 20);
}

// A rod of 4 mm comes from the side, turns, and goes back. Without contacts of its edges it would go through a sheet of
// cells of 0.1 m.
TEST(EnvironmentEdges, AMovingRodSweepsASheetAlong) {
  const TemporaryFolder folder;
  EdgedSolids rod;
  rod.box({-0.002, -0.2, -0.002}, {0.002, 0.05, 0.002});
  EnvironmentSpec object = rod.object(folder, "rod");
  Keyframe low, high, back;
  low.translate = {0.03, -0.2, 0.04};
  high.time = 0.1, high.translate = {0.08, 0.3, 0.1}, high.axis = {0, 0, 1}, high.degrees = 40;
  back.time = 0.2, back.translate = {-0.3, 0.1, 0}, back.axis = {0, 0, 1}, back.degrees = -30;
  object.motion = {low, high, back};
  Scene scene = falls_on(object, cloth_above(0), 4);
  scene.gravity = {};
  expect_held_by_edges_alone(scene, 12);
}

TEST(EnvironmentEdges, OfASecondObjectAndASecondLayerKeepTheirPromise) {
  const TemporaryFolder folder;
  BodySpec upper = cloth_above(0.08);
  upper.name = "upper", upper.velocity = {0, -2, 0};
  EdgedSolids rod;
  rod.box({-0.4, -0.003, 0.043}, {0.4, 0.001, 0.046});
  Scene scene = falls_on(bed_of_nails(0.17, 0.02).object(folder, "bed"), cloth_above(0.03));
  scene.environment.push_back(rod.object(folder, "rod"));
  scene.bodies.push_back(upper);
  scene.self_collision = SelfCollision{0.01, 0.2, {}};
  expect_held_by_edges_alone(scene, 20);
}

// A strip hangs over a thin rod between two rows of particles: both legs hang straight down, and the rod carries all of
// its weight.
TEST(EnvironmentEdges, ARodBetweenParticlesCarriesAStrip) {
  const TemporaryFolder folder;
  EdgedSolids rod;
  rod.box({-0.5, -0.004, -0.002}, {0.5, 0, 0.002});
  EnvironmentSpec object = rod.object(folder, "rod");
  object.friction = 0.6;
  BodySpec strip = cloth_above(0.02);
  strip.shape = GridShape{{0.2, 1.1}, {2, 11}};  // the rod lies under the middle of the sixth of eleven cells
  strip.transform.translate = {-0.1, 0.02, -0.55};
  strip.constraints = {stiff("distance", {"edges", "shear"})};
  strip.damping = 0.3;
  Scene scene = falls_on(object, strip, 20);
  scene.solver.precision = Precision::Double;
  object.edges = true, scene.environment = {object};
  Simulation simulation = after(scene, 3);
  const Measures m = simulation.measure();
  EXPECT_EQ(m.crossings, 0);
  EXPECT_GT(m.edge_contacts, 0);
  EXPECT_LT(m.speed_max, 0.05);
  // The top cell of 0.1 m bends only at its rows, and lies across the rod, half of the thickness above it; the legs
  // hang from its ends. The centre of mass: five cells a leg lie below the top, at 0.25 m for 10 of the 11 cells of
  // mass.
  double y = 0;
  const std::vector<Vec3> x = simulation.positions();
  std::vector<double> share(12, 1);
  share.front() = share.back() = 0.5;
  for (int row = 0; row < 12; ++row) y += share[row] * (x[3 * row][1] + 2 * x[3 * row + 1][1] + x[3 * row + 2][1]) / 4;
  // The tolerance is the thickness (1 cm), by which the top's height is not exact, and the remaining oscillation of the
  // legs.
  EXPECT_NEAR(y / 11, 0.005 - 10.0 / 11 * 0.25, 0.012);
}

TEST(EnvironmentEdges, LeaveAloneWhatTheyDoNotTouch) {
  const TemporaryFolder folder;
  // Nails 3 cm below a sheet that passes over them at 2 m/s, with a thickness of 1 cm.
  BodySpec cloth = cloth_above(0.03);
  cloth.velocity = {2, 0, 0.3}, cloth.spin = {0, 1, 0};
  EnvironmentSpec bed = bed_of_nails(0.13, 0.02).object(folder, "bed");
  const auto hash = [&](bool edges) {
    bed.edges = edges;
    Scene scene = falls_on(bed, cloth);
    scene.gravity = {};
    return after(scene, 0.3).state_hash();
  };
  EXPECT_EQ(hash(true), hash(false));
}

TEST(EnvironmentEdges, CostNothingWhereNoneAreNamed) {
  const TemporaryFolder folder;
  EnvironmentSpec bed = bed_of_nails(0.13, 0.02).object(folder, "bed");
  Simulation without(falls_on(bed, cloth_above(0.03)), {.threads = 1});
  without.step();
  EXPECT_FALSE(without.solver().facts().edges.has_value());
  EXPECT_EQ(without.solver().pass_seconds()[static_cast<int>(Pass::Edges)], 0);
  EXPECT_FALSE(has(plan(without), "environment_edges:"));
  bed.edges = true;
  Simulation with(falls_on(bed, cloth_above(0.03)), {.threads = 1});
  // 25 pyramids of four sides: 8 edges and 5 corners each; the diagonal of the base is flat.
  EXPECT_TRUE(has(plan(with), "environment_edges:\n  edges: 200\n  corners: 125\n"));
  EXPECT_GT(with.solver().facts().edges->bytes, 0u);
}

TEST(EnvironmentEdges, RefuseABodyThatTheyCrossAtTheStart) {
  const TemporaryFolder folder;
  EnvironmentSpec bed = bed_of_nails(0.13, 0.02).object(folder, "bed");
  bed.edges = true;
  const std::string message = refusal([&] { Simulation(falls_on(bed, cloth_above(-0.005)), {.threads = 1}); });
  EXPECT_TRUE(has(message, "/environment/0/edges")) << message;
  EXPECT_TRUE(has(message, "crosses at the start")) << message;
}

/// Nails and rods at random positions, 0.3 to 3 edges apart, under a cloth of 0 to 10 m/s, with 1 to 20 substeps.
Scene at_random(const TemporaryFolder& folder, Random& random, int k) {
  EdgedSolids solids;
  const double spacing = 0.1 * 0.3 * std::pow(10, random(0, 1));
  for (double x = -0.4; x < 0.4; x += spacing)
    for (double z = -0.4; z < 0.4; z += spacing) {
      const Vec3 tip{x + random(-0.2, 0.2) * spacing, random(-0.05, 0), z + random(-0.2, 0.2) * spacing};
      const double wide = spacing * random(0.02, 0.25);
      if (random() < 0)
        solids.nail(tip, 0.2, wide, 3 + random.below(4), random(0, 6));
      else
        solids.box({tip[0], -0.2, tip[2]}, {tip[0] + wide, tip[1], tip[2] + wide});
    }
  EnvironmentSpec object = solids.object(folder, "solids" + std::to_string(k));
  object.thickness = random(0.002, 0.02), object.friction = random(0, 0.6);
  if (k % 3 == 0) {
    Keyframe start, end;
    end.time = 0.15, end.translate = {random(-0.2, 0.2), random(0, 0.3), random(-0.2, 0.2)};
    end.axis = {random(), random(), 1.5}, end.degrees = random(-40, 40);
    object.motion = {start, end};
  }
  BodySpec cloth = cloth_above(0.05, k % 2 == 0 ? folder.write("c.obj", irregular_obj(1, 1, 10, 10, 0.3, k)) : "");
  cloth.velocity = {random(-2, 2), -std::pow(10, random(-1, 1)), random(-2, 2)};
  cloth.spin = {random(-3, 3), random(-3, 3), random(-3, 3)};
  constexpr int substeps[] = {1, 2, 5, 10, 20};
  Scene scene = falls_on(object, cloth, substeps[k % 5]);
  scene.solver.precision = k % 4 < 2 ? Precision::Float : Precision::Double;
  if (k % 7 == 0) scene.solver.iterations = 3;
  return scene;
}

// The candidate pairs follow from a broad phase some substeps ago, and so, sometimes, does truncation.
TEST(EnvironmentEdges, GiveTheSameBitsFromACheckpointOfAnyStep) {
  const TemporaryFolder folder;
  Random random(8);
  for (int k = 0; k < 40; ++k) {
    Scene scene = at_random(folder, random, k);
    if (k % 5 > 1) continue;  // with many substeps hardly any displacement is truncated
    scene.environment[0].edges = true;
    Simulation whole(scene, {.threads = 1});
    for (int step = 0; step < 12; ++step) {
      whole.save_checkpoint(folder.write("at" + std::to_string(step), ""));
      whole.step();
    }
    Simulation resumed(scene, {.threads = 1});
    for (int stop = 0; stop < 12; ++stop) {
      resumed.load_checkpoint(folder / ("at" + std::to_string(stop)));
      for (int step = stop; step < 12; ++step) resumed.step();
      EXPECT_EQ(resumed.state_hash(), whole.state_hash()) << "case " << k << ", stopped at step " << stop;
    }
  }
}

// A cloth moves at 188 m/s with one substep: its constraints pull particles off their straight paths by metres, and it
// meets a bar that turns beside two other objects.
TEST(EnvironmentEdges, StopWhatConstraintsPullOffItsPath) {
  const Scene scene = parse_scene(
      R"({"name": "s", "solver": {"type": "pbd", "substeps": 1, "precision": "double"}, "gravity": [0, -9.81, 0],
      "bodies": [{"name": "b1", "shape": {"grid": {"size": [1, 1], "cells": [9, 9]}}, "transform": {"translate":
      [-0.4, 0.35, -0.5]}, "density": 0.2, "velocity": [-10.831769441912925, -187.84259604882527,
      -10.184528557708576], "constraints": [{"type": "distance", "elements": ["edges"], "compliance": 0}, {"type":
      "bending", "stiffness": 0.05}]}], "duration": 0.4, "environment": [{"name": "e0", "shape": {"bar": {"length":
      0.6, "width": 0.05, "cells": 1}}, "transform": {"translate": [-0.4, -0.3, -0.018339139502065616]}, "sides":
      "solid", "thickness": 0.01, "friction": 0, "restitution": 0, "edges": true, "motion": [{"time": 0}, {"time":
      0.2, "translate": [0.07912127204044439, 0.9349836303310131, -0.9986138607441528], "rotate": {"axis":
      [-0.5515026155832312, 0.35890577249101563, 1.5], "degrees": 90.46666932758257}}]}, {"name": "e1", "shape":
      {"box": {"size": [0.1, 0.3, 0.1], "cells": [1, 1, 1]}}, "transform": {"translate": [0.0, -0.3,
      0.2739633497667338]}, "sides": "solid", "thickness": 0.01, "friction": 0.3, "restitution": 0, "edges": false,
      "motion": [{"time": 0}, {"time": 0.3, "translate": [-0.0874424362169558, -0.20209879822307697,
      0.33835790372468033], "rotate": {"axis": [0.5465546956764935, 0.5634996198482227, 1.5], "degrees":
      -0.3714400318129947}}]}, {"name": "e2", "shape": {"bar": {"length": 0.6, "width": 0.05, "cells": 1}},
      "transform": {"translate": [0.4, -0.3, -0.10432817695496516]}, "sides": "solid", "thickness": 0.01, "friction":
      0, "restitution": 0, "edges": false}], "outputs": {}})",
      "test.json", ".");
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 24; ++step) {
    simulation.step();
    EXPECT_EQ(simulation.measure().crossings, 0) << "step " << step;
  }
}

TEST(EnvironmentEdges, DISABLED_HoldInALargeSweep) {
  const TemporaryFolder folder;
  Random random(18);
  int cases = 0, poked = 0;
  for (int k = 0; k < 300; ++k) {
    const Scene scene = at_random(folder, random, k);
    ++cases, poked += most_crossings(scene, false, 20) > 0;
    EXPECT_EQ(most_crossings(scene, true, 20), 0) << "case " << k;
  }
  std::printf("%d cases, %d of which cross without edges\n", cases, poked);
}

Scene cloth_on_a_bed_of_nails(const TemporaryFolder& folder, bool moves) {
  EnvironmentSpec bed = bed_of_nails(0.09, 0.01).object(folder, "bed");
  bed.edges = true;
  Keyframe start, end;
  end.time = 0.2, end.translate = {0.05, 0.02, 0}, end.axis = {0, 1, 0}, end.degrees = 10;
  if (moves) bed.motion = {start, end};
  BodySpec cloth = cloth_above(0.03);
  cloth.shape = GridShape{{1, 1}, {24, 24}}, cloth.velocity = {0, -2, 0};
  return falls_on(bed, cloth, 3);
}

void expect_edge_contacts(const Simulation& simulation) { EXPECT_GT(simulation.measure().edge_contacts, 10); }

INSTANTIATE_TEST_SUITE_P(
    EnvironmentEdges, SameBits,
    testing::Values(SameBitsScene{"OfABedThatRests",
                                  [](const TemporaryFolder& folder) { return cloth_on_a_bed_of_nails(folder, false); },
                                  5,
                                  {2},
                                  expect_edge_contacts},
                    SameBitsScene{"OfABedThatMoves",
                                  [](const TemporaryFolder& folder) { return cloth_on_a_bed_of_nails(folder, true); },
                                  5,
                                  {2},
                                  expect_edge_contacts}),
    name_of_scene);

}  // namespace
}  // namespace malha
