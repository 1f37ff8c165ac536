// SPDX-License-Identifier: Apache-2.0
#include "host/report/expect.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "malha/text.h"

namespace malha {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
using Lines = std::vector<std::string>;

/// An expectation of "at most `allowed`", by its name in a scene, and the measure that it bounds.
struct AtMost {
  std::string name;
  Range Expect::*allowed;
  std::function<void(Measures&, double)> measure;
};

const std::vector<AtMost> kAtMost = {
    {"max_strain", &Expect::max_strain, [](Measures& m, double a) { m.strain_max = a; }},
    {"rms_strain", &Expect::rms_strain, [](Measures& m, double a) { m.strain_rms = a; }},
    {"max_penetration", &Expect::max_penetration, [](Measures& m, double a) { m.penetration_max = a; }},
    {"max_speed", &Expect::max_speed, [](Measures& m, double a) { m.speed_max = a; }},
};

TEST(UnmetExpectations, AreNoneWhereNothingIsExpected) {
  Measures bad;
  bad.strain_max = bad.strain_rms = bad.penetration_max = bad.kinetic = bad.speed_max = kNaN;
  bad.volume_ratios = {kNaN};
  EXPECT_EQ(unmet_expectations({}, bad, {{1e30, 0, 0}}), Lines{});
}

TEST(UnmetExpectations, ReportEveryNumberThatIsTooLarge) {
  for (const AtMost& one : kAtMost) {
    Expect expect;
    expect.*one.allowed = 0.5;
    Measures measures;
    for (const double good : {-1.0, 0.0, 0.5}) {
      one.measure(measures, good);
      EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{}) << one.name;
    }
    one.measure(measures, 0.75);
    EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{one.name + ": found 0.75; expected at most 0.5"});
    one.measure(measures, std::numeric_limits<double>::infinity());
    EXPECT_EQ(unmet_expectations(expect, measures, {}).size(), 1u) << one.name;
  }
}

TEST(UnmetExpectations, ReportEveryNumberThatIsTooSmall) {
  for (const AtMost& one : kAtMost) {
    Expect expect;
    (expect.*one.allowed).at_least = 0.5;
    Measures measures;
    for (const double good : {0.5, 7.0}) {
      one.measure(measures, good);
      EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{}) << one.name;
    }
    one.measure(measures, 0.25);
    EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{one.name + ": found 0.25; expected at least 0.5"});
    (expect.*one.allowed).at_most = 0.75;
    one.measure(measures, 0.8);
    EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{one.name + ": found 0.8; expected at most 0.75"});
  }
  Expect expect;
  expect.max_crossings.at_least = 2, expect.inverted_tetrahedra.at_least = 1, expect.energy_not_below = -3;
  Measures measures;
  measures.crossings = 1, measures.potential = -4;
  EXPECT_EQ(unmet_expectations(expect, measures, {}),
            (Lines{"max_crossings: found 1; expected at least 2", "energy_not_below: found -4; expected at least -3",
                   "inverted_tetrahedra: found 0; expected at least 1"}));
}

TEST(UnmetExpectations, TestTheBoxOfABody) {
  Expect expect;
  expect.bodies = {{"flag", {0, 0, 0}, {1, 1, 1}}};
  const std::vector<ParticlesOfBody> bodies{{"pole", 0, 2}, {"flag", 2, 5}};
  EXPECT_EQ(unmet_expectations(expect, {}, {{9, 9, 9}, {-9, 0, 0}, {0, 0, 0}, {1, 1, 1}, {0, 1, 0.5}}, bodies), Lines{})
      << "where the pole is does not matter";
  EXPECT_EQ(unmet_expectations(expect, {}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 1.5, 0}, {0, 0, kNaN}}, bodies)[1],
            "bounds of body 'flag': found 2 particles outside the box, such as 1 at (0, 1.5, 0); expected all from "
            "(0, 0, 0) to (1, 1, 1)");
}

TEST(UnmetExpectations, ReportNaNAsUnmet) {
  for (const AtMost& one : kAtMost) {
    Expect expect;
    expect.*one.allowed = 0.5;
    Measures measures;
    one.measure(measures, kNaN);
    EXPECT_EQ(unmet_expectations(expect, measures, {}).size(), 1u) << one.name;
  }
  Expect expect;
  expect.volume_ratio = {0.9, 1.1};
  Measures measures;
  measures.volume_ratios = {kNaN};
  EXPECT_EQ(unmet_expectations(expect, measures, {}).size(), 2u) << "neither large nor small enough";
}

TEST(UnmetExpectations, CountEnergyAsTheSumOfItsKinds) {
  Expect expect;
  expect.energy_not_above = 6;
  Measures measures;
  measures.kinetic = 1, measures.potential = 2, measures.elastic = 3;
  EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{});
  measures.elastic = 4;
  EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{"energy_not_above: found 7; expected at most 6"});
}

TEST(UnmetExpectations, TestTheVolumeOfEveryBody) {
  Expect expect;
  expect.volume_ratio = {0.9, 1.1};
  Measures measures;
  measures.volume_ratios = {0.9, 1.0, 1.1};
  EXPECT_EQ(unmet_expectations(expect, measures, {}), Lines{});
  measures.volume_ratios = {1.0, 0.5, 1.5};
  EXPECT_EQ(unmet_expectations(expect, measures, {}),
            (Lines{"volume_ratio: found 0.5; expected at least 0.9", "volume_ratio: found 1.5; expected at most 1.1"}));
}

TEST(UnmetExpectations, CountParticlesOutsideTheBox) {
  Expect expect;
  expect.bounds_min = {0, 0, 0}, expect.bounds_max = {1, 1, 1};
  EXPECT_EQ(unmet_expectations(expect, {}, {{0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5}}), Lines{});
  for (int axis = 0; axis < 3; ++axis)
    for (const double outside : {-0.001, 1.001}) {
      Vec3 x{0.5, 0.5, 0.5};
      x[axis] = outside;
      EXPECT_EQ(unmet_expectations(expect, {}, {x, {0.5, 0.5, 0.5}, x}),
                Lines{"bounds: found 2 particles outside the box, such as 0 at (" + shown(x[0]) + ", " + shown(x[1]) +
                      ", " + shown(x[2]) + "); expected all from (0, 0, 0) to (1, 1, 1)"});
    }
}

TEST(UnmetExpectations, TakeHalfABox) {
  Expect low, high;
  low.bounds_min = {0, 0, 0}, high.bounds_max = {1, 1, 1};
  EXPECT_EQ(unmet_expectations(low, {}, {{9, 9, 9}}), Lines{});
  EXPECT_EQ(unmet_expectations(low, {}, {{9, -9, 9}}).size(), 1u);
  EXPECT_EQ(unmet_expectations(high, {}, {{-9, -9, -9}}), Lines{});
  EXPECT_EQ(unmet_expectations(high, {}, {{-9, 9, -9}}).size(), 1u);
}

TEST(UnmetExpectations, AlwaysReportPositionsThatAreNotFinite) {
  for (const double bad : {kNaN, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()})
    EXPECT_EQ(unmet_expectations({}, {}, {{0, 0, 0}, {0, bad, 0}}), Lines{"1 particle not finite"});
  Expect expect;
  expect.bounds_min = {0, 0, 0};
  EXPECT_EQ(unmet_expectations(expect, {}, {{kNaN, 1, 1}}).size(), 2u) << "nor is NaN inside a box";
}

TEST(UnmetExpectations, ReportSeveralAtOnce) {
  Expect expect;
  expect.max_strain = 0.1, expect.max_speed = 1, expect.bounds_max = {1, 1, 1};
  Measures measures;
  measures.strain_max = 0.2, measures.speed_max = 2;
  EXPECT_EQ(unmet_expectations(expect, measures, {{2, 0, 0}}).size(), 3u);
}

}  // namespace
}  // namespace malha
