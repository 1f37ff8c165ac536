// SPDX-License-Identifier: Apache-2.0
// Momentum drift: the warning at the end of a run about free bodies whose angular momentum changed without an external
// torque.
#include "host/report/momentum_drift.h"

#include <gtest/gtest.h>

#include "tests/run_scenes.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

ConstraintSpec blown_up_to(double volume_ratio) { return stiff("pressure", {}, 1, volume_ratio); }

/// A sphere at rest that weighs 1.3 kg, for 5 s without gravity.
Scene sphere_at_rest(int substeps, std::vector<ConstraintSpec> constraints) {
  BodySpec sphere;
  sphere.name = "sphere", sphere.shape = SphereShape{0.3, 2}, sphere.mass = 1.3;
  sphere.constraints = std::move(constraints);
  Scene scene = scene_of({sphere}, {}, 1.0 / 60, substeps);
  scene.duration = 5;
  return scene;
}

struct FlightEnd {
  std::vector<std::string> lines;
  Measures state;
};

FlightEnd flown(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  const MomentumDrift momenta(simulation);
  run_for(simulation, scene, scene.duration);
  return {momenta.warnings(simulation), simulation.measure()};
}

bool one_says(const FlightEnd& end, const std::string& words) {
  return end.lines.size() == 1 && has(end.lines[0], words);
}

// Corrections of a substep that exceed a part of an element (kernels/projection/direction.h) go along the gradients at
// their end, and those exert a torque. They occur where a body starts far from its shape: crumpled shells, which never
// find it.
TEST(MomentumDrift, IsReportedWhereABodyStartsFarFromItsShapeAndPreventedByTheCorrector) {
  const std::vector<std::vector<ConstraintSpec>> crumpled{{stiff("distance", {"edges"}, 1, 1.5)},
                                                          {stiff("distance", {"edges"}, 1, 1.5), blown_up_to(1)},
                                                          {stiff("distance", {"edges"}), blown_up_to(5)}};
  for (const auto& constraints : crumpled)
    for (const int substeps : {10, 40}) {
      Scene scene = sphere_at_rest(substeps, constraints);
      const FlightEnd turned = flown(scene);
      EXPECT_GT(length(turned.state.angular_momentum), 0.05);
      EXPECT_TRUE(one_says(turned, "angular momentum from 0 to ")) << turned.lines.size();
      EXPECT_TRUE(one_says(turned, "take \"corrector\": \"inertia\""));
      scene.solver.keeps_momenta = true;
      const FlightEnd corrected = flown(scene);
      EXPECT_TRUE(corrected.lines.empty());
      EXPECT_LT(length(corrected.state.angular_momentum), 1e-10);
    }
}

// Each projection by itself exerts no torque, whether its constraint is satisfied or not, and whatever pulls against
// it. (A correction of more than a third of an element in a substep, as of stiff edges with 1.2 times the volume,
// does.)
TEST(MomentumDrift, IsNoneWhereConstraintsAgreeGiveWayOrContradictEachOther) {
  const std::vector<std::vector<ConstraintSpec>> all{{stiff("distance", {"edges"}), blown_up_to(1)},
                                                     {stiff("distance", {"edges"}), blown_up_to(1.1)},
                                                     {compliant("distance", 1e-4, {"edges"}), blown_up_to(1.2)},
                                                     {compliant("distance", 0.01, {"edges"}), blown_up_to(1.2)}};
  for (const auto& constraints : all)
    for (const int substeps : {10, 40}) {
      const FlightEnd end = flown(sphere_at_rest(substeps, constraints));
      EXPECT_TRUE(end.lines.empty()) << end.lines[0];
      EXPECT_LT(length(end.state.angular_momentum), 1e-12)  // kg m^2/s: a turning edge of 4e-12 m/s, of rounding
          << constraints[1].parameter << ", " << substeps;
    }
}

// Half a radian in a substep is beyond the validity of the gradient where it began.
TEST(MomentumDrift, IsReportedWhereABodyTurnsByHalfARadianInASubstep) {
  for (const int substeps : {10, 1}) {
    Scene scene = sphere_at_rest(substeps, {stiff("distance", {"edges"})});
    scene.bodies[0].spin = {0, 30, 0}, scene.duration = 1;
    const double had = Simulation(scene, {.threads = 1}).measure().angular_momentum[1];
    const FlightEnd end = flown(scene);
    EXPECT_EQ(one_says(end, "though no torque acted on it"), substeps == 1);
    EXPECT_EQ(end.state.angular_momentum[1] < 0.9 * had, substeps == 1);
    scene.solver.keeps_momenta = true;
    EXPECT_NEAR(flown(scene).state.angular_momentum[1], had, 1e-11 * had);
  }
}

/// The filter reduces rotation, and its corrector restores it.
TEST(MomentumDrift, IsReportedWhereDesbrunsFilterRunsWithoutItsCorrector) {
  Scene scene = sphere_at_rest(10, {compliant("distance", 0.02, {"edges"})});
  scene.bodies[0].spin = {0, 3, 0}, scene.solver.type = "desbrun", scene.solver.desbrun.corrector = Corrector::Off;
  EXPECT_TRUE(one_says(flown(scene), "the filter changed its angular momentum"));
  scene.solver.desbrun.corrector = Corrector::Inertia;
  EXPECT_TRUE(flown(scene).lines.empty());
}

TEST(MomentumDrift, IsNotReportedWhereSomethingMayTakeMomenta) {
  const Scene free = sphere_at_rest(10, {stiff("distance", {"edges"}, 1, 1.5)});
  Scene falling = free, held = free, windy = free, asleep = free, walled = free;
  falling.gravity = kEarth;
  EXPECT_EQ(flown(falling).lines.size(), 1u) << "gravity turns nothing";
  held.bodies[0].pins = {ListPin{{0}}}, windy.wind = Wind{}, asleep.sleep = Sleep{};
  EnvironmentSpec wall;
  wall.name = "wall", wall.shape = GridShape{{1, 1}, {1, 1}}, wall.sides = Sides::TwoSided;
  wall.transform.translate = {0, -2, 0};
  walled.environment = {wall};
  Scene sewn = free;
  sewn.bodies.push_back(free.bodies[0]);
  sewn.bodies[1].name = "other";
  sewn.seams = {{{sewn.bodies[0].name, {}}, {"other", {}}, {}, {{0, 0}}, 0, 0}};
  for (const Scene& scene : {held, windy, asleep, walled, sewn}) EXPECT_TRUE(flown(scene).lines.empty());
}

TEST(MomentumDrift, IsReportedAtTheEndOfARunAndInItsReport) {
  const TemporaryFolder folder;
  Json scene = Json::parse(R"({
    "name": "ball", "solver": {"type": "pbd", "dt": 0.02, "substeps": 20}, "gravity": [0, 0, 0], "duration": 2,
    "bodies": [{"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 2}}, "mass": 1,
                "constraints": [{"type": "distance"}, {"type": "pressure", "volume_ratio": 5}]}]})");
  for (const bool corrects : {false, true}) {
    if (corrects) scene["solver"]["corrector"] = "inertia";
    std::vector<std::string> said;
    const std::string out = (folder / "out").string();
    run_quietly(scene, {.out = out, .warn = [&said](const std::string& line) { said.push_back(line); }});
    EXPECT_EQ(said.size(), corrects ? 0u : 1u);
    EXPECT_EQ(Json::parse(bytes_of(folder / "out/report.json"))["notes"], Json(said));
  }
}

}  // namespace
}  // namespace malha
