#include "host/solver/batches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "tests/one_constraint.h"

namespace malha {
namespace {

/// A model and a set of one kind with random particles: shared ones, pinned ones, and more than three packs a colour.
template <class Kind>
struct RandomSet {
  static constexpr int n = Kind::particles;
  Model model;
  ConstraintSet set;

  RandomSet(int constraints, unsigned seed, std::optional<double> compliance) {
    Random random(seed);
    const int particles = constraints * n;
    for (int i = 0; i < particles; ++i) {
      model.x.push_back({random(), random(), random()});
      model.w.push_back(random.below(10) == 0 ? 0 : random(0.2, 5));
      if (model.w.back() == 0) model.x.back()[0] = -0.0;  // adding even a zero to it would be seen
    }
    model.scene.solver.dt = 0.1;
    model.scene.solver.substeps = 3;
    model.scene.solver.iterations = 2;
    set.type = Kind::name;
    set.arity = n;
    set.stiffness = 0.8;
    set.compliance = compliance;
    set.parameter = Kind::parameter.standard;
    for (int c = 0; c < constraints; ++c)
      for (int j = 0; j < n; ++j)  // mostly particles of its own, so that the first colour is large
        set.particles.push_back(random.below(4) == 0 ? other_than(c, j, random) : c * n + j);
  }

  /// A particle that is not of this constraint yet.
  int other_than(int c, int j, Random& random) const {
    const auto begin = set.particles.begin() + c * n;
    for (;;) {
      const int i = random.below(static_cast<int>(model.x.size()));
      if (std::find(begin, set.particles.end(), i) == set.particles.end() && (i < c * n + j || i >= (c + 1) * n))
        return i;
    }
  }

  /// Predicted positions unlike the rest state.
  template <class R>
  std::vector<Vec4<R>> moved(unsigned seed) const {
    Random random(seed);
    std::vector<Vec4<R>> p;
    for (std::size_t i = 0; i < model.x.size(); ++i) {
      const Vector3<double> d = model.w[i] > 0 ? random.in_cube(0.5) : Vector3<double>{-0.0, 0, 0};
      p.push_back({R(model.x[i][0] + d.x), R(model.x[i][1] + d.y), R(model.x[i][2] + d.z), R(model.w[i])});
    }
    return p;
  }
};

/// The same sweep one constraint at a time in plain scalars: the formulas of Müller et al. 2006 and Macklin et al.
/// 2016.
template <class Kind, class R>
class ScalarSweep {
 public:
  static constexpr int n = Kind::particles;
  ScalarSweep(const Model& model, const ConstraintSet& set) : set_(set), lambda_(set.count(), R(0)) {
    const SolverSpec& solver = model.scene.solver;
    const double h = solver.dt / solver.substeps;
    k_ = R(1 - std::pow(1 - set.stiffness, 1.0 / (solver.substeps * solver.iterations)));
    alpha_ = R(set.compliance.value_or(0) / (h * h));
    std::vector<bool> pinned;
    for (const double w : model.w) pinned.push_back(w == 0);
    colouring_ = colour(set.particles, n, pinned);
    for (int c = 0; c < set.count(); ++c) {
      Vector3<double> X[n];
      for (int j = 0; j < n; ++j) {
        const Vec3& x = model.x[set.particles[c * n + j]];
        X[j] = {x[0], x[1], x[2]};
      }
      rest_.push_back(R(Kind::rest(X, set.parameter)));
    }
  }

  void operator()(Vec4<R>* p) {
    for (int chosen = 0; chosen < colouring_.count; ++chosen)
      for (int c = 0; c < set_.count(); ++c)
        if (colouring_.colour[c] == chosen) project(p, c);
  }

  int largest_colour() const {
    int largest = 0;
    for (int chosen = 0; chosen < colouring_.count; ++chosen)
      largest =
          std::max(largest, static_cast<int>(std::count(colouring_.colour.begin(), colouring_.colour.end(), chosen)));
    return largest;
  }
  int colours() const { return colouring_.count; }

 private:
  void project(Vec4<R>* p, int c) {
    Vector3<R> q[n], grad[n];
    R w[n];
    for (int j = 0; j < n; ++j) q[j] = p[set_.particles[c * n + j]].xyz(), w[j] = p[set_.particles[c * n + j]].w;
    const R C = Kind::evaluate(q, rest_[c], grad);
    R sum = w[0] * dot(grad[0], grad[0]);
    for (int j = 1; j < n; ++j) sum = sum + w[j] * dot(grad[j], grad[j]);
    if (!(sum > tiny<R>())) return;
    R dlambda = set_.compliance ? (-C - alpha_ * lambda_[c]) / (sum + alpha_) : -C * k_ / sum;
    if (Kind::inequality) dlambda = std::max(dlambda, set_.compliance ? -lambda_[c] : R(0));
    lambda_[c] = lambda_[c] + dlambda;
    for (int j = 0; j < n; ++j)
      if (w[j] > R(0)) p[set_.particles[c * n + j]].set(q[j] + grad[j] * (w[j] * dlambda));
  }

  const ConstraintSet& set_;
  Colouring colouring_;
  std::vector<R> rest_, lambda_;
  R k_, alpha_;
};

template <class Kind, class R, class Executor>
void expect_same_as_scalar(const Executor& executor, std::optional<double> compliance) {
  const RandomSet<Kind> random(kLanes<R> * 12 + 5, 21, compliance);
  const auto batches = make_batches<Executor, R>(executor, random.model, random.set);
  ASSERT_NE(batches, nullptr);
  ScalarSweep<Kind, R> sweep(random.model, random.set);
  ASSERT_GT(sweep.largest_colour(), 3 * kLanes<R>) << "whole packs, packs with pins, and a part of one";
  ASSERT_GT(sweep.colours(), 1);

  const std::vector<Vec4<R>> start = random.template moved<R>(22);
  Array<Executor, Vec4<R>> wide(start);
  std::vector<Vec4<R>> narrow = start;
  batches->start_substep();
  for (int iteration = 0; iteration < 4; ++iteration) {
    batches->project(wide.data());
    sweep(narrow.data());
  }
  for (std::size_t i = 0; i < narrow.size(); ++i)
    ASSERT_TRUE(same_bits(wide.data()[i], narrow[i])) << Kind::name << ", particle " << i;
  EXPECT_FALSE(std::equal(start.begin(), start.end(), narrow.begin(), same_bits<Vec4<R>>)) << "nothing moved";
}

TEST(Batches, ProjectInPacksBitForBitAsOneByOne) {
  for_each_constraint([]<class Kind>(Kind) {
    for (const std::optional<double> compliance : {std::optional<double>(), std::optional(1e-3)}) {
      expect_same_as_scalar<Kind, float>(Serial{}, compliance);
      expect_same_as_scalar<Kind, double>(Serial{}, compliance);
      expect_same_as_scalar<Kind, float>(OpenMP{3}, compliance);
    }
  });
}

TEST(Batches, ForgetLambdaWhenASubstepStarts) {
  for_each_constraint([]<class Kind>(Kind) {
    const RandomSet<Kind> random(50, 23, 0.01);
    const auto batches = make_batches<Serial, double>({}, random.model, random.set);
    const std::vector<Vec4<double>> start = random.template moved<double>(24);
    const auto project = [&](bool fresh) {
      if (fresh) batches->start_substep();
      Array<Serial, Vec4<double>> p(start);
      batches->project(p.data());
      return p.download();
    };
    const auto equal = [](const auto& a, const auto& b) {
      return std::equal(a.begin(), a.end(), b.begin(), same_bits<Vec4<double>>);
    };
    const auto first = project(true), remembered = project(false), again = project(true);
    EXPECT_FALSE(equal(first, remembered)) << Kind::name;
    EXPECT_TRUE(equal(first, again)) << Kind::name;
  });
}

TEST(Batches, StiffnessPerProjectionComposesToStiffness) {
  for (const double k : {0.0, 0.3, 1.0})
    for (const int n : {1, 10, 1000}) {
      const double per = stiffness_per_projection(k, n);
      EXPECT_NEAR(std::pow(1 - per, n), 1 - k, 1e-13);
      EXPECT_GE(per, 0);
      EXPECT_LE(per, 1);
    }
}

TEST(Batches, ResidualMeasuresTheStateAndNotThePadding) {
  Model model;
  ConstraintSet set{"distance", 2, 1, std::nullopt, 1, {}};
  // A chain of 20 particles a metre apart, then stretched: link c by (c + 1) / 1000 m.
  std::vector<Vec4<double>> p;
  double along = 0;
  for (int i = 0; i < 20; ++i) {
    model.x.push_back({double(i), 0, 0});
    model.w.push_back(i == 0 ? 0 : 1);
    if (i > 0) set.particles.insert(set.particles.end(), {i - 1, i}), along += 1 + i * 1e-3;
    p.push_back({along, 0, 0, model.w[i]});
  }
  const auto batches = make_batches<Serial, double>({}, model, set);
  const Residual residual = batches->residual(p.data(), p.data());
  EXPECT_EQ(residual.count, 19);
  EXPECT_EQ(residual.degenerate, 0);
  EXPECT_NEAR(residual.strain_max, 19e-3, 1e-12);
  EXPECT_NEAR(residual.C2, 1e-6 * 19 * 20 * 39 / 6, 1e-12);  // 1 + 4 + 9 + ... + 19^2
  EXPECT_NEAR(residual.strain2, residual.C2, 1e-15);
  EXPECT_EQ(batches->facts().constraints, 19);
  EXPECT_EQ(batches->facts().batch_sizes, (std::vector<int>{10, 9}));
}

TEST(Batches, ResidualCountsWhatHasNoDirection) {
  Model model;
  model.x = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  model.w = {1, 1, 0, 0};
  const ConstraintSet set{"distance", 2, 1, std::nullopt, 1, {0, 1, 2, 3}};
  const std::vector<Vec4<double>> p = {{5, 5, 5, 1}, {5, 5, 5, 1}, {7, 7, 7, 0}, {7, 7, 7, 0}};
  const auto batches = make_batches<Serial, double>({}, model, set);
  EXPECT_EQ(batches->residual(p.data(), p.data()).degenerate, 1) << "what is pinned would not move anyway";
}

TEST(Batches, AnInequalityThatHoldsHasNoResidual) {
  Model model;
  model.x = {{0, 0, 0}, {1, 0, 0}};
  model.w = {1, 1};
  const ConstraintSet set{"distance_limit", 2, 1, std::nullopt, 0.1, {0, 1}};
  const auto batches = make_batches<Serial, double>({}, model, set);
  std::vector<Vec4<double>> p = {{0, 0, 0, 1}, {0.5, 0, 0, 1}};
  EXPECT_EQ(batches->residual(p.data(), p.data()).C2, 0);
  p[1].x = 1.2;
  EXPECT_NEAR(batches->residual(p.data(), p.data()).C2, 0.01, 1e-12);
}

TEST(Batches, OfAnUnknownKindAreNotMade) {
  Model model;
  EXPECT_EQ((make_batches<Serial, float>({}, model, {"no such kind", 2, 1, std::nullopt, 1, {}})), nullptr);
}

}  // namespace
}  // namespace malha
