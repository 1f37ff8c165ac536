// SPDX-License-Identifier: Apache-2.0
// Contact of particles with meshes that deform: nothing passes, at any speed, by a winding number of the test's own.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <tuple>

#include "host/environment/deforming_collider.h"
#include "host/mesh/generate.h"
#include "kernels/forces/integrate.h"
#include "tests/mesh/point_list.h"
#include "tests/numbers.h"
#include "tests/self_collision/brute_force.h"

namespace malha {
namespace {

using Deformation = std::function<Vec3(const Vec3&, double)>;

/// Particles without constraints in contact with one deforming mesh, whose vertices follow a function of time.
template <class R>
class DeformingBench {
 public:
  DeformingBench(const EnvironmentSpec& spec, double h, Deformation deformation, const std::vector<Point>& x,
                 const std::vector<Point>& v)
      : h_(h), deformation_(std::move(deformation)), model_(model_of(spec, h, x)), collider_(Serial{}, model_) {
    start_ = model_.environment[0].mesh.points;
    for (std::size_t i = 0; i < x.size(); ++i) {
      x_.push_back(x[i]), v_.push_back(v[i]);
      low_.push_back(x[i] - to_double(x_[static_cast<int>(i)]));
    }
    d_ = PointList<R>(x.size()), w_.assign(x.size(), R(1));
  }

  /// A substep. `kick`: changes predicted positions, as constraints do.
  void substep(const Point& gravity = {0, 0, 0}, const std::function<void(int, Vector3<R>&)>& kick = {}) {
    const Particles<R> all = particles();
    const double time = substeps_ * h_;
    model_.environment[0].set = {shape_at(time), shape_at(time + h_), time, time + h_};
    parallel_for(Serial{}, all.count, Predict<R>{all, R(h_), {R(gravity.x), R(gravity.y), R(gravity.z)}});
    collider_.set_poses(time, time + h_);
    collider_.detect_contacts(all);
    if (kick)
      for (int i = 0; i < all.count; ++i) {
        Vector3<R> d = all.p.d[i];
        kick(i, d), all.p.d.set(i, d);
      }
    collider_.solve_contacts(all);
    collider_.clamp_tunnelling(all);
    parallel_reduce<FirstIndex>(Serial{}, all.count, UpdateState<R>{all, R(h_), R(1 / h_)});
    collider_.restitute(all, 2 * h_ * norm(gravity), h_);
    if (collider_.bounces()) {
      collider_.clamp_restitution(all);
      parallel_for(Serial{}, all.count, AdvanceAll<R>{all.p});
    }
    ++substeps_;
  }

  std::vector<Vec3> shape_at(double time) const {
    std::vector<Vec3> points;
    for (const Vec3& x : start_) points.push_back(deformation_(x, time));
    return points;
  }
  /// The surface at the present time.
  BruteForce surface() const {
    Mesh mesh = model_.environment[0].mesh;
    mesh.points = shape_at(substeps_ * h_);
    return BruteForce(mesh);
  }
  Particles<R> particles() {
    return {x_.size(), x_.points(), v_.points(), {x_.points(), d_.points(), low_.points()}, w_.data()};
  }
  int count() const { return x_.size(); }
  Point x(int i) const { return to_double(x_[i]) + to_double(low_[i]); }
  Point v(int i) const { return to_double(v_[i]); }
  void push(int i, const Point& v) { v_.set(i, {R(v.x), R(v.y), R(v.z)}); }
  DeformingCollider<Serial, R>& collider() { return collider_; }

 private:
  static Model model_of(const EnvironmentSpec& spec, double h, const std::vector<Point>& x) {
    Model model;
    model.scene.solver.dt = h, model.scene.solver.substeps = 1;
    model.environment.push_back({spec, generate(spec.shape)});
    model.environment[0].spec.animation.emplace().from_code = true;
    for (const Point& a : x) model.x.push_back({a.x, a.y, a.z});
    return model;
  }

  double h_;
  Deformation deformation_;
  Model model_;
  DeformingCollider<Serial, R> collider_;
  std::vector<Vec3> start_;
  PointList<R> x_, low_, v_, d_;
  std::vector<R> w_;
  int substeps_ = 0;
};

/// A ball of radius .5 that is squeezed, bent and thrown about, `speed` times as fast as a second per cycle.
Deformation thrown_ball(double speed) {
  return [speed](const Vec3& x, double time) -> Vec3 {
    const double s = 2 * M_PI * speed * time, wide = 1 + .3 * std::sin(s), flat = 1 / (wide * wide);
    const double bend = .5 * std::sin(1.7 * s) * x[0], c = std::cos(bend), d = std::sin(bend);
    const double u = x[0] * wide, y = x[1] * flat, z = x[2] * wide;
    return {u * c - y * d + .6 * std::sin(.9 * s), u * d + y * c + .7 * std::sin(1.3 * s), z + .5 * std::cos(.7 * s)};
  };
}

EnvironmentSpec ball_spec(int subdivisions, double thickness) {
  EnvironmentSpec spec;
  spec.name = "ball", spec.shape = SphereShape{0.5, subdivisions}, spec.thickness = thickness;
  return spec;
}

std::vector<Point> points_outside(std::mt19937& random, int count, double from, double to) {
  std::uniform_real_distribution<double> uniform(-to, to);
  std::vector<Point> all;
  while (static_cast<int>(all.size()) < count) {
    const Point p{uniform(random), uniform(random), uniform(random)};
    if (norm(p) > from && norm(p) < to) all.push_back(p);
  }
  return all;
}

template <class R>
class DeformingContact : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(DeformingContact, Precisions);

TYPED_TEST(DeformingContact, NoParticleIsEverInsideABallThatIsSqueezedAndThrownAtAnySpeed) {
  using R = TypeParam;
  for (const double speed : {1.0, 4.0, 16.0, 64.0}) {
    std::mt19937 random(17);
    std::normal_distribution<double> normal;
    const auto ball = thrown_ball(speed);
    std::vector<Point> x, v;
    for (const Point& p : points_outside(random, 300, .7, 1.6)) {
      const Vec3 offset = ball({0, 0, 0}, 0);
      x.push_back(p + Point{offset[0], offset[1], offset[2]});
      v.push_back(Point{normal(random), normal(random), normal(random)} * 3);
    }
    DeformingBench<R> bench(ball_spec(2, .01), 1.0 / 600, ball, x, v);
    int touched = 0;
    for (int s = 0; s < 150; ++s) {
      bench.substep({0, 0, 0}, [&](int, Vector3<R>& d) {  // a jolt of constraints, now and then
        if (random() % 50 == 0)
          d = d + Vector3<R>{R(.05 * normal(random)), R(.05 * normal(random)), R(.05 * normal(random))};
      });
      touched += bench.collider().contacts();
      const BruteForce surface = bench.surface();
      for (int i = 0; i < bench.count(); ++i)
        ASSERT_NEAR(surface.winding(bench.x(i)), 0, .4) << "particle " << i << ", substep " << s << ", speed " << speed;
      // Whatever was hit flies away: all are drawn back.
      for (int i = 0; i < bench.count(); ++i)
        if (const Point at = bench.x(i); norm(at) > 2) bench.push(i, at * (-3 / norm(at)));
    }
    EXPECT_GT(touched, 30);
    EXPECT_EQ(bench.collider().most_pinched(), 0);
  }
}

EnvironmentSpec sheet_spec(Sides sides, double thickness) {
  EnvironmentSpec spec;
  spec.name = "sheet", spec.shape = GridShape{{2, 2}, {14, 14}}, spec.thickness = thickness, spec.sides = sides;
  return spec;
}

TYPED_TEST(DeformingContact, ATwoSidedSheetThatFlapsKeepsEveryParticleOnItsSide) {
  using R = TypeParam;
  for (const double speed : {1.0, 8.0, 40.0}) {
    const Deformation flap = [speed](const Vec3& x, double t) -> Vec3 {
      const double u = x[0] - 1, w = x[2] - 1, s = 2 * M_PI * speed * t;
      return {u, .4 * std::sin(s) + .2 * std::sin(3 * u + 2 * s) * std::cos(2 * w), w};
    };
    const auto height = [&](const Point& p, double t) { return p.y - flap({p.x + 1, 0, p.z + 1}, t)[1]; };
    std::mt19937 random(5);
    std::uniform_real_distribution<double> across(-.8, .8), along(.1, .6);
    std::vector<Point> x, v;
    for (int i = 0; i < 400; ++i) {
      x.push_back({across(random), (i % 2 ? 1 : -1) * along(random), across(random)});
      x.back().y += flap({x.back().x + 1, 0, x.back().z + 1}, 0)[1];
      v.push_back({0, i % 2 ? -4.0 : 4.0, 0});
    }
    DeformingBench<R> bench(sheet_spec(Sides::TwoSided, .01), 1.0 / 600, flap, x, v);
    for (int s = 1; s <= 200; ++s) {
      bench.substep();
      for (int i = 0; i < bench.count(); ++i) {
        const Point at = bench.x(i);
        if (std::abs(at.x) > .9 || std::abs(at.z) > .9) continue;  // it may go round the rim
        // The facets are up to 3 mm from the smooth surface.
        ASSERT_GT((i % 2 ? 1 : -1) * height(at, s / 600.0), -.004) << "particle " << i << ", substep " << s;
        if (s % 40 == 0) bench.push(i, {0, i % 2 ? -4.0 : 4.0, 0});
      }
    }
  }
}

TYPED_TEST(DeformingContact, AOneSidedSheetLetsThroughWhatComesFromBehind) {
  using R = TypeParam;
  const Deformation rise = [](const Vec3& x, double t) -> Vec3 { return {x[0] - 1, .3 * t + .05 * x[0], x[2] - 1}; };
  DeformingBench<R> bench(sheet_spec(Sides::OneSided, .01), 1.0 / 600, rise, {{0, .5, 0}, {.1, -.5, 0}},
                          {{0, -2, 0}, {0, 2, 0}});
  for (int s = 0; s < 400; ++s) bench.substep();
  EXPECT_GT(bench.x(0).y, .2) << "it is held by the front";
  EXPECT_GT(bench.x(1).y, .5) << "it has passed from behind";
}

TYPED_TEST(DeformingContact, WhatRestsOnASurfaceKeepsTheThicknessAndMovesWithIt) {
  using R = TypeParam;
  // The sheet stretches along x at .2 a second and slides along z: a particle that sticks keeps its material point.
  const double speed = .3;
  const Deformation stretch = [&](const Vec3& x, double t) -> Vec3 {
    return {(x[0] - 1) * (1 + .2 * t), 0, x[2] - 1 + speed * t};
  };
  DeformingBench<R> bench(
      [] {
        EnvironmentSpec spec = sheet_spec(Sides::TwoSided, .01);
        spec.friction = 1;
        return spec;
      }(),
      1.0 / 600, stretch, {{.4, .01, .1}, {-.7, .01, -.2}}, {{0, 0, 0}, {0, 0, 0}});
  for (int s = 0; s < 600; ++s) bench.substep({0, -9.81, 0});
  for (const auto& [i, u, z] : {std::tuple{0, .4, .1}, std::tuple{1, -.7, -.2}}) {
    EXPECT_NEAR(bench.x(i).y, .01, 1e-5);
    // It starts at rest, and friction of 1 takes v^2 / (2 g) = 5 mm until it moves along.
    EXPECT_NEAR(bench.x(i).z, z + speed, .006);
    EXPECT_NEAR(bench.x(i).x, u * 1.2, .003);
    EXPECT_NEAR(bench.v(i).z, speed, 1e-3);
    EXPECT_NEAR(bench.v(i).x, .2 * u, 2e-3);
  }
}

TYPED_TEST(DeformingContact, ASurfaceThatSwellsPushesParticlesAtItsOwnSpeedAndRestitutionThrowsThem) {
  using R = TypeParam;
  for (const double restitution : {0.0, .5}) {
    EnvironmentSpec spec = ball_spec(3, .01);
    spec.restitution = restitution;
    const Deformation swell = [](const Vec3& x, double t) -> Vec3 {
      const double r = 1 + 2 * t;
      return {x[0] * r, x[1] * r, x[2] * r};
    };
    DeformingBench<R> bench(spec, 1.0 / 600, swell, {{.6, .02, .01}}, {{0, 0, 0}});
    for (int s = 0; s < 120; ++s) bench.substep();
    // The surface moves at 1 m/s times the share of the radius: the particle leaves at (1 + e) times that.
    EXPECT_NEAR(bench.v(0).x, 1 + restitution, .03);
  }
}

TYPED_TEST(DeformingContact, ParticlesThatStartTooNearStayAsNearUntilTheyMoveAway) {
  using R = TypeParam;
  const Deformation still = [](const Vec3& x, double) -> Vec3 { return {x[0] - 1, 0, x[2] - 1}; };
  DeformingBench<R> bench(sheet_spec(Sides::TwoSided, .02), 1.0 / 600, still, {{.1, .005, .1}, {.2, .03, .1}},
                          {{0, 0, 0}, {0, 0, 0}});
  for (int s = 0; s < 300; ++s) bench.substep({0, -9.81, 0});
  EXPECT_NEAR(bench.x(0).y, .005, 1e-6);
  EXPECT_NEAR(bench.x(1).y, .02, 1e-6);
  bench.push(0, {0, 2, 0});
  for (int s = 0; s < 600; ++s) bench.substep({0, -9.81, 0});
  EXPECT_NEAR(bench.x(0).y, .02, 1e-6);
}

TYPED_TEST(DeformingContact, BetweenTwoWallsThatCloseParticlesAreCountedAndNothingExplodes) {
  using R = TypeParam;
  // A bent sheet folds shut: its two halves meet, and what lies between them has no place.
  const Deformation fold = [](const Vec3& x, double t) -> Vec3 {
    const double u = x[0] - 1, open = std::abs(std::cos(2 * M_PI * t)) * 1.2 - .1;
    return {std::abs(u) * std::cos(open), u > 0 ? u * std::sin(open) : u * std::sin(open), x[2] - 1};
  };
  std::vector<Point> x;
  for (int i = 0; i < 40; ++i) x.push_back({.3 + .01 * i, .002 * (i - 20), .05 * (i % 7) - .15});
  DeformingBench<R> bench(sheet_spec(Sides::TwoSided, .01), 1.0 / 600, fold, x,
                          std::vector<Point>(x.size(), Point{0, 0, 0}));
  double fastest = 0;
  for (int s = 0; s < 600; ++s) {
    bench.substep();
    for (int i = 0; i < bench.count(); ++i) fastest = std::max(fastest, norm(bench.v(i)));
  }
  EXPECT_GT(bench.collider().most_pinched(), 0);
  EXPECT_LT(fastest, 40) << "the walls' rims move at up to 8 m/s";
}

}  // namespace
}  // namespace malha
