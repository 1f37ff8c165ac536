// SPDX-License-Identifier: Apache-2.0
// No tunnelling: nothing passes through a wall, at any speed, however thin the wall, and whether the wall or the body
// moves.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kWallThickness = 0.002;

/// A wall across x at the origin, 40 m wide and high, so that nothing passes beside it; its front is at x = -depth.
struct Wall {
  const char* name;
  Sides sides;
  double depth;
};
constexpr Wall kSolid{"Solid", Sides::Solid, 0.005}, kTwoSided{"TwoSided", Sides::TwoSided, 0},
    kOneSided{"OneSided", Sides::OneSided, 0};

EnvironmentSpec environment(const Wall& wall) {
  EnvironmentSpec made;
  made.name = "wall";
  made.thickness = kWallThickness;
  made.sides = wall.sides;
  if (wall.sides == Sides::Solid) {
    made.shape = BoxShape{{2 * wall.depth, 40, 40}, {{1, 80, 80}}};
  } else {
    made.shape = GridShape{{40, 40}, {80, 80}};
    made.transform.translate = {0, -20, -20};
    made.transform.axis = {0, 0, 1};
    made.transform.degrees = 90;
  }
  return made;
}

/// The largest x of any particle over the run.
double furthest(const Scene& scene, double seconds) {
  Simulation simulation(scene, {.threads = 1});
  double most = -INFINITY;
  while (simulation.time() < seconds) {
    simulation.step();
    for (const Vec3& x : simulation.positions()) most = std::max(most, x[0]);
  }
  return most;
}

class FastParticles : public testing::TestWithParam<std::tuple<Wall, Precision>> {
 protected:
  Wall wall_ = std::get<0>(GetParam());
  Precision precision_ = std::get<1>(GetParam());
  double front_ = -wall_.depth - kWallThickness;
  double rounding_ = precision_ == Precision::Float ? 2e-6 : 1e-12;  // of positions of up to 17 m

  /// 11 x 11 particles 1 m in front of the wall.
  BodySpec bullets(double spacing, double off, const Vec3& velocity) const {
    BodySpec body;
    body.name = "bullets";
    const double half = 5 * spacing;
    body.shape = LatticeShape{{-1, off - half, off - half}, {-1, off + half, off + half}, {1, 11, 11}};
    body.mass = 1;
    body.velocity = velocity;
    return body;
  }
};

TEST_P(FastParticles, DoNotPassFrom1To1000MetresPerSecond) {
  // Targets are the wall's corners and edges, where long rays leak, and anywhere else; directions are straight and
  // slanted.
  for (const double speed : {1, 10, 100, 1000})
    for (const auto& [spacing, off, slant] : {std::array{0.5, 0.0, 0.0}, {0.25, 0.0, 0.0}, {0.123, 0.017, 0.3}}) {
      Scene scene =
          scene_of({bullets(spacing, off, {speed, slant * speed, 0.7 * slant * speed})}, {}, 1.0 / 60, 1, precision_);
      scene.environment = {environment(wall_)};
      EXPECT_LE(furthest(scene, std::max(0.05, 1.5 / speed)), front_ + rounding_)
          << speed << " m/s, spacing " << spacing;
    }
}

TEST_P(FastParticles, AreSweptAlongByAWallThatMoves) {
  for (const double speed : {1, 10, 100, 1000}) {
    Scene scene = scene_of({bullets(0.25, 0, {})}, {}, 1.0 / 60, 1, precision_);
    scene.environment = {environment(wall_)};
    Keyframe last;
    last.time = 100 / speed, last.translate = {-100, 0, 0};
    scene.environment[0].motion = {Keyframe{}, last};
    Simulation simulation(scene, {.threads = 1});
    while (simulation.time() < 2 / speed) simulation.step();
    const double front = front_ - simulation.time() * speed;
    for (const Vec3& x : simulation.positions()) ASSERT_LE(x[0], front + rounding_) << speed << " m/s";
  }
}

INSTANTIATE_TEST_SUITE_P(, FastParticles,
                         testing::Combine(testing::Values(kSolid, kTwoSided, kOneSided),
                                          testing::Values(Precision::Float, Precision::Double)),
                         [](const auto& tested) {
                           return std::string(std::get<0>(tested.param).name) +
                                  (std::get<1>(tested.param) == Precision::Float ? "Float" : "Double");
                         });

class FastSheet : public testing::TestWithParam<Wall> {};

// Nearly edge-on the sheet crumples, and drags its particles off the paths that they would take alone.
TEST_P(FastSheet, DoesNotPassAThinWall) {
  for (const double speed : {10, 100, 500})
    for (const int substeps : {1, 3, 10})
      for (const double degrees : {90, 70, 20}) {
        BodySpec sheet;
        sheet.name = "sheet";
        sheet.shape = GridShape{{1, 1}, {32, 32}};
        sheet.transform.translate = {-1, -0.5, -0.5};
        sheet.transform.axis = {0, 0, 1};
        sheet.transform.degrees = degrees;
        sheet.mass = 0.2;
        sheet.velocity = {speed, 0, 0};
        sheet.constraints = {stiff("distance", {"edges", "shear"}), stiff("bending", {}, 0.05)};
        Scene scene = scene_of({sheet}, {}, 1.0 / 60, substeps, Precision::Float);
        scene.environment = {environment(GetParam())};
        EXPECT_LE(furthest(scene, 0.25), -GetParam().depth)
            << speed << " m/s, " << substeps << " substeps, " << degrees << " degrees";
      }
}

INSTANTIATE_TEST_SUITE_P(, FastSheet, testing::Values(kSolid, kTwoSided, kOneSided),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace malha
