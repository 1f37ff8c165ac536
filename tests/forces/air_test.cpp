// SPDX-License-Identifier: Apache-2.0
// Air on faces: terminal velocity, drag and lift against their formulas, and no gain of energy relative to the air.
#include "host/forces/air.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "host/base/point_array.h"
#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/model/build_constraints.h"
#include "host/solver/solver.h"
#include "tests/numbers.h"
#include "tests/on_host.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kDensity = 1.2;

Wind air(const Vec3& velocity = {0, 0, 0}, double drag_coefficient = 1.2, double lift_coefficient = 1.2) {
  return {velocity, 0, kDensity, drag_coefficient, lift_coefficient};
}

/// A plate of 1 x 2 m and 0.5 kg in the plane y = 0.
BodySpec plate() {
  BodySpec body;
  body.name = "plate";
  body.shape = GridShape{{1, 2}, {4, 8}};
  body.mass = 0.5;
  body.constraints = {stiff("distance", {"edges", "shear"})};
  return body;
}

/// The sum of forces (N), from the change of momentum in one short step.
Vec3 force(BodySpec body, const Wind& wind) {
  const double h = 1e-7;
  body.constraints.clear();
  Scene scene = scene_of({body}, {}, h);
  scene.wind = wind;
  Simulation simulation(scene, {.threads = 1});
  simulation.step();
  const Measures m = simulation.measure();
  return {m.momentum[0] / h, m.momentum[1] / h, m.momentum[2] / h};
}

double along(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

class AirOnAPlate : public testing::TestWithParam<const char*> {};

/// k u^2 = m g; with drag implicit over a step of h, and gravity after it, k u^2 = m g + k u g h.
TEST_P(AirOnAPlate, LetsItFallAtItsTerminalVelocity) {
  Scene scene = scene_of({plate()}, kEarth, 0.01, 5);
  scene.solver.type = GetParam();
  scene.wind = air();
  const double g = 9.81, h = scene.solver.dt / 5, m = 0.5, k = 0.5 * kDensity * 1.2 * 2;
  const double u = (g * h + std::sqrt(g * h * g * h + 4 * m * g / k)) / 2;
  EXPECT_NEAR(u, std::sqrt(m * g / k), g * h);
  const Simulation simulation = after(scene, 4);
  for (const Vec3& v : simulation.velocities()) {
    EXPECT_NEAR(v[1], -u, 1e-9);
    EXPECT_NEAR(std::hypot(v[0], v[2]), 0, 1e-9);
  }
}
INSTANTIATE_TEST_SUITE_P(Under, AirOnAPlate, testing::Values("pbd", "desbrun"));

TEST(Air, IsNotFeltEdgeOn) {
  Scene still = scene_of({plate()}, {3, 0, -5}, 0.01, 5);
  Scene vacuum = still;
  still.wind = air();
  EXPECT_EQ(after(still, 0.5).state_hash(), after(vacuum, 0.5).state_hash());
}

/// Wind along x on a plate whose normal is turned by 30 degrees from it.
TEST(Air, DragsAndLiftsAPlateAtAnAngle) {
  const double degrees = 30, speed = 5, area = 2, c = std::cos(degrees * kPi / 180), s = std::sin(degrees * kPi / 180);
  BodySpec body = plate();
  body.transform.axis = {0, 0, 1}, body.transform.degrees = degrees - 90;  // its normal y goes to (c, s, 0)
  const double q = 0.5 * kDensity * area * speed * speed;
  for (const auto& [drag, lift] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {1.3, 0.7}, {1.2, 1.2}}) {
    const Vec3 f = force(body, air({speed, 0, 0}, drag, lift));
    EXPECT_NEAR(f[0], q * drag * c * c, 1e-4 * q);  // the implicit step's share and 2e-9 of rounding over the step
    EXPECT_NEAR(f[1], q * lift * c * s, 1e-4 * q);
    EXPECT_NEAR(f[2], 0, 1e-6 * q);
    // With both coefficients equal, the force is a pressure along the normal (c, s, 0).
    if (drag == lift) {
      EXPECT_NEAR(f[1] / f[0], s / c, 1e-4);
    }
  }
}

/// Windward and lee faces count; over a ball A (u . n)^2 adds up to 4/3 of its frontal area.
TEST(Air, DragsABallAlongTheWind) {
  BodySpec ball;
  ball.name = "ball";
  ball.shape = SphereShape{0.5, 4};
  ball.mass = 1;
  const Vec3 wind{3, -2, 6};  // 7 m/s
  const Vec3 f = force(ball, air(wind, 0.9, 0.4));
  const double expected = 0.5 * kDensity * 0.9 * 49 * 4 / 3 * kPi * 0.25;
  EXPECT_NEAR(along(f, wind) / 7, expected, 0.003 * expected);  // 2,562 points cut the ball's area by 0.2 %
  EXPECT_NEAR(length(f), expected, 0.003 * expected) << "nothing across";
}

/// Whatever the step, the speed relative to the air only decreases, particle by particle, and never reverses.
template <class R>
void expect_no_gain() {
  Random random(7);
  const Mesh mesh = make_mesh(GridShape{{1, 1}, {6, 6}});
  AirFaces around;
  std::vector<int> name(mesh.points.size());
  std::iota(name.begin(), name.end(), 0);
  add_air_faces(mesh, name, around);
  for (const double h : {1e-3, 1.0, 1e3}) {
    std::vector<Vec3> at, velocity;
    std::vector<R> w;
    for (std::size_t i = 0; i < name.size(); ++i) {
      const Vector3<double> x = random.in_cube(), v = random.in_cube(10);
      at.push_back({x.x, x.y, x.z}), velocity.push_back({v.x, v.y, v.z}), w.push_back(R(random(0.1, 1000)));
    }
    PointArray<Serial, R> x(at), v(velocity), still(std::vector<Vec3>(at.size()));
    const Wind wind{{1, 2, -3}, 0, kDensity, random(0, 3), random(0, 30)};
    Air<Serial, R>({}, around, wind)
        .apply_wind({int(w.size()), x.points(), v.points(), {x.points(), still.points(), still.points()}, w.data()}, h);
    const std::vector<Vec3> now = v.download();
    for (std::size_t i = 0; i < w.size(); ++i) {
      const double before = length(wind.velocity - velocity[i]);
      EXPECT_LE(length(wind.velocity - now[i]), before * (1 + 4 * std::numeric_limits<R>::epsilon())) << h;
    }
  }
}
TEST(Air, NeverGivesEnergyToMotionRelativeToIt) {
  expect_no_gain<double>();
  expect_no_gain<float>();
}

/// A flag fixed at one side in a gale.
Scene flag(const char* solver, Precision precision) {
  BodySpec body = plate();
  body.shape = GridShape{{1.5, 1}, {15, 10}};
  body.transform.axis = {1, 0, 0}, body.transform.degrees = 90;  // upright, in the plane of x and y
  body.mass = 0.15;
  body.pins = {BoxPin{{-0.01, -2, -1}, {0.01, 2, 1}}};
  body.constraints.push_back(stiff("bending", {}, 0.05));
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 8, precision);
  scene.solver.type = solver;
  scene.wind = air({15, 0, 2});
  return scene;
}

TEST(Air, KeepsAFlagFlying) {
  for (const char* solver : {"pbd", "desbrun"}) {
    const Simulation simulation = after(flag(solver, Precision::Float), 2);
    double mean = 0;
    for (const Vec3& x : simulation.positions()) mean += x[0] / 176;
    EXPECT_GT(mean, 0.5) << solver << ": it flies out along the wind";
    EXPECT_LT(simulation.measure().speed_max, 60) << solver;
  }
}

TEST(Air, IsAPassOfItsOwnOnlyWhereItHasADensity) {
  if (!scenes_run_on_host()) GTEST_SKIP() << "passes are timed on the host alone";
  Scene scene = flag("pbd", Precision::Float);
  for (const double density : {0.0, kDensity}) {
    scene.wind->density = density;
    Simulation simulation(scene, {.threads = 1});
    simulation.step();
    EXPECT_EQ(simulation.solver().pass_seconds()[int(Pass::Air)] > 0, density > 0);
    EXPECT_EQ(simulation.solver().facts().air_bytes > 0, density > 0);
  }
}

TEST(Air, OnBodiesWithoutFacesIsRefused) {
  Scene scene = scene_of({particle({0, 0, 0})}, kEarth, 0.01);
  scene.file = "s.json";
  scene.wind = air();
  EXPECT_EQ(refusal([&] { Simulation(scene, {.threads = 1}); }),
            "s.json: /wind/density: found air on the faces of bodies without faces; allowed: a body with faces, or "
            "'drag' alone");
}

/// Two bodies, one of them in two parts: damping reduces each part's own deformation and does not change the other
/// body.
class DampingOfABody : public testing::TestWithParam<const char*> {};

TEST_P(DampingOfABody, LeavesOthersAlone) {
  BodySpec damped = plate(), free = plate();
  free.name = "free", free.transform.translate = {0, 5, 0};
  damped.damping = 1;
  for (BodySpec* body : {&damped, &free}) body->spin = {0, 0, 3}, body->transform.scale = {1, 1, 0.5};
  const auto elastic = [&](std::vector<BodySpec> bodies) {
    for (BodySpec& body : bodies) {
      body.constraints = {compliant("distance", 1e-2, {"edges", "shear"})};
      body.velocity = {1, 0, 0};
    }
    Scene scene = scene_of(bodies, {}, 0.01, 5);
    scene.solver.type = GetParam();
    return after(scene, 0.3).positions();
  };
  const std::vector<Vec3> both = elastic({damped, free}), alone = elastic({free});
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_LT(length(both[alone.size() + i] - alone[i]), 1e-9);
  double spread = 0;  // of the damped plate's lengths: zero, because it turns rigidly
  spread = std::abs(length(both[4] - both[0]) - 1);
  EXPECT_LT(spread, 0.02);
}
INSTANTIATE_TEST_SUITE_P(Under, DampingOfABody, testing::Values("pbd", "desbrun"));

Scene large_flag(Precision precision) {
  Scene scene = flag("pbd", precision);
  scene.bodies[0].shape = GridShape{{1.5, 1}, {255, 129}};  // beyond the grain of a launch
  return scene;
}

INSTANTIATE_TEST_SUITE_P(
    Air, SameBits,
    testing::Values(SameBitsScene{"Float", [](const auto&) { return large_flag(Precision::Float); }, 2, {1}},
                    SameBitsScene{"Double", [](const auto&) { return large_flag(Precision::Double); }, 2, {1}}),
    name_of_scene);

}  // namespace
}  // namespace malha
