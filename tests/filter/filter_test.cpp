// SPDX-License-Identifier: Apache-2.0
// The filter, dense and from a sparse factor, in every storage, against the same system solved by Eigen in long double.
#include "host/filter/filter.h"

#include <gtest/gtest.h>

#include "host/filter/supernodes.h"
#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

/// Tolerances of the relative error of a storage: for random forces, and for elastic ones, of which S removes most. The
/// part that S removes grows with a chain's length and stiffness: the numbers are those of the worst cases here, 100
/// particles in a row or one with 300 springs, at k = 1e6 N/m (k dt^2 / m = 1e3 to 1e6), with a margin for other
/// compilers.
struct Bounds {
  double noise, elastic;
};
constexpr Bounds kDouble{1e-12, 1e-12}, kFloat{1e-6, 5e-5}, kInt16{2e-4, 1e-2};

void expect_exact(const SolvedSystem& solved) {
  const std::vector<double> noise = noise_forces(solved.system), elastic = elastic_forces(solved.system);
  const auto check = [&]<class R>(R, FilterKind kind, Storage storage, const Bounds& most, const char* name) {
    SCOPED_TRACE(name);
    const FilterUnderTest<R> filter(solved, kind, storage);
    const FilterErrors truth{filter.error(noise), filter.error(elastic)}, stated = filter.stated_errors();
    EXPECT_LT(truth.noise, most.noise);
    EXPECT_LT(truth.elastic, most.elastic);
    // The error that the filter reports is the measured one; near double's own rounding, its order of magnitude.
    const double rounding = storage == Storage::Double ? 1 : 0.01, floor = storage == Storage::Double ? 2e-14 : 0;
    EXPECT_NEAR(stated.noise, truth.noise, rounding * truth.noise + floor);
    EXPECT_NEAR(stated.elastic, truth.elastic, rounding * truth.elastic + floor);
  };
  check(0.0, FilterKind::Dense, Storage::Double, kDouble, "dense, double");
  check(0.0, FilterKind::Sparse, Storage::Double, kDouble, "sparse, double");
  check(0.0f, FilterKind::Dense, Storage::Float, kFloat, "dense, float");
  check(0.0f, FilterKind::Sparse, Storage::Float, kFloat, "sparse, float");
  check(0.0f, FilterKind::Dense, Storage::Int16, kInt16, "dense, int16");
}

class FilterOfStiffness : public testing::TestWithParam<double> {
 protected:
  static void expect_exact(const BodySpec& body) {
    malha::expect_exact(SolvedSystem(desbrun_scene({body}, GetParam())));
  }
};

TEST_P(FilterOfStiffness, OfAPinnedSheetIsTheInverse) { expect_exact(sprung_sheet(9, {RowPin{}})); }
TEST_P(FilterOfStiffness, OfAFreeSheetIsTheInverse) { expect_exact(sprung_sheet(9)); }

// A block of the dense filter has 16 rows, a panel of the sparse one 4.
TEST_P(FilterOfStiffness, OfChainsOfAnyLengthIsTheInverse) {
  for (const int unknowns : {1, 2, 3, 4, 5, 7, 8, 9, 11, 13, 15, 16, 17, 31, 33, 100})
    for (const bool free : {false, true}) {
      if (free && unknowns == 1) continue;  // no spring
      SCOPED_TRACE(std::to_string(unknowns) + (free ? " free" : " hung"));
      expect_exact(sprung_chain(unknowns, free));
    }
}

TEST_P(FilterOfStiffness, OfAStarIsTheInverse) {
  const TemporaryFolder folder;
  expect_exact(star(folder, 30));
  expect_exact(star(folder, 300, {ListPin{{1}}}));
  expect_exact(star(folder, 40, {ListPin{{0}}}));  // 40 bodies of one unknown
}

TEST_P(FilterOfStiffness, OfBodiesWithAndWithoutPinsIsTheInverseOfEach) {
  BodySpec hung = sprung_sheet(6, {ListPin{{0}}}), free = sprung_sheet(5), ball = sprung_sheet(4);
  free.name = "free", free.density = 3;
  ball.name = "ball", ball.shape = SphereShape{0.5, 1};
  malha::expect_exact(SolvedSystem(desbrun_scene({hung, free, ball, particle({9, 9, 9})}, GetParam())));
}

INSTANTIATE_TEST_SUITE_P(, FilterOfStiffness, testing::Values(1e2, 1e4, 1e6), [](const auto& tested) {
  return "1e" + std::to_string(static_cast<int>(std::log10(tested.param)));
});

/// A sheet of 30 x 29 cells: several tasks and a root of the sparse filter, several chunks of the dense one.
class LargeFilter : public testing::TestWithParam<bool> {
 protected:
  static BodySpec sheet() { return sprung_sheet(30, GetParam() ? std::vector<Pin>{} : std::vector<Pin>{RowPin{}}); }
};

TEST_P(LargeFilter, IsTheInverse) {
  const SolvedSystem solved(desbrun_scene({sheet()}, 1e4));
  const Subtrees cut = subtrees(supernodes(solved.system));
  EXPECT_GT(cut.tasks.size(), 2u);
  EXPECT_FALSE(cut.top.empty());
  expect_exact(solved);
}

TEST_P(LargeFilter, HasTheSameBitsOnAnyNumberOfThreads) {
  const SolvedSystem solved(desbrun_scene({sheet()}, 1e4));
  const std::vector<double> noise = noise_forces(solved.system);
  for (const FilterKind kind : {FilterKind::Dense, FilterKind::Sparse}) {
    const std::vector<double> one = FilterUnderTest<float>(solved, kind, {}, 1)(noise);
    for (const int threads : {2, 3, 5}) EXPECT_EQ(FilterUnderTest<float>(solved, kind, {}, threads)(noise), one);
  }
}

INSTANTIATE_TEST_SUITE_P(, LargeFilter, testing::Bool(),
                         [](const auto& tested) { return std::string(tested.param ? "Free" : "Pinned"); });

/// sum_j W_ij = 1 with W = m S: a uniform force moves a free body rigidly. The filter is stored without its mean mode,
/// so that its response to such a force is zero.
TEST(FilterOfAFreeBody, LeavesAnEqualForceOnEqualMassesToTheMean) {
  BodySpec ring = sprung_sheet(8);
  ring.shape = SphereShape{0.4, 1};
  const SolvedSystem solved(desbrun_scene({ring}, 1e5));
  const int n = solved.system.count();
  // The matrix itself has W 1 = 1, whatever the masses: S m = 1.
  Eigen::VectorXd m(n);
  for (int i = 0; i < n; ++i) m[i] = solved.system.mass[i];
  const Eigen::VectorXd one = Eigen::MatrixXd(matrix_of<double>(solved.system)).llt().solve(m);
  EXPECT_LT((one - Eigen::VectorXd::Ones(n)).cwiseAbs().maxCoeff(), 1e-9);  // rounding times k dt^2 / m = 1e4
  std::vector<double> weight;
  for (int i = 0; i < n; ++i) weight.insert(weight.end(), {0, -9.81 * m[i], 0});
  for (const FilterKind kind : {FilterKind::Dense, FilterKind::Sparse})
    for (const double a : FilterUnderTest<double>(solved, kind)(weight)) ASSERT_NEAR(a, 0, 1e-10);
}

/// In a pinned body, as in implicit Euler, the springs balance the weight: near the pins little of it is left.
TEST(FilterOfAPinnedBody, TakesMostOfTheWeightAwayNearThePin) {
  const SolvedSystem solved(desbrun_scene({sprung_chain(20, false)}, 1e5));
  std::vector<double> weight;
  for (const double m : solved.system.mass) weight.insert(weight.end(), {0, -9.81 * m, 0});
  const std::vector<double> a = FilterUnderTest<double>(solved, FilterKind::Sparse)(weight);
  std::vector<double> by_place(20);
  for (int i = 0; i < 20; ++i) by_place[solved.model.user_index[solved.system.particle[i]] - 1] = a[3 * i + 1];
  for (int i = 0; i < 20; ++i) {
    EXPECT_LT(by_place[i], 0);
    EXPECT_GT(by_place[i], -9.81);
    if (i > 0) {
      EXPECT_LT(by_place[i], by_place[i - 1]) << "the further from the pin, the more";
    }
  }
  EXPECT_GT(by_place[0], -20 * 9.81 * 0.1 * 3600 / 1e5) << "its spring need hold no more than the weight of all";
}

/// If the mean stayed in S, or were subtracted from a solved S, float would lose all digits here.
TEST(FilterOfAFreeBody, KeepsItsDigitsHoweverStiff) {
  for (const double stiffness : {1e6, 1e9, 1e12}) {
    const SolvedSystem solved(desbrun_scene({sprung_sheet(9)}, stiffness));  // k dt^2 / m = 3.7e5, ..., 3.7e11
    const std::vector<double> noise = noise_forces(solved.system), elastic = elastic_forces(solved.system);
    EXPECT_LT(FilterUnderTest<double>(solved, FilterKind::Dense).error(elastic), 1e-13) << stiffness;
    EXPECT_LT(FilterUnderTest<float>(solved, FilterKind::Dense).error(noise), 1e-6) << stiffness;
    EXPECT_LT(FilterUnderTest<float>(solved, FilterKind::Dense).error(elastic), 1e-6) << stiffness;
    EXPECT_LT(FilterUnderTest<float>(solved, FilterKind::Dense, Storage::Int16).error(elastic), 1e-3) << stiffness;
    EXPECT_LT(FilterUnderTest<double>(solved, FilterKind::Sparse).error(elastic), 1e-13) << stiffness;
    // The mean, which comes from the rounding of forces that should have none, grows with k dt^2 / m until it is
    // removed.
    const double mean = 1.2e-7 * 1.2e-7 * stiffness / 2.7;
    EXPECT_LT(FilterUnderTest<float>(solved, FilterKind::Sparse).error(elastic), 1e-5 + mean) << stiffness;
  }
}

TEST(Filter, IsSymmetricAndPositive) {
  BodySpec hung = sprung_sheet(5, {ListPin{{0}}}), free = sprung_sheet(4);
  free.name = "free";
  const SolvedSystem solved(desbrun_scene({hung, free}, 1e4));
  Random random(3);
  for (const FilterKind kind : {FilterKind::Dense, FilterKind::Sparse}) {
    const FilterUnderTest<double> filter(solved, kind);
    std::vector<double> f(3 * solved.system.count()), g = f;
    for (double& a : f) a = random();
    for (double& a : g) a = random();
    const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
      double sum = 0;
      for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
      return sum;
    };
    const std::vector<double> Sf = filter(f), Sg = filter(g);
    EXPECT_GT(product(f, Sf), 0);
    EXPECT_NEAR(product(g, Sf), product(f, Sg),
                1e-10 * product(f, Sf));  // the mean of f, m dt^2 k times S f, is removed
  }
}

TEST(Filter, AddsToWhatIsThereOrReplacesItAndLeavesPinsAndLooseParticlesAlone) {
  const SolvedSystem solved(desbrun_scene({sprung_sheet(5, {RowPin{}}), particle({9, 9, 9})}, 1e4));
  Model model = solved.model;
  const std::vector<Vec3> forces(model.x.size(), Vec3{1, -2, 3}), before(model.x.size(), Vec3{4, 5, 6});
  for (const FilterKind kind : {FilterKind::Dense, FilterKind::Sparse}) {
    model.scene.solver.desbrun.filter = kind;
    const auto filter = make_filter<OpenMP, double>(OpenMP{1, widest_instructions()}, 1, model, solved.system, {});
    const auto result = [&](bool adds) {
      PointArray<Serial, double> force(forces), a(before);
      filter->apply({force.points(), a.points(), adds});
      return a.download();
    };
    const std::vector<Vec3> replaced = result(false), added = result(true);
    std::vector<bool> unknown(model.x.size(), false);
    for (const int i : solved.system.particle) unknown[i] = true;
    for (std::size_t i = 0; i < replaced.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        ASSERT_EQ(added[i][k], unknown[i] ? before[i][k] + replaced[i][k] : before[i][k]);
        ASSERT_TRUE(unknown[i] || replaced[i][k] == before[i][k]);
      }
  }
}

/// A long, stiff chain in 16 bits is no longer an inverse, and a message says so: refinement with it does not converge.
TEST(Filter, ThatIsFarFromTheInverseSaysSo) {
  for (const int links : {200, 2400}) {
    Scene scene = desbrun_scene({hung_chain({0, 0, 0}, {0, -1, 0}, links, 1.0 / links)}, 1e7, Precision::Float);
    scene.solver.dt = 1.0 / 30;
    scene.bodies[0].constraints = {stiff("distance", {"edges"})};
    const SolvedSystem solved(scene);
    const FilterUnderTest<float> filter(solved, FilterKind::Dense, Storage::Int16);
    const std::vector<double> elastic = elastic_forces(solved.system);
    const std::vector<double> exact = exact_filter(solved.system)(elastic);
    const double error = relative_difference(filter(elastic), exact);
    EXPECT_NEAR(filter.stated_errors().elastic / error, 1, 0.01) << links << " links, error " << error;
  }
}

TEST(Filter, IsChosenBySizeAndSaysWhy) {
  const auto facts = [](int cells) {
    const SolvedSystem solved(desbrun_scene({sprung_sheet(cells, {RowPin{}})}, 1e4));
    return FilterUnderTest<float>(solved, FilterKind::Auto).facts();
  };
  const FilterStats small = facts(4), large = facts(40);
  EXPECT_EQ(small.kind, "dense");
  EXPECT_EQ(large.kind, "sparse");
  for (const FilterStats& one : {small, large}) {
    EXPECT_NE(one.why.find("dense"), std::string::npos);
    EXPECT_EQ(one.storage, "float");
    EXPECT_EQ(one.bodies, 1);
    EXPECT_GE(one.bytes, 4 * static_cast<std::size_t>(one.numbers));
  }
  EXPECT_EQ(small.unknowns, 5 * 3);
  EXPECT_EQ(large.unknowns, 41 * 39);
}

}  // namespace
}  // namespace malha
