// SPDX-License-Identifier: Apache-2.0
// Chains of equal masses, whose filter has a closed form. With a = k dt^2 / m, W = (1 + a K)^-1, where K is tridiagonal
// with 2 on the diagonal (1 at a free end) and -1 beside it: W_ij obeys the recurrence of cosh, so with
// cosh(t) = 1 + 1 / (2 a) and n masses, i <= j counted from 1,
//   pinned at both ends: W_ij = sinh(i t) sinh((n + 1 - j) t) / (a sinh(t) sinh((n + 1) t)),
//   free at both ends:   W_ij = cosh((i - 1/2) t) cosh((n + 1/2 - j) t) / (a sinh(t) sinh(n t)),
//   pinned before 1:     W_ij = sinh(i t) cosh((n + 1/2 - j) t) / (a sinh(t) cosh((n + 1/2) t)).
#include <gtest/gtest.h>

#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

enum class Ends { Pinned, Hung, Free };

constexpr double kMass = 0.25, kChainStep = 0.01;

/// `n` unknowns and their pins. With lumped masses an end has half the mass of the others, and a mesh of ends alone,
/// all of the same mass, is a cloud of springs in pairs; so this test sets the mass of every particle itself.
class Chain {
 public:
  Chain(Ends ends, int n, double a) : ends_(ends), n_(n), a_(a) {
    const int before = ends == Ends::Free ? 0 : 1, after = ends == Ends::Pinned ? 1 : 0;
    BodySpec body = hung_chain({0, 0, 0}, {1, 0, 0}, n + before + after - 1);
    body.pins.clear();
    if (before) body.pins.push_back(ListPin{{0}});
    if (after) body.pins.push_back(ListPin{{n + 1}});
    body.constraints = {stiff("distance", {"edges"})};
    Scene scene = desbrun_scene({body}, a * kMass / (kChainStep * kChainStep));
    scene.solver.dt = kChainStep;
    model_ = build_model(scene);
    for (double& w : model_.w) w = w > 0 ? 1 / kMass : 0;
    system_ = spring_system(model_, kChainStep);
    first_ = before;
  }

  double W(int i, int j) const {
    if (i > j) std::swap(i, j);
    const double t = std::acosh(1 + 1 / (2 * a_)), n = n_;
    const double scale = 1 / (a_ * std::sinh(t));
    if (ends_ == Ends::Pinned) return scale * std::sinh(i * t) * std::sinh((n + 1 - j) * t) / std::sinh((n + 1) * t);
    if (ends_ == Ends::Free) return scale * std::cosh((i - 0.5) * t) * std::cosh((n + 0.5 - j) * t) / std::sinh(n * t);
    return scale * std::sinh(i * t) * std::cosh((n + 0.5 - j) * t) / std::cosh((n + 0.5) * t);
  }

  /// Row i of W: the filter's response to forces of m on each particle in turn, three at a time; without the mean, 1/n,
  /// for a free chain.
  template <class R>
  std::vector<double> row(FilterKind kind, int i) const {
    Model model = model_;
    model.scene.solver.desbrun.filter = kind;
    const auto filter = make_filter<OpenMP, R>(OpenMP{1, widest_instructions()}, 1, model, system_, {});
    std::vector<double> found;
    for (int j = 1; j <= n_; ++j) {
      std::vector<Vec3> all(model.x.size(), Vec3{0, 0, 0});
      all[at(j)] = {kMass, -kMass, 2 * kMass};
      PointArray<Serial, R> force(all), acceleration(all.size());
      filter->apply({force.points(), acceleration.points(), false});
      const std::vector<Vec3> a = acceleration.download();
      double mean = 0;
      if (ends_ == Ends::Free)
        for (int k = 1; k <= n_; ++k) mean += a[at(k)][0] / n_;
      found.push_back(a[at(i)][0] - mean);
      EXPECT_EQ(a[at(i)][1], -a[at(i)][0]) << "x, y and z alike";
      EXPECT_NEAR(a[at(i)][2], 2 * a[at(i)][0], 1e-37);  // float has fewer digits below that
    }
    return found;
  }

  void expect_exact() const {
    for (const int i : {1, (n_ + 1) / 2, n_}) {
      std::vector<double> expected;
      for (int j = 1; j <= n_; ++j) expected.push_back(W(i, j) - (ends_ == Ends::Free ? 1.0 / n_ : 0));
      const double largest = *std::max_element(expected.begin(), expected.end()) + (ends_ == Ends::Free ? 1.0 / n_ : 0);
      for (const FilterKind kind : {FilterKind::Dense, FilterKind::Sparse}) {
        const std::vector<double> exact = row<double>(kind, i), single = row<float>(kind, i);
        for (int j = 0; j < n_; ++j) {
          // The smallest eigenvalue is at least (1/n)^2 a: the rounding of A, relative to it; and of cosh(n t).
          ASSERT_NEAR(exact[j], expected[j], 1e-15 * n_ * n_ * std::max(1.0, a_) * largest) << i << ", " << j + 1;
          ASSERT_NEAR(single[j], expected[j], 1e-6 * largest) << i << ", " << j + 1;
        }
      }
    }
  }

 private:
  int at(int j) const {
    for (int k = 0;; ++k)
      if (model_.user_index[k] == first_ + j - 1) return k;
  }

  Ends ends_;
  int n_, first_ = 0;
  double a_;
  Model model_;
  SpringSystem system_;
};

TEST(FilterOfAChain, PinnedAtBothEndsIsTheClosedForm) {
  for (const int n : {1, 2, 3, 10, 40})
    for (const double a : {0.01, 1.0, 300.0}) Chain(Ends::Pinned, n, a).expect_exact();
}
TEST(FilterOfAChain, HungIsTheClosedForm) {
  for (const int n : {1, 2, 3, 10, 40})
    for (const double a : {0.01, 1.0, 300.0}) Chain(Ends::Hung, n, a).expect_exact();
}
TEST(FilterOfAChain, FreeIsTheClosedFormButForItsMean) {
  for (const int n : {2, 3, 10, 40})
    for (const double a : {0.01, 1.0, 300.0}) Chain(Ends::Free, n, a).expect_exact();
}

/// The same W from its modes, cos(pi p (i - 1/2) / n), and its row sum of 1: this validates the formulas above.
TEST(FilterOfAChain, HasTheModesOfAChain) {
  const int n = 12;
  const double a = 7;
  const Chain chain(Ends::Free, n, a);
  for (int i = 1; i <= n; ++i) {
    double sum = 0;
    for (int j = 1; j <= n; ++j) {
      double expected = 1.0 / n;
      for (int p = 1; p < n; ++p) {
        const double half = std::sin(kPi * p / (2 * n));
        expected +=
            2.0 / n * std::cos(kPi * p * (i - 0.5) / n) * std::cos(kPi * p * (j - 0.5) / n) / (1 + 4 * a * half * half);
      }
      EXPECT_NEAR(chain.W(i, j), expected, 1e-14);
      sum += chain.W(i, j);
    }
    EXPECT_NEAR(sum, 1, 1e-14);
  }
}

}  // namespace
}  // namespace malha
