// SPDX-License-Identifier: Apache-2.0
// Bodies that start inside solids are refused, or moved out without gaining velocity.
#include <gtest/gtest.h>

#include <string>

#include "host/environment/initial_overlap.h"
#include "host/model/model.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A ball of 0.5 m at `at`, and a solid that is translated and rotated.
Scene ball_in_a_solid(const Vec3& at, const Shape& solid, bool push_out) {
  BodySpec ball;
  ball.name = "ball", ball.shape = SphereShape{0.5, 2}, ball.mass = 1, ball.transform.translate = at;
  ball.constraints = {stiff("distance", {"edges"}), stiff("bending")};
  Scene scene = scene_of({ball}, {0, 0, 0}, 1.0 / 60, 10);
  EnvironmentSpec rock;
  rock.name = "rock", rock.shape = solid, rock.push_out = push_out, rock.thickness = 0.01;
  rock.motion = {{0, {0.3, 0, 0}, {0, 1, 0}, 30}};
  scene.environment = {rock};
  return scene;
}

std::string refusal_of_start(const Scene& scene) {
  try {
    Model model = build_model(scene);
    start_outside(model);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(StartInside, IsRefusedWithTheBodyTheDepthAndTheSolid) {
  const std::string said = refusal_of_start(ball_in_a_solid({1, 0, 0}, SphereShape{5, 3}, false));
  EXPECT_TRUE(has(said, "/environment/0: found particle")) << said;
  EXPECT_TRUE(has(said, "of body 'ball', which starts 4.")) << said;
  EXPECT_TRUE(has(said, "inside 'rock' (162 particles of that body inside it)")) << said;
  EXPECT_TRUE(has(said, "\"start_inside\": \"push_out\"")) << said;
}

TEST(StartInside, IsReportedWithinTheThicknessAndAllowedForPinnedParticles) {
  // The ball's lowest particle lies at 0.5 below its middle: by 0 and by 9 mm inside a box of 2 m, thickness 10 mm.
  for (const double depth : {0.0, 0.009}) {
    const Scene scene = ball_in_a_solid({0, 1.5 - depth, 0}, BoxShape{{2, 2, 2}, {{2, 2, 2}}}, false);
    EXPECT_EQ(refusal_of_start(scene), "") << depth;
    Simulation simulation(scene, {.threads = 1});
    EXPECT_EQ(simulation.model().notes.size(), depth > 0 ? 1u : 0u);
    run_for(simulation, scene, 0.5);
    EXPECT_LT(simulation.measure().speed_max, 1e-12) << "it stays as it is, but for rounding";
    EXPECT_NEAR(simulation.measure().penetration_max, depth, 1e-12);
  }
  EXPECT_NE(refusal_of_start(ball_in_a_solid({0, 1.48, 0}, BoxShape{{2, 2, 2}, {{2, 2, 2}}}, false)), "");
  Scene held = ball_in_a_solid({0, 1.3, 0}, BoxShape{{2, 2, 2}, {{2, 2, 2}}}, false);
  held.bodies[0].pins = {BoxPin{{-1, 0, -1}, {1, 1.01, 1}}};
  EXPECT_EQ(refusal_of_start(held), "") << "its particles in the box are pinned there";
}

TEST(StartInside, PushedOutABodyStaysAsItIsAndAtRest) {
  const Shape shapes[] = {SphereShape{5, 3}, BoxShape{{4, 3, 2}, {{4, 3, 2}}}, BarShape{6, 1.5, 3}};
  for (const Shape& solid : shapes) {
    const Scene scene = ball_in_a_solid({0.6, 0.2, 0.1}, solid, true);
    Simulation simulation(scene, {.threads = 1});
    ASSERT_EQ(simulation.model().notes.size(), 1u);
    EXPECT_TRUE(has(simulation.model().notes[0], "body 'ball' started inside 'rock' and was moved out of it as it is"));
    Scene alone = scene;
    alone.environment.clear();
    const std::vector<Vec3> out = simulation.positions(), in = Simulation(alone, {.threads = 1}).positions();
    const Vec3 moved = out[0] - in[0];
    EXPECT_GT(length(moved), 0.5);
    for (std::size_t i = 0; i < in.size(); ++i) EXPECT_LT(length(out[i] - in[i] - moved), 1e-12);
    run_for(simulation, scene, 0.5);
    // No force acts: a particle within the thickness is moved to its rim, which is a matter of a millimetre.
    EXPECT_LT(simulation.measure().speed_max, 0.1);
    EXPECT_LE(simulation.measure().penetration_max, 0);
  }
}

// Contact would move each of its particles to the round surface by itself, and so stretch the ball.
TEST(StartInside, PushedOutIsABodyThatIsInsideByLessThanTheThicknessToo) {
  Scene scene = ball_in_a_solid({0, 0, 0}, SphereShape{5, 5}, true);
  scene.environment[0].thickness = 0.5, scene.environment[0].motion.clear();
  BodySpec& sheet = scene.bodies[0];
  sheet.shape = GridShape{{1, 1}, {9, 9}}, sheet.transform.translate = {-0.5, 4.7, -0.5};
  Simulation simulation(scene, {.threads = 1});
  EXPECT_EQ(simulation.model().notes.size(), 2u) << "it was moved, and the thickness is more than its edges";
  run_for(simulation, scene, 0.2);
  // The ball's facets lie up to 4 mm below a sphere, and contact still moves it out by as much. Moved by the thickness
  // in a substep, it would gain 10 m/s.
  EXPECT_LT(simulation.measure().speed_max, 0.1);
}

TEST(StartInside, PinnedParticlesAreNotPushedOut) {
  Scene scene = ball_in_a_solid({0.6, 0.2, 0.1}, SphereShape{5, 3}, true);
  scene.bodies[0].pins = {ListPin{{0}}};
  EXPECT_TRUE(has(refusal_of_start(scene), "has pins or attachments, so that it cannot be moved"));
}

TEST(StartInside, IsPartOfTheSceneAndOfSolidsAlone) {
  const std::string before = R"({"name": "a", "solver": {"type": "pbd"}, "bodies": [{"name": "p", "mass": 1, "shape":
    {"lattice": {"min": [0, 9, 0], "max": [0, 9, 0], "count": [1, 1, 1]}}}], "duration": 1, "environment": [{"name": "e",
    "shape": {"sphere": {"radius": 1, "subdivisions": 1}}, "start_inside": "push_out")";
  const Scene scene = parse_scene(before + "}]}", "a.json", "");
  EXPECT_TRUE(scene.environment[0].push_out);
  EXPECT_TRUE(parse_scene(to_json(scene), "a.json", "").environment[0].push_out);
  try {
    parse_scene(before + R"(, "sides": "two_sided"}]})", "a.json", "");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_TRUE(has(error.what(), "/environment/0/start_inside")) << error.what();
  }
}

}  // namespace
}  // namespace malha
