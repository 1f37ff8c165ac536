// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/environment/contact_bench.h"
#include "tests/scene_builders.h"

namespace malha {
namespace {

constexpr double kStep = 1.0 / 600;
constexpr double kFloat = std::numeric_limits<float>::epsilon();

Keyframe placed(double time, const Vec3& translate, double degrees = 0) {
  return {time, translate, {0, 1, 0}, degrees};
}

template <class Executor, class R>
std::vector<Point> all_x(const ContactBench<Executor, R>& bench) {
  std::vector<Point> x;
  for (int i = 0; i < bench.count(); ++i) x.push_back(bench.x(i));
  return x;
}

TEST(Contact, AMovingWallSweepsRestingParticlesAlongAndNeverPassesThem) {
  for (const double speed : {0.01, 1.0, 30.0, 1000.0}) {
    EnvironmentSpec wall = obstacle("wall", BoxShape{{0.02, 2, 2}, {{1, 4, 4}}});
    wall.motion = {placed(0, {0, 0, 0}), placed(10, {10 * speed, 0, 0})};
    Random random(1);
    std::vector<Point> x, v(100, Point{0, 0, 0});
    const double face = 0.01 + wall.thickness;
    for (int i = 0; i < 100; ++i)
      x.push_back({face + random(0.001, 5) * speed * kStep, random(-0.9, 0.9), random(-0.9, 0.9)});
    ContactBench<OpenMP, float> bench(OpenMP{2}, wall, x, v);
    for (int s = 0; s < 30; ++s) {
      bench.substep(kStep);
      const double now = bench.time() * speed;
      for (int i = 0; i < bench.count(); ++i)
        ASSERT_GT(bench.x(i).x, now + face - 8 * kFloat * (1 + now)) << speed << " m/s, substep " << s;
    }
    for (int i = 0; i < bench.count(); ++i)  // they move with the wall, to the rounding of positions over a substep
      EXPECT_NEAR(bench.v(i).x, speed, 8 * kFloat * (1 + speed * bench.time()) / kStep);
  }
}

TEST(Contact, ATurningWallNeverPassesParticles) {
  EnvironmentSpec blade = obstacle("blade", BoxShape{{1, 1, 0.02}, {{4, 4, 1}}});
  blade.transform.translate = {0.7, 0, 0};
  blade.motion = {placed(0, {0, 0, 0}), placed(1, {0, 0, 0}, -720)};
  Random random(2);
  std::vector<Point> x, v(100, Point{0, 0, 0});
  for (int i = 0; i < 100; ++i) {
    const double angle = random(0.3, 3), far = random(0.3, 1.1);
    x.push_back({far * std::cos(angle), random(-0.4, 0.4), far * std::sin(angle)});
  }
  ContactBench<Serial, double> bench({}, blade, x, v);
  int swept = 0;
  for (int s = 0; s < 100; ++s) {
    bench.substep(kStep);
    const double turned = 4 * std::numbers::pi * bench.time();
    for (int i = 0; i < bench.count(); ++i) {
      const Point p = bench.x(i);
      const double ahead = std::cos(turned) * p.z - std::sin(turned) * p.x,
                   along = std::cos(turned) * p.x + std::sin(turned) * p.z;
      if (along < 0.25 || along > 1.15) continue;  // beyond the blade's ends a particle may fall behind it
      // A contact follows its frame along the chord of the turn: r (omega h)^2 / 8 = 7e-5 m in a substep.
      ASSERT_GT(ahead, 0.01 + blade.thickness - 1e-4) << "particle " << i << ", substep " << s;
      swept += ahead < 0.01 + 2 * blade.thickness;
    }
  }
  EXPECT_GT(swept, 500);
}

TEST(Contact, WhatStartsInsideIsLiftedOutWithoutGainingSpeed) {
  for (const Sides sides : {Sides::Solid, Sides::OneSided}) {
    const EnvironmentSpec ball = obstacle("ball", SphereShape{1, 4}, sides);
    Random random(3);
    std::vector<Point> x, v(200, Point{0, 0, 0});
    for (int i = 0; i < 200; ++i) x.push_back(random.direction() * random(0.2, 1.004));
    ContactBench<OpenMP, float> bench(OpenMP{3}, ball, x, v);
    bench.substep(kStep);
    for (int i = 0; i < bench.count(); ++i) {
      EXPECT_GT(norm(bench.x(i)), 0.997) << "facets lie up to 0.002 inside the sphere";
      // Position and prediction move together; each is rounded, and the contact plane corrects what that leaves.
      EXPECT_LT(norm(bench.v(i)), 4 * kFloat / kStep) << "particle " << i;
    }
    const std::vector<Point> lifted = all_x(bench);
    for (int s = 0; s < 20; ++s) bench.substep(kStep);
    for (int i = 0; i < bench.count(); ++i) EXPECT_LT(norm(bench.x(i) - lifted[i]), 1e-5);
  }
}

// A particle within the thickness keeps its distance, but for a fiftieth of the thickness.
TEST(Contact, WhatStartsOnTheSurfaceStaysThereWithoutGainingSpeed) {
  EnvironmentSpec ground = obstacle("ground", GridShape{{1, 1}, {4, 4}}, Sides::OneSided);
  ground.friction = 1;  // A particle that keeps its distance is not pushed, so that there is no friction.
  for (const Sides sides : {Sides::OneSided, Sides::TwoSided}) {
    ground.sides = sides;
    for (const double speed : {0.0, 1.0, 10.0}) {  // along the surface
      std::vector<Point> x, v;
      for (const double height : {0.0, 1e-6, 1e-3, 4e-3, 0.005})
        x.push_back({0.4, height, 0.4}), v.push_back({speed, 0, 0});
      ContactBench<Serial, double> bench({}, ground, x, v);
      bench.substep(kStep);
      for (int i = 0; i < bench.count(); ++i) {
        EXPECT_NEAR(bench.x(i).y, x[i].y, 1e-12) << "from " << x[i].y << " at " << speed << " m/s";
        EXPECT_NEAR(bench.v(i).y, 0, 1e-9) << "from " << x[i].y << " at " << speed << " m/s";
        EXPECT_NEAR(bench.v(i).x, speed, 1e-9);
      }
    }
  }
}

TEST(Contact, WhatPassesACornerOutsideTheThicknessIsNotTouched) {
  const EnvironmentSpec box = obstacle("box", BoxShape{{1, 1, 1}, {{2, 2, 2}}});
  Random random(4);
  for (const double speed : {10.0, 60.0, 100.0, 1000.0, 10000.0}) {
    std::vector<Point> x, v;
    for (int i = 0; i < 300; ++i) {
      // The particle passes an edge or a corner, at right angles to the outward direction, at 1.2 to 4 thicknesses.
      const bool corner = i % 2 == 0;
      const Point out = Point{1, 1, corner ? 1.0 : 0.0} * (1 / std::sqrt(corner ? 3.0 : 2.0));
      const Point tip{0.5, 0.5, corner ? 0.5 : 0.1};
      const Point across = cross(out, corner ? random.direction() : Point{0, 0, 1});
      const Point direction = across * (1 / norm(across));
      x.push_back(tip + out * (box.thickness * random(1.2, 4)) - direction * random(0, 6 * speed * kStep));
      v.push_back(direction * speed);
    }
    ContactBench<Serial, double> bench({}, box, x, v);
    for (int s = 0; s < 12; ++s) bench.substep(kStep);
    for (int i = 0; i < bench.count(); ++i) {
      const Point expected = x[i] + v[i] * (12 * kStep);
      ASSERT_LT(norm(bench.x(i) - expected), 1e-9) << "particle " << i << " at " << speed << " m/s";
    }
  }
}

TEST(Contact, AOneSidedSheetIgnoresWhatIsBeyondItsRimBelow) {
  EnvironmentSpec sheet = obstacle("sheet", GridShape{{1, 1}, {4, 4}}, Sides::OneSided);
  // The particles are below and beside the sheet, at rest or rising past its boundary.
  const std::vector<Point> x = {{1.02, -0.01, 0.5}, {-0.5, -0.3, 0.5}, {1.01, -0.5, 1.01}, {0.5, -0.2, -0.02}};
  const std::vector<Point> v = {{0, 0, 0}, {0, 0, 0}, {0, 5, 0}, {0, 100, 0}};
  ContactBench<Serial, double> bench({}, sheet, x, v);
  for (int s = 0; s < 100; ++s) bench.substep(kStep);
  for (int i = 0; i < bench.count(); ++i)
    EXPECT_LT(norm(bench.x(i) - (x[i] + v[i] * (100 * kStep))), 1e-12) << "particle " << i;
}

TEST(Contact, ATwoSidedSheetSupportsWhatRestsOnEitherSide) {
  const EnvironmentSpec sheet = obstacle("sheet", GridShape{{1, 1}, {4, 4}}, Sides::TwoSided);
  for (const double side : {-1.0, 1.0}) {
    ContactBench<Serial, float> bench({}, sheet, {{0.5, 0.02 * side, 0.5}, {0.3, 0.001 * side, 0.7}},
                                      {{0, 0, 0}, {0, 0, 0}});
    for (int s = 0; s < 200; ++s) bench.substep(kStep, {0, -9.81 * side, 0});
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR(bench.x(i).y * side, i == 0 ? sheet.thickness : 0.001, 4 * kFloat);
      EXPECT_NEAR(bench.v(i).y, 0, 1e-4);
    }
  }
}

TEST(Contact, ALargeTwoSidedSheetLetsWhatRestsOnItRiseAgain) {
  // The surface's tolerance, 1e-5 of its size, is larger than the thickness.
  EnvironmentSpec sheet = obstacle("plain", GridShape{{2000, 2000}, {8, 8}}, Sides::TwoSided);
  sheet.transform.translate = {-1000, 0, -1000};
  for (const double side : {-1.0, 1.0}) {
    ContactBench<Serial, double> bench({}, sheet, {{3, 0.005 * side, 7}}, {{0, 20 * side, 0}});
    for (int s = 0; s < 60; ++s) bench.substep(kStep);
    EXPECT_NEAR(bench.x(0).y * side, 0.005 + 20 * 0.1, 1e-9);
  }
}

TEST(Contact, BouncesByItsRestitutionRelativeToTheSurface) {
  EnvironmentSpec ground = obstacle("ground", GridShape{{1, 1}, {4, 4}}, Sides::OneSided);
  ground.restitution = 0.6;
  const std::vector<Point> x = {{0.4, 0.1, 0.4}}, v = {{0, -3, 0}};
  ContactBench<Serial, double> still({}, ground, x, v);
  for (int s = 0; s < 60; ++s) still.substep(kStep);
  EXPECT_NEAR(still.v(0).y, 0.6 * 3, 1e-9);
  ground.motion = {placed(0, {0, 0, 0}), placed(1, {0, 1, 0})};
  ContactBench<Serial, double> rising({}, ground, x, v);
  for (int s = 0; s < 60; ++s) rising.substep(kStep);
  EXPECT_NEAR(rising.v(0).y, 1 + 0.6 * 4, 1e-9);
}

TEST(Contact, FrictionTakesWhatCoulombsConeAllows) {
  EnvironmentSpec ground = obstacle("ground", GridShape{{10, 10}, {4, 4}}, Sides::OneSided);
  const double g = 10, mu = 0.25;
  ground.friction = mu;
  for (const int iterations : {1, 8}) {  // friction is limited by the cone of the sum over all iterations
    ContactBench<Serial, double> bench({}, ground, {{1, 0.005, 5}}, {{2, 0, 0}});
    for (int s = 0; s < 240; ++s) bench.substep(kStep, {0, -g, 0}, iterations);
    EXPECT_NEAR(bench.v(0).x, 2 - mu * g * 0.4, 1e-6) << "after 0.4 s of deceleration by mu g";
    for (int s = 0; s < 400; ++s) bench.substep(kStep, {0, -g, 0}, iterations);
    EXPECT_NEAR(bench.v(0).x, 0, 1e-12) << "after 0.8 s it has stopped, and stays";
    // v^2 / (2 mu g), plus the distance of half a substep, because v is constant over each substep.
    EXPECT_NEAR(bench.x(0).x - 1, 4 / (2 * mu * g), 2 * kStep);
  }
}

/// Contact planes and particles of a run, substep by substep. Without a contact cache every substep has a collider of
/// its own, which knows no earlier positions but only the clearance, and has no triangle lists: it queries the surface
/// for every particle.
template <class R>
struct Watched {
  std::vector<Vec4<R>> planes;
  PointList<R> x, v;
  int contacts = 0;
  ContactStats facts;

  Watched(const EnvironmentSpec& spec, bool remembers, int substeps) {
    Model model;
    model.environment.push_back({spec, generate(spec.shape)});
    constexpr int n = 400;
    Random random(5);
    for (int i = 0; i < n; ++i) {
      const Point at = random.in_cube(1.5), speed = random.in_cube(i % 10 == 0 ? 300 : 5);
      x.push_back(at), v.push_back(speed);
      model.x.push_back({at.x, at.y, at.z});
    }
    PointList<R> d(n), low(n);
    const std::vector<R> w(n, R(1));
    const Particles<R> all{n, x.points(), v.points(), {x.points(), d.points(), low.points()}, w.data()};
    std::optional<MeshCollider<Serial, R>> collider;
    for (int s = 0; s < substeps; ++s) {
      const double h = kStep, start = s * h;
      if (!collider) {
        collider.emplace(Serial{}, model);
      } else if (!remembers) {
        ProximityMemory cache;
        collider->for_each_part([&](const auto& part) { cache.add(part); });
        cache.boxes.assign(groups_of(n), {{}, {1, 0, 0}, GroupBox::kPerParticle}),
            cache.entries.assign(n, {0, 0, 0, -1e30f});
        for (PairRecord& near : cache.near) near.record = {{}, -1e30, -1, {}, near.record.overlap};
        collider.emplace(Serial{}, model);
        collider->restore_state(cache);
      }
      parallel_for(Serial{}, n, Predict<R>{all, R(h), {R(0), R(-9.81), R(0)}});
      collider->set_poses(start, start + h);
      collider->detect_contacts(all);
      for (int i = 0; i < n; ++i) {
        const Contact<R>* const contact = collider->cache(0).contact(i);
        planes.push_back(contact ? contact->plane : Vec4<R>{0, 0, 0, -R(INFINITY)});
        contacts += std::isfinite(planes.back().w);
      }
      collider->solve_contacts(all);
      parallel_reduce<FirstIndex>(Serial{}, n, UpdateState<R>{all, R(h), R(1 / h)});
    }
    facts = collider->facts();
  }
};

TEST(Contact, TheContactCacheChangesNothing) {
  EnvironmentSpec ball = obstacle("ball", SphereShape{1, 3});
  ball.friction = 0.3;
  for (const bool moving : {false, true}) {
    if (moving) ball.motion = {placed(0, {0, 0, 0}), placed(0.5, {1, 2, 0}, 500)};
    const Watched<float> with(ball, true, 120), without(ball, false, 120);
    ASSERT_EQ(with.planes.size(), without.planes.size());
    EXPECT_GT(with.contacts, 1000);
    EXPECT_LT(with.facts.full_queries, with.facts.closest_point_queries) << "lists answer some of the queries";
    for (std::size_t i = 0; i < with.planes.size(); ++i)
      ASSERT_TRUE(same_bits(with.planes[i], without.planes[i])) << "particle " << i % 400 << ", substep " << i / 400;
    for (int i = 0; i < with.x.size(); ++i)
      ASSERT_TRUE(same_bits(with.x[i], without.x[i]) && same_bits(with.v[i], without.v[i])) << i;
  }
}

TEST(Contact, CachesLittleOfWhatIsFarAndNotMuchOfWhatIsNear) {
  EnvironmentSpec ball = obstacle("ball", SphereShape{1, 4});
  const int n = 20000, near = 500;
  Random random(8);
  std::vector<Point> x;
  for (int i = 0; i < n; ++i) x.push_back(random.direction() * (i < near ? 1 + ball.thickness : random(3, 9)));
  ContactBench<Serial, float> bench({}, ball, x, std::vector<Point>(x.size(), Point{0, 0, 0}));
  for (int s = 0; s < 3; ++s) bench.substep(kStep);
  const ContactStats facts = bench.collider().facts();
  EXPECT_EQ(facts.near, near);
  EXPECT_LE(facts.far_bytes, 24u * n);
  EXPECT_LE(facts.near_bytes, (400u - 24u) * near);
}

TEST(Contact, IsTheSameOnEveryExecutor) {
  const EnvironmentSpec ball = obstacle("ball", SphereShape{1, 3});
  Random random(6);
  std::vector<Point> x, v;
  for (int i = 0; i < 300; ++i) x.push_back(random.in_cube(1.5)), v.push_back(random.in_cube(10));
  const auto run = [&]<class Executor>(const Executor& executor) {
    ContactBench<Executor, float> bench(executor, ball, x, v);
    for (int s = 0; s < 60; ++s) bench.substep(kStep, {0, -9.81, 0});
    EXPECT_GT(bench.collider().contacts(), 0);
    EXPECT_LT(bench.collider().max_penetration(bench.particles(), bench.time()), 1e-5);
    return all_x(bench);
  };
  const std::vector<Point> serial = run(Serial{});
  for (const int threads : {1, 2, 3, 8}) {
    const std::vector<Point> parallel = run(OpenMP{threads});
    for (std::size_t i = 0; i < x.size(); ++i) ASSERT_TRUE(same_bits(serial[i], parallel[i])) << threads << " threads";
  }
}

TEST(Contact, PenetrationIsMeasuredInSolidsAndBehindOneSidedSheets) {
  for (const Sides sides : {Sides::Solid, Sides::OneSided, Sides::TwoSided}) {
    const EnvironmentSpec box = obstacle("box", BoxShape{{1, 1, 1}, {{2, 2, 2}}}, sides);
    ContactBench<Serial, double> bench({}, box, {{0, 0.3, 0}, {0.1, 0.45, 0}, {2, 2, 2}}, std::vector<Point>(3));
    // The penetration is measured before any contact has corrected it.
    EXPECT_NEAR(bench.collider().max_penetration(bench.particles(), 0), sides == Sides::TwoSided ? 0.0 : 0.2, 1e-12);
  }
}

// In ten projections neighbours push the particle in and pull it back out. In the end push and friction are what
// Coulomb's cone allows for the push that is left.
TEST(Contact, FrictionOfAllIterationsIsThatOfThePushThatIsLeft) {
  const double mu = 0.3;
  for (const double left : {0.5, 0.1, 0.0}) {
    PointList<double> x(1), d(1);
    x.set(0, {3, 2, 1}), d.set(0, {1, -1, 0});
    Contact<double> contact{{0, 1, 0, 0}, {0, 0, 0, -1}, 0, {0, 0, 0}, {0, 0, 0}, 0};
    const ResolveContact<double> resolve{{x.points(), d.points(), {}}, &contact, mu};
    resolve(0);
    EXPECT_NEAR(d[0].x, 1 - mu, 1e-15);
    for (int iteration = 0; iteration < 10; ++iteration) {  // 1 - left is undone in ten equal steps
      d.set(0, d[0] + Vector3<double>{0, (1 - left) / 10, 0});
      resolve(0);
    }
    EXPECT_NEAR(contact.lambda, left, 1e-15);
    EXPECT_NEAR(d[0].x, 1 - mu * left, 1e-14) << left;
  }
}

TEST(Contact, PinnedParticlesGetNone) {
  const EnvironmentSpec box = obstacle("box", BoxShape{{1, 1, 1}, {{2, 2, 2}}});
  ContactBench<Serial, double> bench({}, box, {{0, 0.4, 0}}, {{0, 0, 0}});
  bench.pin(0);
  bench.substep(kStep);
  EXPECT_EQ(bench.x(0).y, 0.4);
  EXPECT_EQ(bench.collider().contacts(), 0);
  EXPECT_EQ(bench.collider().max_penetration(bench.particles(), bench.time()), 0);
}

}  // namespace
}  // namespace malha
