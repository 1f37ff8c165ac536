// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/forces/body_momenta.h"
#include "tests/mesh/point_list.h"
#include "tests/numbers.h"

namespace malha {
namespace {

using V = Vector3<double>;

/// Particles in motion; w = 0 marks pins.
template <class R>
struct Bodies {
  PointList<R> x, v;
  std::vector<R> w;

  void add(const V& at, const V& velocity, double inverse_mass) {
    x.push_back(at), v.push_back(velocity), w.push_back(R(inverse_mass));
  }
  void add_random(int count, unsigned seed, const V& centre = {0, 0, 0}) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      const V at = centre + random.in_cube(), velocity = random.in_cube(3) + V{1, -2, 0.5};
      add(at, velocity, random(0.2, 5));
    }
  }
  int count() const { return x.size(); }
  Particles<R> all() { return {count(), x.points(), v.points(), {}, w.data()}; }
  void damp_all(double k) { damp_part(Serial{}, 0, count(), k); }
  template <class Executor>
  void damp_part(const Executor& executor, int first, int n, double k) {
    Damping<Executor, R>(executor, {{first, n, k}}, 1).damp(all());
  }

  V centre() const {
    V sum{0, 0, 0};
    double mass = 0;
    for (int i = 0; i < count(); ++i)
      if (w[i] > 0) sum = sum + to_double(x[i]) * (1 / double(w[i])), mass += 1 / double(w[i]);
    return sum * (1 / mass);
  }
  V momentum() const {
    V sum{0, 0, 0};
    for (int i = 0; i < count(); ++i)
      if (w[i] > 0) sum = sum + to_double(v[i]) * (1 / double(w[i]));
    return sum;
  }
  V spin(const V& about) const {
    V sum{0, 0, 0};
    for (int i = 0; i < count(); ++i)
      if (w[i] > 0) sum = sum + cross(to_double(x[i]) - about, to_double(v[i]) * (1 / double(w[i])));
    return sum;
  }
  double kinetic() const {
    double sum = 0;
    for (int i = 0; i < count(); ++i)
      if (w[i] > 0) sum += dot(to_double(v[i]), to_double(v[i])) / double(w[i]) / 2;
    return sum;
  }
  /// The largest rate of change of a distance between two particles, m/s.
  double fastest_strain() const {
    double fastest = 0;
    for (int i = 0; i < count(); ++i)
      for (int j = 0; j < i; ++j) {
        const V d = to_double(x[i]) - to_double(x[j]);
        const double speed = dot(d, to_double(v[i]) - to_double(v[j])) / norm(d);
        fastest = std::max(fastest, std::abs(speed));
      }
    return fastest;
  }
  bool finite() const {
    for (int i = 0; i < count(); ++i)
      if (!std::isfinite(v[i].x + v[i].y + v[i].z)) return false;
    return true;
  }
};

template <class R>
struct DampOf : testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(DampOf, Reals);

TYPED_TEST(DampOf, KeepsLinearAndAngularMomentum) {
  using R = TypeParam;
  for (const double k : {0.01, 0.5, 1.0}) {
    Bodies<R> bodies;
    bodies.add_random(300, 1);
    const V linear = bodies.momentum(), centre = bodies.centre(), angular = bodies.spin(centre);
    const double kinetic = bodies.kinetic();
    bodies.damp_all(k);
    // 300 velocities of some 5 m/s, each rounded, of masses up to 5 kg: by chance they add up as their root.
    // The sums are in double, and of 300 such numbers whatever R is.
    const double rounding = 5 * 5 * std::sqrt(300.0) * std::numeric_limits<R>::epsilon() + 5 * 5 * 300 * 4e-16;
    EXPECT_LT(norm(bodies.momentum() - linear), rounding);
    EXPECT_LT(norm(bodies.spin(centre) - angular), 2 * rounding);
    EXPECT_LT(bodies.kinetic(), kinetic) << "and takes energy";
  }
}

TYPED_TEST(DampOf, WithKOfOneLeavesARigidMotion) {
  using R = TypeParam;
  Bodies<R> bodies;
  bodies.add_random(60, 2);
  EXPECT_GT(bodies.fastest_strain(), 1);
  bodies.damp_all(1);
  EXPECT_LT(bodies.fastest_strain(), 50 * std::numeric_limits<R>::epsilon());
  EXPECT_GT(norm(bodies.spin(bodies.centre())), 0.1) << "that still turns";
}

TYPED_TEST(DampOf, TakesTheFractionKOfTheRest) {
  using R = TypeParam;
  Bodies<R> bodies, rigid;
  bodies.add_random(60, 3);
  rigid = bodies;
  const Bodies<R> before = bodies;
  bodies.damp_all(0.3);
  rigid.damp_all(1);
  for (int i = 0; i < 60; ++i) {
    const V from = to_double(before.v[i]), to = to_double(rigid.v[i]);
    EXPECT_LT(norm(to_double(bodies.v[i]) - (from + (to - from) * 0.3)), 20 * std::numeric_limits<R>::epsilon());
  }
}

TYPED_TEST(DampOf, LeavesARigidlyTurningBodyAlone) {
  using R = TypeParam;
  Bodies<R> bodies;
  Random random(4);
  const V omega{3, -2, 1}, velocity{5, 6, 7};
  for (int i = 0; i < 100; ++i) {
    const V at = random.in_cube();
    bodies.add(at, velocity + cross(omega, at), random(0.2, 5));
  }
  const Bodies<R> before = bodies;
  for (int times = 0; times < 10; ++times) bodies.damp_all(1);
  for (int i = 0; i < 100; ++i)  // ten times a few roundings of a velocity of some 15 m/s
    EXPECT_LT(norm(to_double(bodies.v[i]) - to_double(before.v[i])), 10 * 3 * 15 * std::numeric_limits<R>::epsilon());
}

/// A rod that turns about itself turns rigidly, though it has a thousandth of the inertia there.
TYPED_TEST(DampOf, LeavesARodThatTurnsAboutItselfAlone) {
  using R = TypeParam;
  Bodies<R> rod;
  for (int i = 0; i < 80; ++i) {
    const V at{i / 80.0 - 0.5, 0.01 * (i % 4 < 2 ? -1 : 1), 0.01 * (i % 2 == 0 ? -1 : 1)};
    rod.add(at, cross(V{7, 0, 0}, at), 1);
  }
  const Bodies<R> before = rod;
  rod.damp_all(1);
  for (int i = 0; i < 80; ++i)  // 0.1 m/s, and the roundings of an inverse of the condition 1,000
    EXPECT_LT(norm(to_double(rod.v[i]) - to_double(before.v[i])), 0.1 * 1000 * std::numeric_limits<R>::epsilon());
}

TYPED_TEST(DampOf, NeitherCountsNorMovesPinnedParticles) {
  using R = TypeParam;
  Bodies<R> with, without;
  with.add_random(50, 5), without.add_random(50, 5);
  with.add({100, 100, 100}, {7, 7, 7}, 0);
  with.damp_all(0.5), without.damp_all(0.5);
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(same_bits(with.v[i], without.v[i]));
  EXPECT_EQ(with.v[50].x, R(7));
}

TYPED_TEST(DampOf, TouchesItsOwnIslandOnly) {
  using R = TypeParam;
  Bodies<R> bodies;
  bodies.add_random(30, 6), bodies.add_random(40, 7), bodies.add_random(30, 8);
  const Bodies<R> before = bodies;
  bodies.damp_part(Serial{}, 30, 40, 1.0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(same_bits(bodies.v[i], before.v[i]), i < 30 || i >= 70) << i;
}

/// Degenerate bodies: results are finite, momenta are conserved (but for `spin_lost`), and energy never grows.
template <class R>
void expect_tame(Bodies<R> bodies, const char* what, double spin_lost = 0) {
  const V linear = bodies.momentum(), centre = bodies.centre(), angular = bodies.spin(centre);
  const double kinetic = bodies.kinetic();
  for (int times = 0; times < 5; ++times) bodies.damp_all(0.5);
  EXPECT_TRUE(bodies.finite()) << what;
  const double rounding = 200 * std::numeric_limits<R>::epsilon();
  EXPECT_LT(norm(bodies.momentum() - linear), rounding) << what;
  EXPECT_LT(norm(bodies.spin(centre) - angular), rounding + spin_lost) << what;
  EXPECT_LE(bodies.kinetic(), kinetic * (1 + rounding)) << what;
}

TYPED_TEST(DampOf, StaysFiniteWithoutInertiaAboutSomeAxis) {
  using R = TypeParam;
  Random random(9);
  Bodies<R> line, slanted, place, two, one, none, almost;
  for (int i = 0; i < 20; ++i) {
    const double t = random();
    line.add({t, 0, 0}, random.in_cube(), 1);
    slanted.add(V{0.3, -0.5, 0.7} * t + V{1, 2, 3}, random.in_cube(), 1);
    place.add({1, 2, 3}, random.in_cube(), 1);
    almost.add({t, 1e-7 * random(), 0}, {0, 0, random()}, 1);
    none.add({t, 0, 0}, {0, 0, 0}, 0);
  }
  two.add({0, 0, 0}, {0, 1, 0}, 1), two.add({1, 0, 0}, {0, -1, 0}, 0.5);
  one.add({1, 2, 3}, {4, 5, 6}, 1);
  expect_tame(line, "on a line");
  expect_tame(slanted, "on a slanted line");
  expect_tame(place, "in one place");
  expect_tame(two, "two particles");
  expect_tame(one, "one particle");
  // The body is so thin that it counts as a line: its spin about itself, 20 particles at 1e-7 m and 1 m/s, does not
  // count as rigid.
  expect_tame(almost, "on a line but for rounding", 20 * 1e-7);
  none.damp_all(1);
  EXPECT_TRUE(none.finite()) << "all pinned";
}

TYPED_TEST(DampOf, LeavesTwoParticlesTurningAboutEachOther) {
  using R = TypeParam;
  Bodies<R> two;
  two.add({-1, 0, 0}, {0, -2, 0}, 1), two.add({1, 0, 0}, {0, 2, 0}, 1);
  two.damp_all(1);
  EXPECT_NEAR(two.v[1].y, 2, 1e-6);
  two.v.set(0, two.v[0] + Vector3<R>{-1, 0, 0}), two.v.set(1, two.v[1] + Vector3<R>{1, 0, 0});  // flying apart
  two.damp_all(1);
  EXPECT_NEAR(two.v[1].x, 0, 1e-6);
  EXPECT_NEAR(two.v[1].y, 2, 1e-6);
}

TEST(Damp, GivesTheSameBitsOnEveryExecutor) {
  Bodies<float> serial;
  serial.add_random(20000, 10, {10, 20, 30});
  const Bodies<float> start = serial;
  serial.damp_all(0.3);
  for (const int threads : {1, 2, 3, 8}) {
    Bodies<float> parallel = start;
    parallel.damp_part(OpenMP{threads}, 0, 20000, 0.3);
    for (int i = 0; i < 20000; ++i) ASSERT_TRUE(same_bits(parallel.v[i], serial.v[i])) << threads << " threads";
  }
}

}  // namespace
}  // namespace malha
