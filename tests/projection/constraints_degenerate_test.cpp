// SPDX-License-Identifier: Apache-2.0
// Every kind of the registry on degenerate input: without a direction, without an area, or at the ends of the type's
// range. Results stay finite, and without a gradient nothing moves.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/projection/one_constraint.h"

namespace malha {
namespace {

struct BadPlace {
  std::string what;
  Vector3<double> at[4];
  bool has_direction;  // false: no particle may move
};

template <class R>
std::vector<BadPlace> bad_places() {
  using Limits = std::numeric_limits<R>;
  const double denormal = double(Limits::denorm_min()), small = double(Limits::min());
  std::vector<BadPlace> all;
  for (const double o : {0.0, 1.0, 1e15}) {
    const std::string where = " at " + std::to_string(o);
    all.push_back({"all in one place" + where, {{o, o, o}, {o, o, o}, {o, o, o}, {o, o, o}}, false});
  }
  for (const double s : {1e-12, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e8, 1e9, 3e9, 1e10, 1e12, 1e15}) {
    const std::string size = ", size " + std::to_string(s);
    all.push_back({"on one line" + size, {{0, 0, 0}, {s, 0, 0}, {2 * s, 0, 0}, {-s, 0, 0}}, true});
    all.push_back({"on a slanted line" + size, {{0, 0, 0}, {s, s, s}, {s / 3, s / 3, s / 3}, {-s, -s, -s}}, true});
    all.push_back({"the first triangle without area" + size, {{0, 0, 0}, {s, 0, 0}, {s, 0, 0}, {0, s, 0}}, true});
    all.push_back({"the second triangle without area" + size, {{0, 0, 0}, {s, 0, 0}, {0, s, 0}, {0, 0, 0}}, true});
    all.push_back({"the shared edge without length" + size, {{0, 0, 0}, {0, 0, 0}, {s, 0, 0}, {0, s, 0}}, false});
    all.push_back({"folded onto itself" + size, {{0, 0, 0}, {s, 0, 0}, {0, s, 0}, {0, s, 0}}, true});
    all.push_back({"a needle" + size, {{0, 0, 0}, {s, 0, 0}, {s / 2, 1e-6 * s, 0}, {s / 2, -1e-6 * s, 0}}, true});
    all.push_back({"no two alike" + size,
                   {{0.1 * s, 0.2 * s, 0}, {s, -0.3 * s, 0.4 * s}, {-0.5 * s, s, 0.6 * s}, {0.7 * s, 0.8 * s, -s}},
                   true});
    all.push_back({"unequal sizes" + size, {{0, 0, 0}, {1, 0, 0}, {0, s, 0}, {0, 0, 1}}, true});
    all.push_back({"one far away" + size, {{s, s, s}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, true});
  }
  for (const double d : {denormal, 100 * denormal, small, std::sqrt(small), 1e3 * std::sqrt(small)}) {
    all.push_back({"hardly apart", {{0, 0, 0}, {d, 0, 0}, {0, d, 0}, {0, 0, d}}, true});
    all.push_back({"two hardly apart", {{0, 0, 0}, {d, 0, 0}, {0, 1, 0}, {0, 0, 1}}, true});
  }
  return all;
}

/// A kind with more particles has the same positions again, in another order.
template <class Kind>
Corners<Kind> places_of(const BadPlace& bad) {
  Corners<Kind> at;
  for (int j = 0; j < Kind::particles; ++j) at[j] = bad.at[j < 4 ? j : 7 - j];
  return at;
}

/// Kinds whose gradient is zero where positions coincide or a triangle has no area. Others have one unless all
/// particles coincide.
template <class Kind>
constexpr bool kSkipsDegenerate =
    std::is_same_v<Kind, Seam> || std::is_same_v<Kind, Distance> || std::is_same_v<Kind, DistanceLimit> ||
    std::is_same_v<Kind, Bending> || std::is_same_v<Kind, Plate>;

template <class Kind, class R, Update update>
void expect_harmless(const BadPlace& bad, const Rest<Kind>& rest) {
  const Corners<Kind> at = places_of<Kind>(bad);
  std::array<double, Kind::particles> w;
  w.fill(1);
  OneConstraint<Kind, R> one(at, w, rest);
  const OneConstraint<Kind, R> before = one;
  Vector3<R> grad[Kind::particles];
  R scale, squares = 0;
  const R C = one.evaluate(grad, scale);
  bool pulls = false;  // true even for a tiny correction, whose square may underflow
  for (const auto& g : grad) squares += dot(g, g), pulls = pulls || g.x != R(0) || g.y != R(0) || g.z != R(0);
  one.template project<update>(1, 1e-3);

  const std::string what = std::string(Kind::name) + ", " + bad.what;
  EXPECT_TRUE(std::isfinite(C)) << what;
  EXPECT_TRUE(std::isfinite(scale) && scale >= 0) << what;
  EXPECT_TRUE(std::isfinite(squares)) << what;
  EXPECT_TRUE(std::isfinite(one.lambda[0])) << what;
  for (int j = 0; j < Kind::particles; ++j) {
    EXPECT_TRUE(std::isfinite(one.p(j).x + one.p(j).y + one.p(j).z)) << what;
    const bool skipped = kSkipsDegenerate<Kind> && !bad.has_direction;
    if (!pulls || skipped) {
      EXPECT_TRUE(same_bits(one.way(j), before.way(j))) << what;
    }
  }
}

template <class Kind, class R>
void expect_harmless_everywhere() {
  for (const BadPlace& bad : bad_places<R>())
    for (const double rest : {0.0, 1.0, 3.0}) {
      expect_harmless<Kind, R, Update::Stiff>(bad, rest);
      expect_harmless<Kind, R, Update::Compliant>(bad, rest);
    }
}

TEST(EveryConstraint, StaysFiniteOnDegenerateInputAndMovesNothingWithoutDirection) {
  for_each_constraint([]<class Kind>(Kind) {
    expect_harmless_everywhere<Kind, float>();
    expect_harmless_everywhere<Kind, double>();
  });
}

// A run's padding reads and writes particles of other constraints, some of which may be non-finite.
TEST(EveryConstraint, GivesPaddingAZeroGradientWhateverItReads) {
  for_each_constraint([]<class Kind>(Kind) {
    constexpr float huge = std::numeric_limits<float>::max(), infinity = std::numeric_limits<float>::infinity();
    for (const float there : {0.0f, 1e12f, 0x1p124f, huge, infinity, std::numeric_limits<float>::quiet_NaN()})
      for (int far = 0; far < Kind::particles; ++far) {
        Vector3<float> q[6] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}}, grad[Kind::particles];
        q[far] = {there, -there, there};
        Vector3<float> corners[Kind::particles];
        std::copy_n(q, Kind::particles, corners);
        float scale;
        float rest[Kind::rest_values];
        std::fill_n(rest, Kind::rest_values, 1.0f);
        Kind::evaluate(corners, rest, false, grad, scale);
        for (const auto& g : grad) EXPECT_EQ(dot(g, g), 0) << Kind::name << ", " << there;
      }
  });
}

TEST(EveryConstraint, HasAFiniteRestValueOnDegenerateInput) {
  for_each_constraint([]<class Kind>(Kind) {
    for (const BadPlace& bad : bad_places<double>()) {
      const Corners<Kind> at = places_of<Kind>(bad);
      for (const double number : rest_of<Kind>(at, Kind::parameter.default_value))
        EXPECT_TRUE(std::isfinite(number)) << Kind::name << ", " << bad.what;
    }
  });
}

TEST(Bending, DoesNotMoveAHingeOfATriangleWithoutArea) {
  for (const BadPlace& bad : bad_places<float>()) {
    if (bad.what.find("without area") == std::string::npos) continue;
    OneConstraint<Bending, float> one({bad.at[0], bad.at[1], bad.at[2], bad.at[3]}, {1, 1, 1, 1}, 1);
    const OneConstraint<Bending, float> before = one;
    EXPECT_EQ(before.C(), 0) << "and it counts as met";
    one.project<Update::Stiff>(1, 0);
    for (int j = 0; j < 4; ++j) EXPECT_TRUE(same_bits(one.way(j), before.way(j))) << bad.what;
  }
}

TEST(Bending, SkipsSliversByTheirShapeWhateverTheirSize) {
  for (const float s : {1e-3f, 1.0f, 1e3f})
    for (const float height : {1e-7f, 1e-4f}) {  // over the edge: below float's rounding of it, and well above
      OneConstraint<Bending, float> one({{{0, 0, 0}, {s, 0, 0}, {s / 2, height * s, 0}, {s / 2, 0, s}}}, {1, 1, 1, 1},
                                        0);
      Vector3<float> grad[4];
      float scale;
      one.evaluate(grad, scale);
      EXPECT_EQ(dot(grad[2], grad[2]) > 0, height > 1e-5f) << height << " of " << s;
    }
}

TEST(Bending, ActsAlikeOnSmallAndLargeHinges) {
  // The areas that count as zero scale with the edge: a millimetre and a kilometre bend as a metre does, by 0.37 rad.
  float first = 0;
  for (const double s : {1e-3, 1.0, 1e3}) {
    const Corners<Bending> at{{{0, 0, 0}, {s, 0, 0}, {0, s, 0}, {0, 0, s}}};
    Rest<Bending> rest = rest_of<Bending>(at, 1);
    ASSERT_LT(rest[0], -1.5);
    rest[0] = -1.2;
    OneConstraint<Bending, float> one(at, {1, 1, 1, 1}, rest);
    const float before = one.C();
    EXPECT_GT(std::abs(before), 0.3f) << s;
    one.project<Update::Stiff>(1, 0);
    if (first == 0) first = one.C();
    EXPECT_NEAR(one.C(), first, std::abs(before) / 128) << s << ": how far one projection goes is rounded to 8 bits";
    for (int k = 1; k < 20; ++k) one.project<Update::Stiff>(1, 0);
    EXPECT_LT(std::abs(one.C()), 1e-5f) << s;
  }
}

}  // namespace
}  // namespace malha
