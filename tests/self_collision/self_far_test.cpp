// SPDX-License-Identifier: Apache-2.0
// Self-collision far from the origin: float keeps bodies separated as double does, because positions are relative to an
// origin near the bodies, which follows them.
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/measure/solver_stats.h"
#include "host/solver/solver.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A soft irregular sheet of 0.4 m and 0.1 kg with (cells + 1)^2 particles, row by row.
BodySpec far_sheet(const TemporaryFolder& folder, const std::string& name, const Vec3& at, unsigned seed, int cells) {
  Random random(seed);
  BodySpec body;
  body.name = name, body.mass = 0.1, body.transform.translate = at;
  body.shape = MeshFile{folder.write(name + ".obj", irregular_sheet(0.4, 0.4, cells, cells, random))};
  body.constraints = {compliant("distance", 1e-3, {"edges"}), stiff("bending", {}, 0.1)};
  return body;
}

/// The bodies in still air, which damps them, with a thickness of 1 mm.
Scene calmed(std::vector<BodySpec> bodies, Precision precision) {
  Scene scene = scene_of(std::move(bodies), kEarth, 1.0 / 60, 20, precision);
  scene.self_collision = SelfCollision{0.001, 0.3, {}};
  scene.wind = Wind{};
  scene.wind->drag = 0.005;
  return scene;
}

Scene moved_by(Scene scene, const Vec3& way) {
  for (BodySpec& body : scene.bodies)
    for (int k = 0; k < 3; ++k) body.transform.translate[k] += way[k];
  return scene;
}

/// Two sheets that come to rest on a fixed one, within its boundary.
Scene far_stack(const TemporaryFolder& folder, Precision precision) {
  std::vector<BodySpec> sheets;
  for (unsigned k = 0; k < 3; ++k) {
    sheets.push_back(far_sheet(folder, "sheet" + std::to_string(k), {0.01 * k, 0.003 * k, 0.01 * k}, 40 + k, 8));
    sheets[k].transform.scale = {k == 0 ? 1.2 : 1, 1, k == 0 ? 1.2 : 1};
  }
  ListPin all;
  for (int i = 0; i < 80; ++i) all.particles.push_back(i);  // all but a corner
  sheets[0].pins = {all};
  return calmed(sheets, precision);
}

/// A sheet that is folded in the middle, with one half fixed.
Scene far_fold(const TemporaryFolder& folder, Precision precision) {
  Random random(50);
  std::istringstream flat(irregular_sheet(0.4, 0.4, 10, 10, random));
  std::ostringstream folded;
  for (std::string line; std::getline(flat, line);) {
    double x = 0, y = 0, z = 0;
    if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3 && x > 0.2001)
      folded << "v " << 0.4 - x << " 0.003 " << z << "\n";
    else
      folded << line << "\n";
  }
  BodySpec sheet = far_sheet(folder, "flat", {0, 0, 0}, 50, 10);
  sheet.shape = MeshFile{folder.write("folded.obj", folded.str())};
  ListPin half;
  for (int j = 0; j <= 10; ++j)
    for (int i = 0; i <= 5; ++i) half.particles.push_back(11 * j + i);
  sheet.pins = {half};
  return calmed({sheet}, precision);
}

/// RMS distance of positions from others that are translated by `way`, m.
double off_by(const std::vector<Vec3>& x, const std::vector<Vec3>& others, const Vec3& way) {
  double squares = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double d = length(x[i] - others[i] - way);
    squares += d * d;
  }
  return std::sqrt(squares / static_cast<double>(x.size()));
}

class SelfFarOf : public testing::TestWithParam<Scene (*)(const TemporaryFolder&, Precision)> {};

// The tolerance is a few thousandths of the thickness and the speed due to the rounding of velocities; at 1 km float's
// positions are 60 um apart, and a solver with those alone jitters by 1 cm/s.
TEST_P(SelfFarOf, RestsInFloatAsInDoubleUpToAKilometreFromTheOrigin) {
  const TemporaryFolder folder;
  const Simulation twice = after(GetParam()(folder, Precision::Double), 2.5);
  EXPECT_GT(twice.measure().self_contacts, 50);
  for (const double far : {0.0, 20.0, 1000.0}) {
    const Vec3 way{far, -far, far / 2};
    const Simulation once = after(moved_by(GetParam()(folder, Precision::Float), way), 2.5);
    EXPECT_EQ(once.measure().crossings, 0) << far;
    EXPECT_LT(off_by(once.positions(), twice.positions(), way), 3e-6) << far;
    EXPECT_LT(once.measure().speed_max, twice.measure().speed_max + 5e-4) << far;
    EXPECT_EQ(nlohmann::json::parse(once.report("finished"))["notes"].size(), 0u) << far;
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes, SelfFarOf, testing::Values(&far_stack, &far_fold),
                         [](const auto& info) { return info.index == 0 ? "Stack" : "Fold"; });

TEST(SelfFar, WhatIsPutAKilometreAwayRestsThereAsInDouble) {
  const TemporaryFolder folder;
  const Simulation twice = after(far_fold(folder, Precision::Double), 2.5);
  Simulation once(far_fold(folder, Precision::Float), {.threads = 1});
  std::vector<Vec3> x = once.positions();
  for (Vec3& a : x) a[0] += 300, a[1] += 1000;
  once.set_positions(x);
  run_for(once, far_fold(folder, Precision::Float), 2.5);
  EXPECT_EQ(once.measure().crossings, 0);
  EXPECT_LT(off_by(once.positions(), twice.positions(), {300, 1000, 0}), 3e-6);
  EXPECT_LT(once.measure().speed_max, twice.measure().speed_max + 5e-4);
}

/// Two sheets meet so fast in one substep that they are truncated, `seconds` after the start, and fly all that
/// distance.
Scene far_jam(const TemporaryFolder& folder, Precision precision, double seconds, const Vec3& flight) {
  std::vector<BodySpec> sheets;
  for (const int side : {-1, 1}) {
    sheets.push_back(far_sheet(folder, side < 0 ? "lower" : "upper", {0.07 * side, 0, 0.03 * side}, 70 + side, 8));
    BodySpec& sheet = sheets.back();
    sheet.constraints = {stiff("distance", {"edges"})};
    sheet.velocity = {1 + flight[0], -9.0 * side + flight[1], 3.0 * side + flight[2]};
    sheet.transform.translate[1] = side * (0.12 + 9 * seconds), sheet.transform.translate[2] -= side * 3 * seconds;
  }
  Scene scene = scene_of(sheets, {}, 0.01, 1, precision);
  scene.self_collision = SelfCollision{0.001, 0, {}};
  return scene;
}

/// The kinetic energy of two bodies of 0.1 kg each without that of their common motion, J.
double own_energy(const Measures& m) {
  double common = 0;
  for (const double p : m.momentum) common += p * p / (2 * 0.2);
  return m.kinetic - common;
}

// Truncation keeps momenta, and dissipates as much energy as in double: particles move with their bodies as a whole.
TEST(SelfFar, WhatJamsAHundredMetresFromTheOriginKeepsMomentaAndAsMuchEnergyAsInDouble) {
  const TemporaryFolder folder;
  Simulation twice(far_jam(folder, Precision::Double, 0, {}), {.threads = 1});
  std::vector<Measures> right;
  for (int step = 0; step < 4; ++step) twice.step(), right.push_back(twice.measure());
  for (const double far : {0.0, 100.0, 1000.0}) {
    Simulation once(moved_by(far_jam(folder, Precision::Float, 0, {}), {far, far, -far}), {.threads = 1});
    const Measures start = once.measure();
    const double L = 0.1;                   // kg m^2/s: each of them has at least that about the common centre
    for (int step = 0; step < 4; ++step) {  // later the motion is chaotic
      once.step();
      const Measures now = once.measure();
      EXPECT_EQ(now.crossings, 0) << far << ", step " << step;
      EXPECT_NEAR(now.kinetic, right[step].kinetic, 1e-3 * start.kinetic) << far << ", step " << step;
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(now.momentum[k], start.momentum[k], 1e-6) << far << ", step " << step;  // each has 0.9 kg m/s
        EXPECT_NEAR(now.angular_momentum[k], right[step].angular_momentum[k], 1e-3 * L) << far << ", step " << step;
      }
    }
    EXPECT_EQ(once.solver().facts().self->substeps_truncated, twice.solver().facts().self->substeps_truncated) << far;
  }
}

// The origin follows bodies in flight: 300 m in 3 s, to a jam.
TEST(SelfFar, WhatFliesForHundredsOfMetresJamsAsInDouble) {
  const TemporaryFolder folder;
  const Vec3 flight{80, 30, -60};
  std::vector<double> energy[2];
  for (const Precision precision : {Precision::Double, Precision::Float}) {
    const Scene scene = far_jam(folder, precision, 3, flight);
    Simulation one(scene, {.threads = 1});
    run_for(one, scene, 3);
    const Measures start = one.measure();
    EXPECT_EQ(start.self_contacts, 0);
    for (int step = 0; step < 4; ++step) {
      one.step();
      EXPECT_EQ(one.measure().crossings, 0);
      energy[precision == Precision::Float].push_back(own_energy(one.measure()) / own_energy(start));
    }
    EXPECT_GT(one.solver().facts().self->substeps_truncated, 0);
  }
  for (int step = 0; step < 4; ++step) EXPECT_NEAR(energy[1][step], energy[0][step], 2e-3) << "step " << step;
}

/// A fold whose fixed half is moved up by `height` m, at up to 40 m/s.
Scene lifted(const TemporaryFolder& folder, double height, Precision precision) {
  Scene scene = far_fold(folder, precision);
  std::vector<Keyframe>& motion = scene.bodies[0].pins[0].motion;
  double y = 0, v = 0;
  for (int step = 0; height - y > 0.001; ++step) {
    motion.push_back({.time = step / 60.0, .translate = {0, y, 0}});
    v = std::min({40.0, v + 0.5, 0.05 + 2 * (height - y)}), y += v / 60;
  }
  motion.push_back({.time = static_cast<double>(motion.size()) / 60, .translate = {0, height, 0}});
  return scene;
}

TEST(SelfFar, WhatWasLiftedByTwoHundredMetresRestsAsInDouble) {
  const TemporaryFolder folder;
  const auto up = [&](Precision precision) {
    const Scene scene = lifted(folder, 200, precision);
    return after(scene, scene.bodies[0].pins[0].motion.back().time + 2);
  };
  const Simulation once = up(Precision::Float), twice = up(Precision::Double);
  EXPECT_GT(twice.positions()[0][1], 199);
  EXPECT_GT(twice.measure().self_contacts, 50);
  EXPECT_EQ(once.measure().crossings, 0);
  EXPECT_LT(off_by(once.positions(), twice.positions(), {}), 3e-6);
  EXPECT_LT(once.measure().speed_max, twice.measure().speed_max + 5e-4);
}

INSTANTIATE_TEST_SUITE_P(SelfFar, SameBits,
                         testing::Values(SameBitsScene{
                             "WhereTheOriginHasMoved",
                             [](const TemporaryFolder& folder) { return lifted(folder, 8, Precision::Float); },
                             80,
                             {0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75},
                             [](const Simulation& simulation) {
                               EXPECT_GT(simulation.positions()[0][1], 7);
                               EXPECT_GT(simulation.measure().self_contacts, 50);
                             }}),
                         name_of_scene);

}  // namespace
}  // namespace malha
