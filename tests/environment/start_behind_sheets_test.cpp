// SPDX-License-Identifier: Apache-2.0
// Bodies that start behind a one-sided sheet: a warning names them where they will be moved in front of it; elsewhere
// they may be there.
#include <gtest/gtest.h>

#include "host/environment/initial_overlap.h"
#include "malha/simulation.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

using Notes = std::vector<std::string>;

/// A sheet of 2 m whose front is above, at y = 1 due to its motion.
EnvironmentSpec seen_from_above() {
  EnvironmentSpec sheet;
  sheet.name = "ground", sheet.shape = GridShape{{2, 2}, {3, 2}}, sheet.sides = Sides::OneSided;
  sheet.transform.translate = {-1, 0, -1}, sheet.thickness = 0.01;
  sheet.motion = {{0, {0, 1, 0}, {0, 1, 0}, 30}};
  return sheet;
}

/// A hanging rope of four segments of 0.5 m, its top at `top`.
BodySpec rope_from(const Vec3& top) {
  BodySpec rope;
  rope.name = "rope", rope.shape = ChainShape{top, {top[0], top[1] - 2, top[2]}, 4}, rope.mass = 1;
  rope.constraints = {stiff("distance", {"edges"})};
  return rope;
}

Notes notes_of_start(const BodySpec& body, const EnvironmentSpec& sheet) {
  Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60, 10);
  scene.environment = {sheet};
  return Simulation(scene, {.threads = 1}).model().notes;
}

TEST(StartBehindASheet, IsReportedOfABodyThatGoesThroughIt) {
  // Particles at 2.2, 1.7, 1.2, 0.7 and 0.2 m: the edge from 2 to 3 goes through the sheet at 1 m.
  EXPECT_EQ(notes_of_start(rope_from({0.1, 2.2, 0.2}), seen_from_above()),
            Notes{"body 'rope': 1 particle starts behind the one-sided sheet 'ground' (3 by 0.3 m), and will be put "
                  "before it or be kept from the rest; its normals say which side is the front"});
  EnvironmentSpec from_below = seen_from_above();
  from_below.transform.axis = {1, 0, 0}, from_below.transform.degrees = 180,
  from_below.transform.translate = {-1, 0, 1};
  const Notes other = notes_of_start(rope_from({0.1, 2.2, 0.2}), from_below);
  ASSERT_EQ(other.size(), 1u);
  EXPECT_TRUE(has(other[0], "(2 by 0.2 m)")) << other[0];
}

TEST(StartBehindASheet, IsAllowedAwayFromItOrBesideItsBoundary) {
  const EnvironmentSpec sheet = seen_from_above();
  EXPECT_EQ(notes_of_start(rope_from({0, 3.5, 0}), sheet), Notes{}) << "before it";
  EXPECT_EQ(notes_of_start(rope_from({0, 0.8, 0}), sheet), Notes{}) << "behind it";
  EXPECT_EQ(notes_of_start(rope_from({2.5, 2.2, 0}), sheet), Notes{}) << "through its plane, beside it";
  EXPECT_EQ(notes_of_start(rope_from({0, 3, 0}), sheet), Notes{}) << "on it, but for rounding";
  for (const double behind : {0.005, 0.015})  // within a thickness of 10 mm, where the particle stays, and beyond it
    EXPECT_EQ(notes_of_start(rope_from({0, 3 - behind, 0}), sheet).size(), 1u) << behind;
  BodySpec held = rope_from({0, 2.2, 0});
  held.pins = {ListPin{{2, 3}}};
  EXPECT_EQ(notes_of_start(held, sheet), Notes{}) << "what is pinned through it stays there";
  EnvironmentSpec two_sided = sheet;
  two_sided.sides = Sides::TwoSided;
  EXPECT_EQ(notes_of_start(rope_from({0, 2.2, 0}), two_sided), Notes{}) << "no side is the front";
}

TEST(StartBehindASheet, IsReportedOfWhatTheFirstStepMovesInFrontOfIt) {
  // A roof with its ridge at 1 m and slopes of 45 degrees, whose front is above.
  const TemporaryFolder folder;
  EnvironmentSpec roof;
  roof.name = "roof", roof.sides = Sides::OneSided, roof.thickness = 0.01;
  roof.shape = MeshFile{
      folder.write("roof.obj", "v -1 0 -1\nv -1 0 1\nv 0 1 -1\nv 0 1 1\nv 1 0 -1\nv 1 0 1\nf 1 2 4 3\nf 3 4 6 5\n"),
      {}};
  for (const double y : {1.5, 0.5, -0.5}) {
    const BodySpec dust = particle({0, y, 0});
    Scene scene = scene_of({dust}, {0, 0, 0}, 1.0 / 60, 10);
    scene.environment = {roof};
    Simulation simulation(scene, {.threads = 1});
    const bool said = !simulation.model().notes.empty();
    simulation.step();
    const Vec3 x = simulation.positions()[0];
    EXPECT_EQ(length(x - Vec3{0, y, 0}) > 0.3, y == 0.5) << "only what is under the roof is moved";
    EXPECT_EQ(said, y == 0.5);
    if (said) {
      EXPECT_TRUE(has(simulation.model().notes[0], "(0 by 0.353553 m)")) << simulation.model().notes[0];
    }
  }
}

}  // namespace
}  // namespace malha
