// SPDX-License-Identifier: Apache-2.0
// Kinematic bodies push free ones out of their path; where they penetrate what cannot move, the run reports it.
#include <gtest/gtest.h>

#include "host/measure/solver_stats.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A level sheet and, half a metre below it, one whose pins move up by a metre in half a second.
Scene lifted_through(bool held) {
  std::vector<BodySpec> bodies(2);
  for (BodySpec& body : bodies) {
    body.shape = GridShape{{1, 1}, {6, 6}}, body.mass = 0.2;
    body.constraints = {stiff("distance", {"edges"})};
  }
  bodies[0].name = "upper", bodies[1].name = "lower";
  bodies[1].transform.translate = {0.03, -0.5, 0.04};
  ListPin most;  // a body needs a movable particle
  for (int i = 0; i < 48; ++i) most.particles.push_back(i);
  if (held) bodies[0].pins = {most};
  Pin pin = most;
  Keyframe start, end;
  end.time = 0.5, end.translate = {0, 1, 0};
  pin.motion = {start, end};
  bodies[1].pins = {pin};
  Scene scene = scene_of(bodies, {}, 1.0 / 60, 10, Precision::Float);
  scene.self_collision = SelfCollision{0.01, 0.2, {}};
  return scene;
}

TEST(KinematicPush, PinsThatPenetratePinsAreReportedAlsoByAResumedRun) {
  const TemporaryFolder folder;
  const std::string path = (folder / "checkpoint").string();
  const Scene scene = lifted_through(true);
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 30; ++step) {
    simulation.step(), simulation.count_crossings();
    const auto& self = *simulation.solver().facts().self;
    if (simulation.measure().crossings > 0) {
      EXPECT_GT(self.substeps_kinematic_penetration, 0) << "step " << step;
    }
  }
  const std::int64_t said = simulation.solver().facts().self->substeps_kinematic_penetration;
  EXPECT_GT(said, 0);
  EXPECT_GT(simulation.times().most_crossings, 0);
  simulation.save_checkpoint(path);
  Simulation resumed(scene, {.threads = 1});
  resumed.load_checkpoint(path);
  resumed.step();
  EXPECT_GE(resumed.solver().facts().self->substeps_kinematic_penetration, said);
  EXPECT_EQ(resumed.times().most_crossings, simulation.times().most_crossings);
  EXPECT_EQ(resumed.times().crossings_counted, 30);
}

TEST(KinematicPush, PinsPushFreeParticlesAndPenetrateNothing) {
  for (const bool release : {false, true}) {
    Scene scene = lifted_through(false);
    if (release) scene.bodies[1].pins[0].release_time = 0.49;
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 30; ++step) {
      simulation.step();
      ASSERT_EQ(simulation.measure().crossings, 0) << "step " << step << (release ? ", pins are let go" : "");
    }
    EXPECT_EQ(simulation.solver().facts().self->substeps_kinematic_penetration, 0);
    double lowest = 1;
    for (int i = 0; i < 49; ++i) lowest = std::min(lowest, simulation.positions()[i][1]);
    EXPECT_GT(lowest, 0.45) << "the upper sheet, which the lower one carried up from 0 to 0.5 m";
  }
}

// One corner of a sheet is pulled through another sheet, and released after it gets there.
TEST(KinematicPush, APinThatIsReleasedLaterPushesAsAnyOther) {
  for (const double speed : {20.0, 60.0}) {
    Scene scene = lifted_through(false);
    Pin pin = ListPin{{0}};
    Keyframe start, end;
    end.time = 0.1, end.translate = {0.2, 0.1 * speed, 0.2};
    pin.motion = {start, end}, pin.release_time = 0.15;
    scene.bodies[1].pins = {pin};
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 15; ++step) {
      simulation.step();
      ASSERT_EQ(simulation.measure().crossings, 0) << "step " << step << ", " << speed << " m/s";
    }
  }
}

}  // namespace
}  // namespace malha
