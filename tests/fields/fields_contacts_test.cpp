// SPDX-License-Identifier: Apache-2.0
// Fields of contacts with the environment.
#include <gtest/gtest.h>

#include "host/fields/contacts.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kThick = 0.01;  // m

/// A cube of 1 m about the origin, or its top as a sheet.
EnvironmentSpec table(Sides sides) {
  EnvironmentSpec spec;
  spec.name = "table", spec.sides = sides, spec.thickness = kThick;
  if (sides == Sides::Solid)
    spec.shape = BoxShape{{1, 1, 1}, {{2, 2, 2}}};
  else
    spec.shape = GridShape{{1, 1}, {2, 2}}, spec.transform.translate = {-0.5, 0.5, -0.5};
  return spec;
}

/// A scene with that many loose particles and these objects.
Simulation world(int particles, std::vector<EnvironmentSpec> environment) {
  BodySpec cloud;
  cloud.name = "lattice", cloud.mass = 1, cloud.shape = LatticeShape{{0, 5, 0}, {1, 5, 0}, {particles, 1, 1}};
  Scene scene = scene_of({cloud}, {}, 0.01);
  scene.environment = std::move(environment);
  return Simulation(scene, {.threads = 1});
}

void expect_point(const Vec3& found, const Vec3& expected) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], expected[k], 1e-12) << k << ": rounding";
}

TEST(FieldsOfContacts, FindWhatIsWithinTheThickness) {
  const Simulation simulation = world(6, {table(Sides::Solid)});
  const double d = kThick, s = std::sqrt(0.5);
  const std::vector<Vec3> x{{0.1, 0.5 + d, 0.2},                 // on top
                            {0.1, 0.5 + 1.2 * d, 0.2},           // above
                            {0.5 + 0.5 * d, 0.1, 0.2},           // at a side
                            {0.5 + 0.7 * d, 0.5 + 0.7 * d, 0},   // beside an edge
                            {0.1, 0.5 - 0.5 * d, 0.2},           // inside
                            {0.5 + 0.8 * d, 0.5 + 0.8 * d, 0}};  // 1.13 thicknesses from the edge
  const std::vector<ContactPoint> all = Contacts(simulation.model())(x, simulation.model().environment, 0);
  ASSERT_EQ(all.size(), 4u);
  const int particles[] = {0, 2, 3, 4};
  const double distances[] = {d, 0.5 * d, 0.7 * d / s, -0.5 * d};
  const Vec3 places[] = {{0.1, 0.5, 0.2}, {0.5, 0.1, 0.2}, {0.5, 0.5, 0}, {0.1, 0.5, 0.2}};
  const Vec3 normals[] = {{0, 1, 0}, {1, 0, 0}, {s, s, 0}, {0, 1, 0}};
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(all[k].particle, particles[k]);
    EXPECT_EQ(all[k].object, 0);
    EXPECT_NEAR(all[k].distance, distances[k], 1e-12);
    expect_point(all[k].at, places[k]), expect_point(all[k].normal, normals[k]);
  }
}

TEST(FieldsOfContacts, OfSheetsHaveTheSideThatCounts) {
  const std::vector<Vec3> x{{0.1, 0.5 - 0.5 * kThick, 0.1},
                            {0.1, 0.5 + 0.5 * kThick, 0.1},
                            {0.1, 0.5, 0.1},
                            {0.5 + 0.5 * kThick, 0.5 - 0.5 * kThick, 0}};  // beyond the rim, below it
  for (const Sides sides : {Sides::OneSided, Sides::TwoSided}) {
    const Simulation simulation = world(4, {table(sides)});
    const bool one = sides == Sides::OneSided;
    const std::vector<ContactPoint> all = Contacts(simulation.model())(x, simulation.model().environment, 0);
    ASSERT_EQ(all.size(), one ? 3u : 4u);
    expect_point(all[0].normal, {0, one ? 1.0 : -1.0, 0});
    EXPECT_NEAR(all[0].distance, (one ? -0.5 : 0.5) * kThick, 1e-12);
    expect_point(all[1].normal, {0, 1, 0});
    EXPECT_NEAR(std::abs(all[2].normal[1]), 1, 1e-12);
  }
}

TEST(FieldsOfContacts, MoveWithTheirObjects) {
  EnvironmentSpec turning = table(Sides::Solid);
  turning.motion = {{0, {}, {0, 0, 1}, 0}, {1, {3, 0, 0}, {0, 0, 1}, 45}};
  EnvironmentSpec still = table(Sides::Solid);
  still.name = "still";
  const Simulation simulation = world(1, {turning, still});
  const Contacts contacts(simulation.model());
  const double corner = std::sqrt(0.5);  // the top edge, turned
  EXPECT_EQ(contacts({{3, corner + 0.5 * kThick, 0}}, simulation.model().environment, 0).size(), 0u);
  const std::vector<ContactPoint> all = contacts({{3, corner + 0.5 * kThick, 0}}, simulation.model().environment, 1);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].object, 0);
  expect_point(all[0].at, {3, corner, 0}), expect_point(all[0].normal, {0, 1, 0});
  EXPECT_EQ(contacts({{0, 0.5 + 0.5 * kThick, 0}}, simulation.model().environment, 1)[0].object, 1);
}

TEST(FieldsOfContacts, AreNoneWithoutAnEnvironment) {
  const Simulation simulation = world(2, {});
  EXPECT_TRUE(Contacts(simulation.model())(simulation.positions(), simulation.model().environment, 0).empty());
}

// A strip lies across a table that is shorter: the particles on it touch, those that hang over do not. (A sheet that
// hangs over all four sides has folds, which lift it.)
TEST(FieldsOfContacts, OfAStripAtRestAreThoseOnTheTable) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.5, sheet.damping = 0.05;
  sheet.shape = GridShape{{1.6, 0.8}, {32, 16}};
  sheet.transform.translate = {-0.8, 0.5 + kThick, -0.4};
  sheet.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({sheet}, kEarth, 0.02, 10, Precision::Float);
  // The table is its top alone: beside a cube's side the hanging particles would touch.
  scene.environment = {table(Sides::OneSided)};
  scene.environment[0].friction = 1;
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 4);
  const std::vector<Vec3> x = simulation.positions();
  const std::vector<ContactPoint> all =
      Contacts(simulation.model())(x, simulation.model().environment, simulation.time());
  EXPECT_EQ(Contacts(simulation.model(), 3)(x, simulation.model().environment, simulation.time()).size(), all.size());
  std::vector<bool> touches(x.size(), false);
  for (const ContactPoint& touch : all) {
    touches[touch.particle] = true;
    EXPECT_LE(std::abs(touch.distance), 1.1 * kThick);
    const Vec3& n = touch.normal;
    EXPECT_NEAR(length(n), 1, 1e-12);
    const Vec3 away = x[touch.particle] - touch.at;
    EXPECT_NEAR(n[0] * away[0] + n[1] * away[1] + n[2] * away[2], touch.distance, 1e-12);
    EXPECT_GT(touch.distance, 0.9 * kThick) << "nothing is pressed in";
  }
  int on = 0, over = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double out = std::abs(x[i][0]) - 0.5;  // distance beyond the table's side
    if (out < -0.1) {
      EXPECT_TRUE(touches[i]) << i << " lies on it at " << x[i][1] - 0.5 << " m";
      ++on;
    }
    if (x[i][1] < 0.45) {
      EXPECT_FALSE(touches[i]) << i << " hangs over";
      ++over;
    }
  }
  EXPECT_GT(on, 200);
  EXPECT_GT(over, 100);
}

TEST(FieldsOfContacts, FollowASurfaceThatDeforms) {
  EnvironmentSpec skin = table(Sides::OneSided);
  skin.animation = AnimationSpec{};
  skin.animation->from_code = true;
  Simulation simulation = world(2, {skin});
  const Contacts contacts(simulation.model());
  std::vector<Vec3> points = simulation.model().environment[0].mesh.points;
  for (Vec3& x : points) x[1] += x[0];  // a slope
  simulation.set_vertices("table", points);
  simulation.step();
  const double s = std::sqrt(0.5);
  const std::vector<Vec3> x{{0.2, 0.5 + 0.5 * kThick, 0.1}, {0.2 - kThick * s, 0.7 + kThick * s, 0.1}};
  const auto at = [&](double time) { return contacts(x, simulation.model().environment, time); };
  ASSERT_EQ(at(0).size(), 1u);
  EXPECT_EQ(at(0)[0].particle, 0);
  const std::vector<ContactPoint> later = at(simulation.time());
  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].particle, 1);
  expect_point(later[0].at, {0.2, 0.7, 0.1});
  expect_point(later[0].normal, {-s, s, 0});
}

}  // namespace
}  // namespace malha
