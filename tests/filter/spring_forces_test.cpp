// SPDX-License-Identifier: Apache-2.0
// Forces of springs: the gradient of their energy, equal and opposite at their ends, and finite where they have no
// direction.
#include "host/filter/spring_forces.h"

#include <gtest/gtest.h>

#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

constexpr double kForceStep = 0.01;

/// The springs of a scene's model with particles at random positions and velocities.
template <class R>
class SpringsAt {
 public:
  SpringsAt(const Scene& scene, bool weighs, unsigned seed = 1) : model(build_model(scene)) {
    Random random(seed);
    for (int i = 0; i < model.count(); ++i) {
      const Vector3<double> d = random.in_cube(0.3), u = random.in_cube(2);
      const bool moves = model.w[i] > 0;
      x.push_back({model.x[i][0] + moves * d.x, model.x[i][1] + moves * d.y, model.x[i][2] + moves * d.z});
      v.push_back({moves * u.x, moves * u.y, moves * u.z});
      filtered_mass.push_back(weighs && moves ? 1 / model.w[i] : 0);
    }
  }

  /// The forces on movable particles; zero for the others.
  std::vector<Vec3> explicit_forces() const {
    return sum([&](const auto& forces, const Particles<R>& all, const Points<R>& f) {
      forces.sum_explicit(all, kForceStep, f);
    });
  }
  std::vector<Vec3> missing_forces(const std::vector<Vec3>& a) const {
    const PointArray<Serial, R> acceleration(a);
    std::vector<R> mass(model.w.size() + kSpringPack, R(0));
    for (std::size_t i = 0; i < model.w.size(); ++i) mass[i] = model.w[i] > 0 ? R(1 / model.w[i]) : R(0);
    return sum([&](const auto& forces, const Particles<R>& all, const Points<R>& f) {
      forces.sum_missing(all, kForceStep, acceleration.points(), mass.data(), f);
    });
  }

  double energy(const std::vector<Vec3>& at) const {
    double sum = 0;
    for (const SpringSet& set : model.springs)
      for (std::size_t s = 0; s < set.ends.size(); ++s) {
        const double stretch = length(at[set.ends[s][0]] - at[set.ends[s][1]]) - set.rest[s];
        sum += set.stiffness[s] * stretch * stretch / 2;
      }
    for (const FoldReference& fold : folds_of(model)) sum += fold.energy(at);
    return sum;
  }
  /// -dE/dx of one coordinate, by central differences.
  double pull(std::vector<Vec3> at, int i, int k) const {
    const double here = at[i][k], h = 1e-5;
    at[i][k] = here + h;
    const double above = energy(at);
    at[i][k] = here - h;
    return (energy(at) - above) / (2 * h);
  }

  Model model;
  std::vector<Vec3> x, v;
  std::vector<double> filtered_mass;

 private:
  template <class Sum>
  std::vector<Vec3> sum(const Sum& sum) const {
    const SpringForces<Serial, R> forces(Serial{widest_instructions()}, 1, model, filtered_mass);
    const PointArray<Serial, R> at(x), speed(v), force(x.size());
    std::vector<R> w(model.w.begin(), model.w.end());
    w.resize(w.size() + kSpringPack);
    sum(forces, Particles<R>{model.count(), at.points(), speed.points(), {}, w.data()}, force.points());
    std::vector<Vec3> found = force.download();
    for (int i = 0; i < model.count(); ++i)
      if (model.w[i] == 0) found[i] = {0, 0, 0};
    return found;
  }
};

/// Sheets with every kind of spring, whose numbers fill packs completely and partly, pinned and free.
std::vector<Scene> sprung_scenes(const TemporaryFolder& folder) {
  BodySpec other = sprung_sheet(4);
  other.name = "other";
  return {desbrun_scene({sprung_sheet(6, {RowPin{}}), other}, 80), desbrun_scene({sprung_chain(16, true)}, 80),
          desbrun_scene({sprung_chain(1, false)}, 80), desbrun_scene({star(folder, 40)}, 80)};
}

TEST(SpringForces, AreTheGradientOfTheElasticEnergyWithViscosityAndWeight) {
  const TemporaryFolder folder;
  for (const Scene& scene : sprung_scenes(folder))
    for (const bool weighs : {false, true}) {
      const SpringsAt<double> springs(scene, weighs);
      const std::vector<Vec3> found = springs.explicit_forces();
      std::vector<Vec3> expected(found.size(), Vec3{0, 0, 0});
      for (const SpringSet& set : springs.model.springs)  // k dt (v_j - v_i)
        for (std::size_t s = 0; s < set.ends.size(); ++s)
          for (const int e : {0, 1})
            for (int k = 0; k < 3; ++k)
              expected[set.ends[s][e]][k] +=
                  set.stiffness[s] * kForceStep * (springs.v[set.ends[s][1 - e]][k] - springs.v[set.ends[s][e]][k]);
      for (const FoldReference& fold : folds_of(springs.model)) {  // -dt c f(v) / alpha
        const Vec3 f = fold.fold(springs.v);
        for (int j = 0; j < 4; ++j)
          for (int k = 0; k < 3; ++k) expected[fold.of[j]][k] -= fold.stiffness * kForceStep * fold.weight[j] * f[k];
      }
      for (int i = 0; i < springs.model.count(); ++i)
        for (int k = 0; k < 3; ++k) {
          if (springs.model.w[i] == 0) continue;
          expected[i][k] += springs.pull(springs.x, i, k) + springs.filtered_mass[i] * scene.gravity[k];
          // h^2 / 6 times third derivatives of up to 80 / 0.01^2, for springs shortened to a centimetre.
          ASSERT_NEAR(found[i][k], expected[i][k], 1e-4) << i << ", " << k;
        }
    }
}

TEST(SpringForces, StillMissingAreThoseOfBackwardEuler) {
  const TemporaryFolder folder;
  for (const Scene& scene : sprung_scenes(folder))
    for (const bool weighs : {false, true}) {
      const SpringsAt<double> springs(scene, weighs);
      Random random(9);
      std::vector<Vec3> a, p = springs.x;
      for (int i = 0; i < springs.model.count(); ++i) {
        const Vector3<double> d = random.in_cube(100);
        const bool moves = springs.model.w[i] > 0;
        a.push_back({moves * d.x, moves * d.y, moves * d.z});
        for (int k = 0; k < 3; ++k) {
          const double g = moves && !weighs ? scene.gravity[k] : 0;
          p[i][k] += kForceStep * (springs.v[i][k] + kForceStep * (a[i][k] + g));
        }
      }
      const std::vector<Vec3> found = springs.missing_forces(a);
      for (int i = 0; i < springs.model.count(); ++i)
        for (int k = 0; k < 3; ++k) {
          if (springs.model.w[i] == 0) continue;
          const double m = 1 / springs.model.w[i];
          ASSERT_NEAR(found[i][k], springs.pull(p, i, k) + springs.filtered_mass[i] * scene.gravity[k] - m * a[i][k],
                      1e-4);
        }
    }
}

template <class R>
void expect_opposite() {
  for (unsigned seed = 1; seed < 20; ++seed) {
    const SpringsAt<R> springs(desbrun_scene({sprung_chain(2, true)}, 1e3), false, seed);
    const std::vector<Vec3> explicit_ones = springs.explicit_forces();
    const std::vector<Vec3> missing = springs.missing_forces({{0, 0, 0}, {0, 0, 0}});
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(explicit_ones[0][k], -explicit_ones[1][k]);
      ASSERT_EQ(missing[0][k], -missing[1][k]);
      ASSERT_NE(missing[0][k], 0);
    }
  }
}
TEST(SpringForces, AtTheTwoEndsAreOppositeToTheBit) {
  expect_opposite<float>();
  expect_opposite<double>();
}

TEST(SpringForces, InFloatFollowThoseInDouble) {
  const TemporaryFolder folder;
  for (const Scene& scene : sprung_scenes(folder)) {
    const std::vector<Vec3> exact = SpringsAt<double>(scene, true).explicit_forces();
    const std::vector<Vec3> single = SpringsAt<float>(scene, true).explicit_forces();
    // Up to 40 springs of 80 N/m; positions of up to 1 m, each to 6e-8 of it.
    for (std::size_t i = 0; i < exact.size(); ++i) ASSERT_LT(length(single[i] - exact[i]), 40 * 80 * 2e-7) << i;
  }
}

TEST(SpringForces, OfCoincidentEndsAreZeroAndSpringsOfNoLengthPullTogether) {
  SpringsAt<double> springs(desbrun_scene({sprung_chain(3, true)}, 1e3), false);
  springs.v.assign(3, {1, 2, 3});
  springs.x.assign(3, {0.5, 0.5, 0.5});
  for (const Vec3& f : springs.explicit_forces()) EXPECT_EQ(length(f), 0);
  for (const Vec3& f : springs.missing_forces({3, {0, 0, 0}})) EXPECT_EQ(length(f), 0);

  BodySpec chain = sprung_chain(2, true);
  chain.constraints[0].parameter = 1e-12;  // a rest length of nothing beside rounding: linear springs
  const SpringsAt<double> linear(desbrun_scene({chain}, 1e3), false);
  const Vec3 d = linear.x[0] - linear.x[1];
  const std::vector<Vec3> missing = linear.missing_forces({2, {0, 0, 0}});
  SpringsAt<double> still = linear;
  still.v.assign(2, {0, 0, 0});
  const std::vector<Vec3> pull = still.explicit_forces();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(pull[0][k], -1e3 * d[k], 1e-9);
    EXPECT_NEAR(missing[0][k], -1e3 * (d[k] + kForceStep * (linear.v[0][k] - linear.v[1][k])), 1e-9);
  }
}

}  // namespace
}  // namespace malha
