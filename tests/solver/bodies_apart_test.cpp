// SPDX-License-Identifier: Apache-2.0
// A body's order of projection is its own: bodies that it does not touch change none of its bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

BodySpec body_at(const Vec3& at, const std::string& name, const Shape& shape, std::vector<ConstraintSpec> constraints) {
  BodySpec body;
  body.name = name;
  body.shape = shape;
  body.transform.translate = at;
  body.mass = 0.4;
  body.constraints = std::move(constraints);
  return body;
}

/// An irregular sheet of triangles and quads, some wound the other way, with vertices that no face uses.
std::string irregular_sheet() {
  Random random(11);
  constexpr int across = 31, along = 24;
  std::string text = "v 0 0 0\n";
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < across; ++i)
      text += "v " + std::to_string(0.05 * i + random(-0.01, 0.01)) + " 0 " +
              std::to_string(0.05 * j + random(-0.01, 0.01)) + "\n";
  text += "v 1 1 1\n";
  const auto face = [&](std::vector<int> corners) {
    if (random.below(3) == 0) std::reverse(corners.begin(), corners.end());
    text += "f";
    for (const int c : corners) text += " " + std::to_string(c);
    text += "\n";
  };
  for (int j = 0; j + 1 < along; ++j)
    for (int i = 0; i + 1 < across; ++i) {
      const int a = 2 + j * across + i, b = a + 1, c = b + across, d = a + across;
      if (random.below(2) == 0)
        face({a, b, c, d});
      else
        face({a, b, c}), face({a, c, d});
    }
  return text;
}

/// Bodies 40 m apart that fall or hang, of all sizes: several patches, one, and a part of one; with runs and without.
/// Those of the same constraints share sets, in different orders.
std::vector<BodySpec> bodies_apart(const TemporaryFolder& folder) {
  const ConstraintSpec hard = stiff("distance", {"edges"}), soft = compliant("distance", 1e-6, {"edges", "shear"});
  std::vector<BodySpec> all;
  const auto at = [&] { return Vec3{40.0 * static_cast<double>(all.size()), 1.5, 0}; };
  all.push_back(body_at(at(), "sheet", GridShape{{1.5, 1.5}, {70, 40}}, {hard, soft, stiff("bending", {}, 0.1)}));
  all.back().pins = {RowPin{}};
  all.push_back(body_at(at(), "soft sheet", GridShape{{1, 1}, {23, 17}}, {soft, hard}));
  all.push_back(body_at(at(), "irregular", MeshFile{folder.write("irregular.obj", irregular_sheet())},
                        {soft, compliant("bending", 0.01)}));
  all.push_back(body_at(at(), "balloon", SphereShape{0.3, 3}, {hard, compliant("pressure", 3e-6, {}, 1.2)}));
  all.back().spin = {1, 5, 2}, all.back().damping = 0.2;
  for (int k = 0; k < 12; ++k)
    all.push_back(body_at(at(), "small " + std::to_string(k), GridShape{{1, 1}, {1 + k, 9 - k % 5}}, {hard}));
  all.push_back(body_at(at(), "chain", ChainShape{{0, 0, 0}, {1, 0, 0}, 30}, {hard}));
  all.back().pins = {ListPin{{0}}};
  all.push_back(particle(at(), {0, 1, 0}));
  return all;
}

/// The positions and velocities of a body after some steps.
std::vector<Vec3> motion_of(Simulation& simulation, std::size_t body) {
  const std::vector<int>& begin = simulation.model().render_mesh.body_begin;
  std::vector<Vec3> all;
  for (const std::vector<Vec3>& of : {simulation.positions(), simulation.velocities()})
    all.insert(all.end(), of.begin() + begin[body], of.begin() + begin[body + 1]);
  return all;
}

/// Expects each body to move as it does alone, whether it is the first or the last.
void expect_as_alone(Scene scene, const std::vector<BodySpec>& bodies) {
  constexpr int steps = 12;
  for (const bool reversed : {false, true}) {
    scene.bodies = bodies;
    if (reversed) std::reverse(scene.bodies.begin(), scene.bodies.end());
    Simulation together(scene, {.threads = 2});
    for (int step = 0; step < steps; ++step) together.step();
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      Scene alone = scene;
      alone.bodies = {scene.bodies[b]};
      Simulation one(alone, {.threads = 1});
      for (int step = 0; step < steps; ++step) one.step();
      EXPECT_EQ(motion_of(together, b), motion_of(one, 0)) << scene.bodies[b].name << (reversed ? ", reversed" : "");
    }
  }
}

class BodiesApart : public testing::TestWithParam<Precision> {
 protected:
  Scene scene(int iterations = 1) const {
    Scene scene = scene_of({}, kEarth, 1.0 / 60, 4, GetParam());
    scene.solver.iterations = iterations;
    return scene;
  }
  TemporaryFolder folder_;
};

TEST_P(BodiesApart, MoveAsTheyDoAlone) { expect_as_alone(scene(), bodies_apart(folder_)); }

TEST_P(BodiesApart, MoveAsTheyDoAloneWithLevels) {
  Scene levels = scene(2);
  levels.solver.levels = 3;
  expect_as_alone(levels, bodies_apart(folder_));
}

TEST_P(BodiesApart, MoveAsTheyDoAloneOnAGround) {
  Scene ground = scene();
  EnvironmentSpec plane;
  plane.name = "ground";
  plane.shape = GridShape{{2000, 100}, {40, 2}};
  plane.transform.translate = {-200, 1.3, -50};
  plane.sides = Sides::TwoSided;
  plane.friction = 0.3;
  ground.environment = {plane};
  expect_as_alone(ground, bodies_apart(folder_));
}

TEST_P(BodiesApart, MoveAsTheyDoAloneByDesbrun) {
  Scene filtered = scene();
  filtered.solver.type = "desbrun";
  filtered.solver.desbrun.filter = FilterKind::Dense;  // the tasks of a sparse one are shares of all bodies
  std::vector<BodySpec> bodies = bodies_apart(folder_);
  for (BodySpec& body : bodies) std::erase_if(body.constraints, [](const auto& c) { return c.type != "distance"; });
  expect_as_alone(filtered, bodies);
}

INSTANTIATE_TEST_SUITE_P(Precisions, BodiesApart, testing::Values(Precision::Float, Precision::Double),
                         [](const auto& tested) { return tested.param == Precision::Float ? "float" : "double"; });

}  // namespace
}  // namespace malha
