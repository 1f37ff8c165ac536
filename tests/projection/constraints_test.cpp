// SPDX-License-Identifier: Apache-2.0
// Properties of every kind of the registry: a new kind is tested without a line here.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernels/constraints/constraint_registry.h"
#include "tests/projection/one_constraint.h"

namespace malha {
namespace {

double& component(Vector3<double>& a, int axis) { return axis == 0 ? a.x : axis == 1 ? a.y : a.z; }

TEST(EveryConstraint, HasTheGradientOfItsFiniteDifferences) {
  for_each_constraint([]<class Kind>(Kind) {
    Random random(1);
    for (const Corners<Kind>& at : configurations<Kind>(500, 11)) {
      const Rest<Kind> rest = another_rest<Kind>(at, random);
      Vector3<double> grad[Kind::particles], unused[Kind::particles];
      evaluate<Kind>(at, rest, grad);
      for (int j = 0; j < Kind::particles; ++j)
        for (int axis = 0; axis < 3; ++axis) {
          // Truncation h^2 C''' / 6 and rounding eps / h are both some 1e-10 where particles are 0.3 and more apart.
          constexpr double h = 1e-5;
          Corners<Kind> above = at, below = at;
          component(above[j], axis) += h, component(below[j], axis) -= h;
          const double difference = evaluate<Kind>(above, rest, unused) - evaluate<Kind>(below, rest, unused);
          EXPECT_NEAR(component(grad[j], axis), difference / (2 * h), 2e-7) << Kind::name << ", particle " << j;
        }
    }
  });
}

TEST(EveryConstraint, HasAScaleOfItsPositionsAlone) {
  for_each_constraint([]<class Kind>(Kind) {
    for (const Corners<Kind>& at : configurations<Kind>(100, 22)) {
      Vector3<double> q[Kind::particles], grad[Kind::particles];
      std::copy(at.begin(), at.end(), q);
      Rest<Kind> rest = rest_of<Kind>(at, Kind::parameter.default_value);
      double scale = 0, with_another_rest = 0;
      Kind::evaluate(q, rest.data(), true, grad, scale);
      rest[0] += 0.1;
      Kind::evaluate(q, rest.data(), true, grad, with_another_rest);
      double squares = 0;
      for (const auto& g : grad) squares += dot(g, g);
      EXPECT_EQ(scale > 0, squares > 0) << Kind::name << ": without a scale there is no direction";
      EXPECT_EQ(scale, with_another_rest) << Kind::name;
    }
  });
}

TEST(EveryConstraint, IsInvariantUnderRigidMotion) {
  for_each_constraint([]<class Kind>(Kind) {
    for (const Corners<Kind>& at : configurations<Kind>(200, 12)) {
      Vector3<double> grad[Kind::particles];
      evaluate<Kind>(at, 0.5, grad);
      Vector3<double> force{0, 0, 0}, torque{0, 0, 0};
      for (int j = 0; j < Kind::particles; ++j) force = force + grad[j], torque = torque + cross(at[j], grad[j]);
      EXPECT_LT(norm(force), 1e-13) << Kind::name;
      EXPECT_LT(norm(torque), 1e-13) << Kind::name;
    }
  });
}

/// Moments of the displacements of one projection, and the sum of their sizes: about the positions at the start of the
/// substep, and about those before the projection.
struct GivenMomentum {
  Vector3<double> linear{0, 0, 0}, about_start{0, 0, 0}, about_now{0, 0, 0};
  double size = 0;
};
template <Update update, class Kind, class R>
GivenMomentum given_by_projection(OneConstraint<Kind, R> one, const std::array<double, Kind::particles>& w) {
  const OneConstraint<Kind, R> before = one;
  one.template project<update>(0.7, 0.3);
  GivenMomentum given;
  for (int j = 0; j < Kind::particles; ++j) {
    const Vector3<double> push = (to_double(one.way(j)) - to_double(before.way(j))) * (1 / w[j]);
    const Vector3<double> start = to_double(before.start(j));
    given.linear = given.linear + push, given.about_start = given.about_start + cross(start, push);
    given.about_now = given.about_now + cross(start + to_double(before.way(j)), push);
    given.size += norm(push);
  }
  return given;
}

/// Particles are at the start of a substep, or have moved since by less than the error; errors are small beside the
/// elements. (No hinge is flat, because a flat one has no direction in which it folds, so that the current one counts.)
template <class Kind, class R, Update update>
void expect_momentum_kept(double moved_before) {
  Random random(2);
  double moved = 0;
  for (int i = 0; i < 200; ++i) {
    const Corners<Kind> at = spread_out<Kind>(random);
    const auto w = unequal_masses<Kind>(random);
    Corners<Kind> others = at;  // so near that an inequality that allows a tenth more is violated
    for (auto& a : others) a = (a + random.in_cube(0.01)) * (Kind::inequality ? 0.88 : 1);
    OneConstraint<Kind, R> one(at, w, rest_of<Kind>(others, Kind::parameter.default_value));
    for (int j = 0; j < Kind::particles; ++j) one.move(j, random.in_cube(moved_before));
    const GivenMomentum given = given_by_projection<update>(one, w);
    moved += given.size;
    // Positions of the size of 1 are rounded by eps; masses up to 5 kg multiply that.
    const double tolerance = 30 * std::numeric_limits<R>::epsilon() * (1 + given.size);
    EXPECT_LT(norm(given.linear), tolerance) << Kind::name;
    EXPECT_LT(norm(given.about_start), tolerance) << Kind::name;
  }
  EXPECT_GT(moved, 0.1) << Kind::name;
}

TEST(EveryConstraint, KeepsLinearAndAngularMomentumOfFreeParticles) {
  for_each_constraint([]<class Kind>(Kind) {
    for (const double moved : {0.0, 0.001}) {  // m
      expect_momentum_kept<Kind, float, Update::Stiff>(moved);
      expect_momentum_kept<Kind, float, Update::Compliant>(moved);
      expect_momentum_kept<Kind, double, Update::Stiff>(moved);
      expect_momentum_kept<Kind, double, Update::Compliant>(moved);
    }
  });
}

/// The correction of an element that turns, or that exceeds the share of the start's gradient, goes along the current
/// gradient: it exerts no moment about the current positions.
TEST(EveryConstraint, KeepsMomentaAlsoOfWhatIsTornAndCrushed) {
  for_each_constraint([]<class Kind>(Kind) {
    Random random(14);
    int about_start = 0, about_now = 0;
    for (const Corners<Kind>& at : configurations<Kind>(200, 13)) {
      const auto w = unequal_masses<Kind>(random);
      OneConstraint<Kind, double> one(at, w, another_rest<Kind>(at, random));
      if (random() < 0) one.max_start_step = 1e-18;  // next to nothing goes along the gradient of the start
      for (int j = 0; j < Kind::particles; ++j) one.move(j, random.in_cube(0.1));
      const GivenMomentum given = given_by_projection<Update::Stiff>(one, w);
      if (given.size == 0) continue;  // a satisfied inequality
      const double tolerance = 30 * std::numeric_limits<double>::epsilon() * (1 + given.size);
      EXPECT_LT(norm(given.linear), tolerance) << Kind::name;
      const bool by_start = norm(given.about_start) < tolerance, by_now = norm(given.about_now) < tolerance;
      EXPECT_TRUE(by_start || by_now) << Kind::name;
      about_start += by_start, about_now += by_now;
    }
    EXPECT_GT(about_start, 0) << Kind::name;
    EXPECT_GT(about_now, 0) << Kind::name;
  });
}

TEST(EveryConstraint, LeavesPinnedParticlesWhereTheyAre) {
  for_each_constraint([]<class Kind>(Kind) {
    Random random(3);
    for (const Corners<Kind>& at : configurations<Kind>(50, 14))
      for (int pins = 1; pins < 1 << Kind::particles; ++pins) {
        auto w = unequal_masses<Kind>(random);
        for (int j = 0; j < Kind::particles; ++j)
          if (pins >> j & 1) w[j] = 0;
        OneConstraint<Kind, float> one(at, w, another_rest<Kind>(at, random));
        const OneConstraint<Kind, float> before = one;
        one.template project<Update::Stiff>(1, 0);
        for (int j = 0; j < Kind::particles; ++j)
          EXPECT_TRUE(w[j] > 0 || same_bits(one.way(j), before.way(j))) << Kind::name;
        for (int j = 0; j < Kind::particles; ++j)
          EXPECT_TRUE(std::isfinite(one.p(j).x + one.p(j).y + one.p(j).z)) << Kind::name;
      }
  });
}

TEST(EveryConstraint, ActsOnAViolatedAndLeavesASatisfiedOne) {
  for_each_constraint([]<class Kind>(Kind) {
    Random random(4);
    int satisfied = 0, violated = 0;
    for (const Corners<Kind>& at : configurations<Kind>(200, 15)) {
      const auto w = unequal_masses<Kind>(random);
      const Rest<Kind> rest = another_rest<Kind>(at, random);
      OneConstraint<Kind, double> stiff(at, w, rest), compliant(at, w, rest);
      const OneConstraint<Kind, double> before = stiff;
      stiff.template project<Update::Stiff>(1, 0);
      compliant.template project<Update::Compliant>(0, 1e-3);
      const bool holds = Kind::inequality && before.C() >= 0;
      ++(holds ? satisfied : violated);
      Vector3<double> grad[Kind::particles];
      evaluate<Kind>(at, rest, grad);
      for (int j = 0; j < Kind::particles; ++j) {
        // An attachment to an edge or a corner of a triangle leaves its other corners alone, up to rounding.
        if (dot(grad[j], grad[j]) > 0 && dot(grad[j], grad[j]) < 1e-20) continue;
        const bool stays = holds || dot(grad[j], grad[j]) == 0;
        EXPECT_EQ(same_bits(stiff.p(j), before.p(j)), stays) << Kind::name;
        EXPECT_EQ(same_bits(compliant.p(j), before.p(j)), stays) << Kind::name;
      }
    }
    EXPECT_GT(violated, 20) << Kind::name;
    EXPECT_GT(satisfied, Kind::inequality ? 20 : -1) << Kind::name;
  });
}

TEST(EveryConstraint, IsSatisfiedAfterAFewStiffProjections) {
  for_each_constraint([]<class Kind>(Kind) {
    if (multipliers<Kind>() > 1) return;  // its balance is tested in tests/constraints/neo_hookean_test.cpp
    Random random(5);
    for (const Corners<Kind>& at : configurations<Kind>(100, 16)) {
      // The start is near the rest state, where Newton's method converges whatever the kind.
      Corners<Kind> near = at;
      for (auto& a : near) a = a + random.in_cube(0.02);
      const Rest<Kind> rest = rest_of<Kind>(at, Kind::parameter.default_value);
      OneConstraint<Kind, double> one(near, unequal_masses<Kind>(random), rest);
      for (int k = 0; k < 20; ++k) one.template project<Update::Stiff>(1, 0);
      const double violation = Kind::inequality ? std::min(one.C(), 0.0) : one.C();
      EXPECT_NEAR(violation, 0, 1e-13) << Kind::name;
    }
  });
}

TEST(EveryConstraint, WithComplianceComesToTheBalanceOfItsForce) {
  for_each_constraint([]<class Kind>(Kind) {
    if (multipliers<Kind>() > 1) return;  // its balance is tested in tests/constraints/neo_hookean_test.cpp
    Random random(6);
    for (const double alpha : {1e-4, 0.1, 10.0})
      for (const Corners<Kind>& at : configurations<Kind>(50, 17)) {
        Corners<Kind> near = at;
        for (auto& a : near) a = a + random.in_cube(0.02);
        const Rest<Kind> rest = rest_of<Kind>(at, Kind::parameter.default_value);
        OneConstraint<Kind, double> one(near, unequal_masses<Kind>(random), rest);
        for (int k = 0; k < 50; ++k) one.template project<Update::Compliant>(0, alpha);
        if (Kind::inequality && one.C() > 0) {
          EXPECT_EQ(one.lambda[0], 0) << Kind::name;
        } else {
          EXPECT_NEAR(one.C(), -alpha * one.lambda[0], 1e-12) << Kind::name << ", alpha~ " << alpha;
        }
      }
  });
}

TEST(EveryConstraint, WithoutComplianceIsTheStiffOneOfStiffnessOne) {
  for_each_constraint([]<class Kind>(Kind) {
    Random random(7);
    for (const Corners<Kind>& at : configurations<Kind>(200, 18)) {
      const auto w = unequal_masses<Kind>(random);
      const Rest<Kind> rest = another_rest<Kind>(at, random);
      OneConstraint<Kind, double> stiff(at, w, rest), compliant(at, w, rest);
      stiff.template project<Update::Stiff>(1, 0);
      compliant.template project<Update::Compliant>(0, 0);
      for (int j = 0; j < Kind::particles; ++j)  // displacements of up to some 10 m, rounded
        EXPECT_LT(norm(stiff.p(j) - compliant.p(j)), 1e-14) << Kind::name;
    }
  });
}

TEST(EveryInequality, TakesBackWhatItPushedTooFarButNeverPulls) {
  for_each_constraint([]<class Kind>(Kind) {
    if constexpr (Kind::inequality) {
      Random random(8);
      int taken_back = 0;
      for (const Corners<Kind>& at : configurations<Kind>(200, 19)) {
        const Rest<Kind> rest = another_rest<Kind>(at, random);
        OneConstraint<Kind, double> one(at, unequal_masses<Kind>(random), rest);
        if (one.C() >= 0) continue;
        one.template project<Update::Compliant>(0, 0);
        const double pushed = one.lambda[0];
        EXPECT_GT(pushed, 0) << Kind::name;
        // Other constraints have moved its particles far into what the inequality allows: the push is undone, and no
        // pull replaces it.
        for (int j = 0; j < Kind::particles; ++j) one.move(j, one.way(j) * 0.5);
        if (one.C() <= 0) continue;
        one.template project<Update::Compliant>(0, 0);
        EXPECT_GE(one.lambda[0], 0) << Kind::name;
        EXPECT_LT(one.lambda[0], pushed) << Kind::name;
        ++taken_back;
      }
      EXPECT_GT(taken_back, 10) << Kind::name;
    }
  });
}

TEST(EveryConstraint, LeavesOneMinusKOfASmallErrorAfterNProjections) {
  for_each_constraint([]<class Kind>(Kind) {
    if (!Kind::strength.accepts_stiffness) return;  // the kind has no stiffness k
    Random random(9);
    for (const Corners<Kind>& at : configurations<Kind>(20, 20)) {
      const auto w = unequal_masses<Kind>(random);
      const Rest<Kind> rest = another_rest<Kind>(at, random);
      OneConstraint<Kind, double> met(at, w, rest);
      for (int i = 0; i < 50; ++i) met.template project<Update::Stiff>(1, 0), met.arrive();
      if (std::abs(met.C()) > 1e-12) continue;  // a satisfied inequality, or Newton's method did not converge
      for (const double k : {0.1, 0.5, 0.9})
        for (const int n : {1, 4, 25}) {
          OneConstraint<Kind, double> one = met;
          // The error is so small that every kind is linear in it: for angles a millionth.
          while (std::abs(one.C()) < 1e-8 || (Kind::inequality && one.C() > 0)) {
            one = met;
            for (int j = 0; j < Kind::particles; ++j) one.move(j, random.in_cube(1e-7));
          }
          const double error = one.C();
          for (int i = 0; i < n; ++i) one.template project<Update::Stiff>(1 - std::pow(1 - k, 1.0 / n), 0);
          EXPECT_NEAR(one.C() / error, 1 - k, 1e-4) << Kind::name << ", k = " << k << ", n = " << n;
        }
    }
  });
}

TEST(Distance, MeasuresHowMuchTooFarApartItsParticlesAre) {
  Vector3<double> grad[2];
  EXPECT_NEAR(evaluate<Distance>({{{1, 2, 3}, {3, 5, 9}}}, 5, grad), 2, 1e-15);  // |(2, 3, 6)| = 7
  EXPECT_NEAR(grad[0].x, -2 / 7.0, 1e-15);
  EXPECT_NEAR(grad[0].y, -3 / 7.0, 1e-15);
  EXPECT_NEAR(grad[0].z, -6 / 7.0, 1e-15);
  EXPECT_NEAR(evaluate<DistanceLimit>({{{1, 2, 3}, {3, 5, 9}}}, 5, grad), -2, 1e-15);
  EXPECT_NEAR(grad[0].x, 2 / 7.0, 1e-15);
}

TEST(Distance, LeavesOneMinusKOfAnyErrorAfterNProjections) {
  for (const double k : {0.0, 0.1, 0.5, 0.9, 1.0})
    for (const int n : {1, 2, 10, 100}) {
      OneConstraint<Distance, double> one({{{0, 0, 0}, {1.5, 0, 0}}}, {1, 0.25}, 1);
      for (int i = 0; i < n; ++i) one.project<Update::Stiff>(1 - std::pow(1 - k, 1.0 / n), 0);
      EXPECT_NEAR(one.C(), 0.5 * (1 - k), 1e-14) << "k = " << k << ", n = " << n;
    }
}

TEST(Distance, MovesTheLighterParticleFurther) {
  OneConstraint<Distance, double> one({{{0, 0, 0}, {3, 0, 0}}}, {1, 2}, 1);
  one.project<Update::Stiff>(1, 0);
  EXPECT_NEAR(one.p(0).x, 2.0 / 3, 1e-15);
  EXPECT_NEAR(one.p(1).x, 3 - 4.0 / 3, 1e-15);
}

TEST(Distance, GoesAlongItsLineWhereTheSubstepBeganByTheShareThatIsWithinItsBound) {
  // The particle was moved by 0.75 m across its line of 1 m, so that it is 1.25 m from the other: along the old line,
  // of which the new one has 0.8, each has to move by error / 2 / 0.8. If the correction exceeds the bound, a quarter
  // of that 1 m, a share goes along each direction: to first order the lengths are the same whatever the share.
  for (const double error : {0.1, 0.39, 0.41, 0.6, -0.39, -0.41, -0.6}) {
    OneConstraint<Distance, double> one({{{0, 0, 0}, {1, 0, 0}}}, {1, 1}, 1.25 - error);
    one.max_start_step = 0.25;
    one.move(1, {0, 0.75, 0});
    one.project<Update::Stiff>(1, 0);
    const Vector3<double> gone = one.way(1) - Vector3<double>{0, 0.75, 0};
    const double share = std::min(1.0, 0.25 / (std::abs(error) / 2 / 0.8));
    EXPECT_NEAR(gone.x * 0.8 + gone.y * 0.6, -error / 2, 1e-15) << error;
    EXPECT_NEAR(gone.y / gone.x, 0.75 * (1 - share), 1e-14) << error;
  }
}

TEST(DistanceLimit, HoldsBetweenNothingAndItsLimit) {
  const Vector3<double> X[2] = {{0, 0, 0}, {2, 0, 0}};
  double rest[1];
  DistanceLimit::rest(X, 0.1, rest);
  const double longest = rest[0];
  EXPECT_NEAR(longest, 2.2, 1e-15);
  for (const double length : {0.5, 2.0, 2.19}) {
    OneConstraint<DistanceLimit, double> one({{{0, 0, 0}, {length, 0, 0}}}, {1, 1}, longest);
    one.project<Update::Stiff>(1, 0);
    EXPECT_EQ(one.p(1).x, length);
  }
  OneConstraint<DistanceLimit, double> one({{{0, 0, 0}, {3, 0, 0}}}, {1, 1}, longest);
  one.project<Update::Stiff>(1, 0);
  EXPECT_NEAR(one.p(1).x - one.p(0).x, 2.2, 1e-15);
}

TEST(Bending, MeasuresTheSignedAngleOfTheFold) {
  Random random(10);
  for (double angle = -3.1; angle < 3.14; angle += 0.05) {
    Vector3<double> grad[4];
    EXPECT_NEAR(std::abs(evaluate<Bending>(folded_hinge(random, angle), 0, grad)), std::abs(angle), 1e-12);
    const double one_side = evaluate<Bending>(folded_hinge(random, angle), 0, grad);
    const double other_side = evaluate<Bending>(folded_hinge(random, -angle), 0, grad);
    EXPECT_NEAR(one_side, -other_side, 1e-12);
  }
}

TEST(Bending, GoesTheShortWayRoundAHalfTurn) {
  Random random(11);
  Vector3<double> grad[4];
  const double just_below = evaluate<Bending>(folded_hinge(random, 3.1), 0, grad);
  const double across = evaluate<Bending>(folded_hinge(random, -3.1), just_below, grad);
  EXPECT_NEAR(std::abs(across), 2 * 3.14159265358979323846 - 6.2, 1e-12);
}

}  // namespace
}  // namespace malha
