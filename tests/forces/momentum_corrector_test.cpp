// SPDX-License-Identifier: Apache-2.0
// The momentum corrector of PBD and XPBD: free bodies keep both momenta, and external forces act unchanged.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <sstream>

#include "host/base/point_array.h"
#include "host/mesh/generate.h"
#include "host/model/model.h"
#include "kernels/forces/momenta.h"
#include "tests/mesh/mesh_files.h"
#include "tests/numbers.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

/// The sums over the particles 5 to 99, with packs of an instruction set.
template <class R, bool projected, class Isa>
MomentaSum sum_of_particles(const std::vector<Vec3> (&at)[3]) {
  const PointArray<Serial, R> x(at[0]), v(at[1]), d(at[2]);
  std::vector<R> w;
  for (const Vec3& a : at[0]) w.push_back(R(1 + std::abs(a[0])));
  const Particles<R> all{static_cast<int>(w.size()), x.points(), v.points(), {x.points(), d.points(), {}}, w.data()};
  const ParticleRange stretch{5, 100, 0, 5};
  MomentaSum sum{};
  using Measure = MeasureMomenta<R, R, projected, true>;
  alignas(64) char memory[Measure::kBytes];
  Measure{all, &stretch, &sum, R(0.001), R(1000)}(Group<Isa>{0, -1, memory});
  return sum;
}

TEST(MomentaSums, AreTheSameBitsWhateverAPackHoldsAndThoseOfTheParticles) {
  Random random(3);
  std::vector<Vec3> at[3];
  for (int i = 0; i < 128; ++i) {
    const Vector3<double> x = random.in_cube(), v = random.in_cube(3), d = random.in_cube(1e-5);
    at[0].push_back({x.x, x.y, x.z}), at[1].push_back({v.x, v.y, v.z});
    at[2].push_back({0.001 * v.x + d.x, 0.001 * v.y + d.y, 0.001 * v.z + d.z});
  }
  const auto expect_same = [&]<class R, bool projected>() {
    const MomentaSum narrow = sum_of_particles<R, projected, Baseline>(at);
    const MomentaSum wide = sum_of_particles<R, projected, Avx2>(at);
    const MomentaSum widest = sum_of_particles<R, projected, Avx512>(at);
    EXPECT_EQ(std::memcmp(&narrow, &wide, sizeof narrow), 0);
    EXPECT_EQ(std::memcmp(&narrow, &widest, sizeof narrow), 0);
    double L = 0, mass = 0;
    for (int i = 5; i < 105; ++i) {
      const double m = 1 / (1 + std::abs(at[0][i][0]));
      const auto place = [&](int k) { return at[0][i][k] + projected * at[2][i][k] - at[0][5][k]; };
      const auto velocity = [&](int k) { return (projected ? at[2][i][k] / 0.001 : at[1][i][k]) - at[1][5][k]; };
      mass += m, L += m * (place(0) * velocity(1) - place(1) * velocity(0));
    }
    // 100 numbers of up to 20 are rounded, and velocities are differences of positions over 0.001 s.
    const double rounding = sizeof(R) == 4 ? 1e-4 * (projected ? 100 : 1) : 1e-10;
    EXPECT_NEAR(narrow.m(), mass, rounding);
    EXPECT_NEAR(narrow.L()[2], L, rounding);
  };
  expect_same.operator()<float, false>(), expect_same.operator()<float, true>();
  expect_same.operator()<double, false>(), expect_same.operator()<double, true>();
}

struct RigidPart {
  double mass = 0;  // kg
  Vec3 linear{};    // kg m/s
  Vec3 spin{};      // kg m^2/s about the centre of mass
};

/// Mass and momenta of all particles.
RigidPart rigid_part(const Simulation& simulation) {
  const Model& model = simulation.model();
  const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
  RigidPart of;
  Vec3 centre{};
  std::vector<double> m(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) m[model.user_index[i]] = 1 / model.w[i];
  for (std::size_t i = 0; i < x.size(); ++i) {
    of.mass += m[i];
    for (int k = 0; k < 3; ++k) centre[k] += m[i] * x[i][k], of.linear[k] += m[i] * v[i][k];
  }
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      of.spin[k] += m[i] * ((x[i][a] - centre[a] / of.mass) * (v[i][b] - of.linear[b] / of.mass) -
                            (x[i][b] - centre[b] / of.mass) * (v[i][a] - of.linear[a] / of.mass));
    }
  return of;
}

class PbdCorrector : public MeshFiles {
 protected:
  /// A closed surface of 1 kg with triangles of all sizes and shapes, hence of unequal masses, that does not rotate
  /// about a principal axis.
  BodySpec lump(int subdivisions, std::vector<ConstraintSpec> constraints) const {
    const Mesh sphere = generate(SphereShape{0.5, subdivisions});
    Random random(7);
    std::ostringstream text;
    for (const Vec3& p : sphere.points) {
      const Vector3<double> off = random.in_cube(0.2 / std::sqrt(double(sphere.points.size())));
      text << "v " << p[0] + off.x << ' ' << 0.7 * (p[1] + off.y) << ' ' << 0.5 * (p[2] + off.z) << '\n';
    }
    for (const Quad& f : sphere.faces) text << "f " << f[0] + 1 << ' ' << f[1] + 1 << ' ' << f[2] + 1 << '\n';
    BodySpec body;
    body.name = "lump";
    body.shape = MeshFile{file("lump" + std::to_string(subdivisions) + ".obj", text.str())};
    body.mass = 1;
    body.constraints = std::move(constraints);
    return body;
  }
  /// The body in flight at 0.3 m/s, rotating at 5.6 rad/s, 20 m from the origin.
  BodySpec flying_lump(int subdivisions = 1) const {
    BodySpec body = lump(subdivisions, {compliant("distance", 1e-6, {"edges"}), compliant("bending", 0.1)});
    body.transform.translate = {20, 0.3, -0.2};
    body.velocity = {0.3, 0, 0}, body.spin = {0, 1.6, 5.4};
    return body;
  }
  static Scene corrected(Scene scene, bool corrects = true) {
    scene.solver.keeps_momenta = corrects;
    return scene;
  }
};

// A body that turns by half a radian in a substep gets corrections of more than a quarter of its elements. They go
// along the gradients at their end (kernels/projection/direction.h), and reduce its rotation by a fifth in 5 s.
TEST_F(PbdCorrector, RestoresMomentaThatLargeCorrectionsTake) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    BodySpec body = flying_lump();
    body.spin = {0, 0, 30};
    const Scene scene = scene_of({body}, {}, 1.0 / 60, 1, precision);
    const RigidPart before = rigid_part(Simulation(scene, {.threads = 1}));
    const auto taken = [&](bool corrects) {
      const RigidPart now = rigid_part(after(corrected(scene, corrects), 5));
      return length(now.spin - before.spin) / length(before.spin);
    };
    EXPECT_LT(taken(true), precision == Precision::Float ? 1e-5 : 1e-12);
    EXPECT_GT(taken(false), 0.15);
  }
}

TEST_F(PbdCorrector, KeepsWhatASpinningBodyKeepsForAMinuteAnyway) {
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    const Scene scene = scene_of({flying_lump()}, {}, 1.0 / 60, 20, precision);
    const RigidPart before = rigid_part(Simulation(scene, {.threads = 1}));
    const auto drift = [&](bool corrects) {
      const RigidPart now = rigid_part(after(corrected(scene, corrects), 60));
      return std::pair{length(now.linear - before.linear) / length(before.linear),
                       length(now.spin - before.spin) / length(before.spin)};
    };
    for (const bool corrects : {true, false}) {
      const auto [linear, angular] = drift(corrects);
      std::printf("a minute in %s, %s the corrector: momenta off by %.0e and %.0e of themselves\n",
                  precision == Precision::Float ? "float" : "double", corrects ? "with" : "without", linear, angular);
      // Rounding of velocities of 3 m/s, a random walk, over 0.3 m/s: in 3,600 steps 60 x 3 x 6e-8 in float; of 42
      // particles in 72,000 substeps, 16 projections each, 30 times that.
      const double rounding = (precision == Precision::Float ? 1e-4 : 1e-12) * (corrects ? 1 : 10);
      EXPECT_LT(linear, rounding);
      EXPECT_LT(angular, rounding);
    }
  }
}

// A rod of two masses turns in a step by the angle of its chord; its angular momentum is then restored.
TEST_F(PbdCorrector, LetsARodTurnForEver) {
  BodySpec rod;
  rod.name = "rod";
  rod.shape = ChainShape{{-0.5, 0, 0}, {0.5, 0, 0}, 1};
  rod.mass = 2, rod.spin = {0, 0, 5};
  rod.constraints = {stiff("distance", {"edges"})};
  Simulation simulation(corrected(scene_of({rod}, {}, 0.01)), {.threads = 1});
  const double before = rigid_part(simulation).spin[2];
  for (int step = 0; step < 1000; ++step) simulation.step();
  EXPECT_NEAR(rigid_part(simulation).spin[2], before, 1e-12);  // 1,000 steps of rounding
  EXPECT_LT(simulation.measure().strain_max, 1e-12);
  EXPECT_NEAR(simulation.measure().kinetic, 0.5 * 2 * 0.25 * 25, 0.5 * 2 * 0.25 * 25 * 0.05 * 0.05)
      << "all of it turning, but for what a chord differs from its arc";
}

TEST_F(PbdCorrector, LeavesFreeFallExact) {
  for (const bool damped : {false, true}) {
    BodySpec body = flying_lump();
    body.damping = damped ? 0.1 : 0;
    const Scene scene = corrected(scene_of({body}, kEarth, 1.0 / 60, 10));
    Simulation simulation(scene, {.threads = 1});
    const RigidPart before = rigid_part(simulation);
    run_for(simulation, scene, 1);
    const RigidPart now = rigid_part(simulation);
    EXPECT_LT(length(now.linear - Vec3{0.3, -9.81, 0}), 1e-12);
    EXPECT_LT(length(now.spin - before.spin), 1e-12);
  }
}

// Of n equal masses m each drag takes in a substep v' = (v + a u) / (1 + a), a = h b / m, and so of their momentum and
// of their spin about their centre, where there is no wind.
TEST_F(PbdCorrector, KeepsTheMomentumOfTheWind) {
  BodySpec body;
  body.name = "icosahedron";
  body.shape = SphereShape{0.5, 0};
  body.mass = 1.2;
  body.velocity = {0.3, 0, 0}, body.spin = {1, 5, 2};
  body.constraints = {stiff("distance", {"edges"})};
  Scene scene = corrected(scene_of({body}, {}, 1.0 / 60, 10));
  scene.wind = Wind{};
  scene.wind->velocity = {0, 3, 0}, scene.wind->drag = 0.01;
  const Vec3 spin = rigid_part(Simulation(scene, {.threads = 1})).spin;
  const RigidPart now = rigid_part(after(scene, 1));
  const double left = std::pow(1 + 0.01 / 0.1 / 600, -600);
  EXPECT_LT(length(now.linear - Vec3{1.2 * 0.3 * left, 1.2 * 3 * (1 - left), 0}), 1e-12);
  // The momentum that constraints lose in a step is restored at its end, so that drag misses half a step of it: of
  // omega^2 h dt = 8e-4 a share of b dt / (2 m) = 8e-4, in each of 60 steps.
  EXPECT_LT(length(now.spin - Vec3{spin[0] * left, spin[1] * left, spin[2] * left}), 1e-4 * length(spin));
}

TEST_F(PbdCorrector, LeavesPinnedAndAttachedBodiesAlone) {
  BodySpec pinned = flying_lump(), attached = flying_lump();
  pinned.pins = {ListPin{{0}}};
  Attachment attachment;
  attachment.at = ListPin{{3}}, attachment.compliance = 0.01;
  attached.attachments = {attachment};
  for (const BodySpec& body : {pinned, attached}) {
    const Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10, Precision::Float);
    EXPECT_EQ(after(corrected(scene), 0.2).state_hash(), after(scene, 0.2).state_hash());
  }
}

TEST_F(PbdCorrector, ActsOnEveryBodyByItself) {
  BodySpec left = flying_lump(), right = flying_lump();
  right.name = "right";
  right.transform.translate = {16, 1, 0}, right.velocity = {-2, 0, 1}, right.spin = {0, -7, 1};
  const auto positions = [](std::vector<BodySpec> bodies) {
    return after(corrected(scene_of(std::move(bodies), {}, 1.0 / 60, 10)), 0.5).positions();
  };
  const std::vector<Vec3> both = positions({left, right}), one = positions({left}), other = positions({right});
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_LT(length(both[i] - one[i]), 1e-12) << i;
    ASSERT_LT(length(both[i + one.size()] - other[i]), 1e-12) << i;
  }
}

TEST_F(PbdCorrector, GivesTheSameBitsOnAnyNumberOfThreads) {
  // 2,562 particles: several ranges of a reduction, the last one partial and no multiple of a pack
  BodySpec body = flying_lump(4);
  EnvironmentSpec ground = obstacle("ground", GridShape{{60, 60}, {1, 1}}, Sides::OneSided);
  ground.transform.translate = {-10, -0.3, -30};
  for (const bool contacts : {false, true})
    for (const Precision precision : {Precision::Float, Precision::Double}) {
      Scene scene = corrected(scene_of({body}, kEarth, 1.0 / 60, 4, precision));
      if (contacts) scene.environment = {ground};
      const std::uint64_t serial = after(scene, 0.04, {.threads = 1, .backend = Backend::Serial}).state_hash();
      for (const int threads : {1, 2, 3}) EXPECT_EQ(after(scene, 0.04, {.threads = threads}).state_hash(), serial);
      scene.solver.keeps_momenta = false;
      EXPECT_NE(after(scene, 0.04).state_hash(), serial);
    }
}

/// A flat crate on smooth or rough ground, already at rest.
class PuckWithACorrector : public PbdCorrector {
 protected:
  static Scene puck(double friction, const Vec3& velocity, const Vec3& spin) {
    BodySpec body;
    body.name = "puck";
    body.shape = BoxShape{{1, 0.2, 0.7}, {{4, 1, 3}}};
    body.mass = 1;
    body.constraints = {stiff("distance", {"edges", "shear"}), stiff("pressure")};
    body.velocity = velocity, body.spin = spin;
    EnvironmentSpec ground = obstacle("ground", GridShape{{40, 40}, {1, 1}}, Sides::OneSided);
    ground.friction = friction;
    ground.transform.translate = {-20, 0, -20};
    body.transform.translate = {0, 0.1 + ground.thickness, 0};
    Scene scene = scene_of({body}, kEarth, 1.0 / 60, 10);
    scene.environment = {ground};
    return scene;
  }
};

// Smooth ground pushes vertically alone: it adds no horizontal momentum and no torque about the vertical.
TEST_F(PuckWithACorrector, KeepsItsSpinOnSmoothGroundAndDoesNotSinkOrRise) {
  for (const int iterations : {1, 3})
    for (const bool corrects : {true, false}) {
      Scene scene = corrected(puck(0, {0.5, 0, 0}, {0, 4, 0}), corrects);
      scene.solver.iterations = iterations;
      const RigidPart before = rigid_part(Simulation(scene, {.threads = 1}));
      const Simulation simulation = after(scene, 2);
      const RigidPart now = rigid_part(simulation);
      EXPECT_GT(simulation.measure().contacts, 0);
      EXPECT_NEAR(now.linear[0], 0.5, 1e-9);
      EXPECT_NEAR(now.linear[1], 0, 0.02) << "m/s: gravity in a step is 0.16";
      EXPECT_NEAR(now.spin[1], before.spin[1], 1e-9 * before.spin[1]) << iterations << ", " << corrects;
    }
}

// A cube at rest: the sequential projections exert no torque about the vertical.
TEST_F(PuckWithACorrector, DoesNotBeginToTurnWhereItRests) {
  Scene scene = puck(0, {}, {});
  scene.bodies[0].shape = BoxShape{{0.5, 0.5, 0.5}, {{4, 4, 4}}};
  scene.bodies[0].transform.translate = {0, 0.26, 0};
  for (const bool corrects : {true, false})
    // kg m^2/s: 1,800 substeps round velocities of 0.02 m/s at most, and forces
    EXPECT_LT(std::abs(rigid_part(after(corrected(scene, corrects), 3)).spin[1]), 1e-11) << corrects;
}

// Coulomb's law: v0 - mu g t, whatever momentum the corrector restores to the body itself.
TEST_F(PuckWithACorrector, IsBrakedByFrictionAsWithoutIt) {
  const Scene scene = puck(0.2, {2, 0, 0}, {});
  const double with = rigid_part(after(corrected(scene), 0.5)).linear[0];
  const double without = rigid_part(after(scene, 0.5)).linear[0];
  EXPECT_NEAR(with, without, 0.01 * 0.2 * 9.81 * 0.5);
  EXPECT_NEAR(without, 2 - 0.2 * 9.81 * 0.5, 0.1 * 0.2 * 9.81 * 0.5);
}

}  // namespace
}  // namespace malha
