// SPDX-License-Identifier: Apache-2.0
// Levels on bodies that are not hung by a row of pins: the distance from the solution of many substeps.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr int kSide = 65;    // particles
constexpr int kAlike = 30;   // plain substeps that cost at least as much as 10 with levels (measured: 27)
constexpr int kTruth = 300;  // plain substeps

/// A sheet of 2 x 2 m and 1 kg in the plane y = 0.
BodySpec wide_sheet() {
  BodySpec body;
  body.name = "sheet";
  body.shape = GridShape{{2, 2}, {kSide - 1, kSide - 1}};
  body.mass = 1;
  body.constraints = {stiff("distance", {"edges", "shear"})};
  return body;
}

struct LevelsOutcome {
  std::vector<Vec3> positions;
  Measures measures;
};
LevelsOutcome after(Scene scene, double seconds, int substeps, int levels) {
  scene.solver.precision = Precision::Float;
  scene.solver.substeps = substeps, scene.solver.levels = levels;
  Simulation simulation(scene, {.threads = 1});
  EXPECT_EQ(simulation.solver().facts().levels.empty(), levels == 0);
  run_for(simulation, scene, seconds);
  return {simulation.positions(), simulation.measure()};
}
double rms_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(length(a[i] - b[i]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(LevelsInOtherScenes, ASheetHungByTwoCornersIsNearerToTheTruthThanBySweepsOfThatCost) {
  BodySpec body = wide_sheet();
  body.pins = {ListPin{{0, kSide - 1}}};
  const Scene scene = scene_of({body}, kEarth, 1.0 / 60);
  const LevelsOutcome truth = after(scene, 1, kTruth, 0), plain = after(scene, 1, kAlike, 0),
                      levels = after(scene, 1, 10, kAutoLevels);
  EXPECT_LT(rms_distance(levels.positions, truth.positions), rms_distance(plain.positions, truth.positions));
  EXPECT_LT(levels.measures.strain_rms, plain.measures.strain_rms);
}

/// A cloth whose last row of cells is `ratio` times as tall, and so as heavy, as the others.
std::string with_a_heavy_hem(double ratio) {
  const double l = 2.0 / (kSide - 1);
  std::ostringstream obj;
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i < kSide; ++i) obj << "v " << i * l << " " << (j < kSide ? -j * l : -2 - ratio * l) << " 0\n";
  for (int j = 0; j < kSide; ++j)
    for (int i = 1; i < kSide; ++i) {
      const int a = j * kSide + i, b = a + kSide;
      obj << "f " << a << " " << a + 1 << " " << b + 1 << "\nf " << a << " " << b + 1 << " " << b << "\n";
    }
  return obj.str();
}

/// It hangs at rest, so that the true stretch is none. Plain sweeps of more cost: 0.03, 2.4 and 3 (40 substeps: 1.1).
TEST(LevelsInOtherScenes, HoldWeightsOfManyTimesTheMassOfAParticle) {
  const TemporaryFolder folder;
  const auto stretch = [&](double ratio, int substeps, int levels) {
    BodySpec body = wide_sheet();
    body.shape = MeshFile{folder.write("hem.obj", with_a_heavy_hem(ratio))};
    body.constraints = {stiff("distance", {"edges"})};
    body.pins = {BoxPin{{-1, -1e-9, -1}, {3, 1, 1}}};
    const LevelsOutcome end = after(scene_of({body}, kEarth, 1.0 / 60), 1, substeps, levels);
    double sum = 0;  // of the columns' edges above the hem
    for (int i = 0; i < kSide * (kSide - 1); ++i)
      sum += std::pow(length(end.positions[i + kSide] - end.positions[i]) * (kSide - 1) / 2 - 1, 2);
    return std::sqrt(sum / (kSide * (kSide - 1)));
  };
  for (const double ratio : {100.0, 1000.0, 10000.0}) {
    const double levels = stretch(ratio, 10, kAutoLevels);
    EXPECT_LT(levels, ratio > 1000 ? 0.15 : 0.005) << ratio;
    EXPECT_GT(stretch(ratio, kAlike, 0), 5 * levels) << ratio;
  }
}

/// The comparison ends before it flutters: after a second 200 and 400 substeps are 0.1 m apart.
TEST(LevelsInOtherScenes, AFlagInTheWindIsWhereSweepsOfThatCostHaveIt) {
  BodySpec body = wide_sheet();
  body.pins = {RowPin{}};
  Scene scene = scene_of({body}, kEarth, 1.0 / 60);
  scene.wind = Wind{};
  scene.wind->velocity = {0, 0, 6}, scene.wind->density = 1.2;
  const LevelsOutcome truth = after(scene, 0.25, kTruth, 0), plain = after(scene, 0.25, 12, 0),
                      levels = after(scene, 0.25, 10, kAutoLevels);
  EXPECT_LT(rms_distance(levels.positions, truth.positions), 1.1 * rms_distance(plain.positions, truth.positions));
  EXPECT_LT(levels.measures.strain_rms, plain.measures.strain_rms);
}

TEST(LevelsInOtherScenes, WhatFliesFreelyHasNoneByItselfAndKeepsItsLengthsWithThem) {
  BodySpec body = wide_sheet();
  body.velocity = {1, 0, 0}, body.spin = {2, 5, 3};
  Scene scene = scene_of({body}, {}, 1.0 / 60, 10);
  EXPECT_TRUE(Simulation(scene, {.threads = 1}).solver().facts().levels.empty());
  const LevelsOutcome truth = after(scene, 0.5, kTruth, 0), plain = after(scene, 0.5, 10, 0),
                      levels = after(scene, 0.5, 10, kMaxLevels);
  EXPECT_LT(rms_distance(levels.positions, truth.positions), 0.5 * rms_distance(plain.positions, truth.positions));
  EXPECT_LT(levels.measures.strain_rms, 0.1 * plain.measures.strain_rms);
}

}  // namespace
}  // namespace malha
