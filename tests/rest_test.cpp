// A scene at rest stays at rest, without sleep too: how much resting contacts move from step to step.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/scene_builders.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

#ifdef NDEBUG
constexpr int kSteps = 10'000;
#else
constexpr int kSteps = 300;
#endif

BodySpec sheet() {
  BodySpec body = malha::body("sheet", GridShape{{1, 1}, {4, 4}}, {stiff("distance", {"edges", "shear"})});
  body.transform.translate = {-0.5, 0.02, -0.5};
  return body;
}

BodySpec crate() {
  BodySpec body = malha::body("crate", BoxShape{{0.4, 0.4, 0.4}, {2, 2, 2}},
                              {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.5)});
  body.transform.translate = {0, 0.22, 0};
  return body;
}

Scene resting(const BodySpec& body, const std::string& solver, Precision precision, bool solid) {
  EnvironmentSpec ground = solid ? obstacle("ground", BoxShape{{6, 1, 6}, {3, 1, 3}})
                                 : obstacle("ground", GridShape{{6, 6}, {3, 3}}, Sides::OneSided);
  ground.transform.translate = solid ? Vec3{0.03, -0.5, 0.02} : Vec3{-3.03, 0, -3.02};
  ground.friction = 0.5;
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10, precision);
  scene.environment = {ground};
  scene.solver.type = solver;
  if (solver == "desbrun") scene.solver.substeps = 2;
  return scene;
}

/// The longest way (m) of a particle in a step, of those that touch the ground and of all, after `settle` seconds.
struct Jitter {
  double touching = 0, all = 0;
  std::size_t contacts = 0;
};
Jitter jitter(const Scene& scene, double settle, int steps) {
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

class RestingContacts : public testing::TestWithParam<const char*> {};

TEST_P(RestingContacts, OfASheetMoveByLessThanATenThousandthOfTheThickness) {
  for (const Precision precision : {Precision::Float, Precision::Double})
    for (const bool solid : {false, true}) {
      const Jitter found = jitter(resting(sheet(), GetParam(), precision, solid), 5, kSteps / (solid ? 10 : 1));
      EXPECT_EQ(found.contacts, 25u);
      EXPECT_LT(found.touching, 1e-4 * 0.005) << solid;  // 1e-13 when it was measured
    }
}

/// What does not touch the ground moves by some tens of the spacings of float at 0.4 m, and in double hardly at all.
TEST(RestingContactsOfACrate, MoveByLessThanATenThousandthOfTheThickness) {
  const Jitter coarse = jitter(resting(crate(), "pbd", Precision::Float, false), 5, kSteps);
  EXPECT_EQ(coarse.contacts, 9u);
  EXPECT_LT(coarse.touching, 1e-4 * 0.005);  // 0 when it was measured
  EXPECT_LT(coarse.all, 100 * 0x1p-25);
  const Jitter fine = jitter(resting(crate(), "pbd", Precision::Double, false), 10, 100);
  EXPECT_LT(fine.all, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Under, RestingContacts, testing::Values("pbd", "desbrun"));

}  // namespace
}  // namespace malha
