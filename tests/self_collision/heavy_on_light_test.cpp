// SPDX-License-Identifier: Apache-2.0
// Heavy blocks on light ones, with self-collision: a block that is laid on the other stays; one that falls on a light
// one slides off also in the reference, unless something damps it, and a warning names the ratio of masses from which
// on.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "host/mesh/generate.h"
#include "host/mesh/vectors.h"
#include "host/report/failure_boundaries.h"
#include "host/report/warnings.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kBlock = 0.2, kYoung = 1e6, kApart = 0.005;  // m, Pa, m: also the ground's thickness

/// A block of 4^3 cells of five tetrahedra, or the same with its inner points moved by up to a quarter of a cell.
Shape block_shape(bool even) {
  const TetBoxShape box{{kBlock, kBlock, kBlock}, {4, 4, 4}};
  if (even) return box;
  Mesh mesh = generate(box);
  Random random(3);
  for (Vec3& x : mesh.points) {
    const Vector3<double> off = random.in_cube(kBlock / 16);
    const double moves[3] = {off.x, off.y, off.z};
    for (int k = 0; k < 3; ++k)
      if (std::abs(x[k]) < 0.49 * kBlock) x[k] += moves[k];
  }
  return MeshDataShape{mesh.points, {}, {}, mesh.tetrahedra};
}

/// A block of 1 kg on rough ground, and one of `ratio` times the mass that falls on it from `drop` metres above.
Scene heavy_on_light(double ratio, double drop, Precision precision = Precision::Double, bool even = true) {
  BodySpec light, heavy;
  light.name = "light", heavy.name = "heavy";
  light.shape = heavy.shape = block_shape(even);
  light.mass = 1, heavy.mass = ratio;
  light.transform.translate = {0, kApart + kBlock / 2, 0};
  heavy.transform.translate = {0, 2 * kApart + 1.5 * kBlock + drop, 0};
  ConstraintSpec elastic{"neo_hookean", {}, 1, std::nullopt, 0.3};
  elastic.young_modulus = kYoung;
  light.constraints = heavy.constraints = {elastic};
  Scene scene = scene_of({light, heavy}, kEarth, 1.0 / 60, 100, precision);
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = GridShape{{8, 8}, {1, 1}}, ground.transform.translate = {-4, 0, -4};
  ground.sides = Sides::OneSided, ground.friction = 0.5, ground.thickness = kApart;
  scene.environment = {ground};
  scene.self_collision = SelfCollision{};
  scene.self_collision->thickness = kApart, scene.self_collision->friction = 0.5;
  return scene;
}
Scene in_thick_air(Scene scene) {
  scene.wind = Wind{};
  scene.wind->drag = worst_heavy_on_light(build_model(scene)).drag;
  return scene;
}

/// Measures of the upper block, whose particles all follow those of the lower one.
struct UpperBlock {
  double walked = 0;  // horizontal displacement of its centre of mass, m
  double height = 0, kinetic = 0;
};
UpperBlock upper_block(const Simulation& simulation) {
  const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
  const std::vector<double> w = simulation.inverse_masses();
  double mass = 0, at[3] = {};
  UpperBlock block;
  for (std::size_t i = simulation.particles_of_vertices(0).size(); i < x.size(); ++i) {
    mass += 1 / w[i], block.kinetic += dot(v[i], v[i]) / (2 * w[i]);
    for (int k = 0; k < 3; ++k) at[k] += x[i][k] / w[i];
  }
  block.walked = std::hypot(at[0], at[2]) / mass, block.height = at[1] / mass;
  return block;
}

/// The sag of the upper block's centre at rest if both are bars whose sides may widen: W L / (A E) of the lower one,
/// half of that of itself, and half of the lower one's own weight. Rough faces do not let them widen, which makes
/// blocks as high as wide 5 to 10 % stiffer.
double sinks_at_rest(double ratio) { return (1.5 * ratio + 0.5) * kG / (kBlock * kYoung); }

struct Laid {
  double ratio;
  Precision precision;
  bool even;
};
class HeavyOnLightAtRest : public testing::TestWithParam<Laid> {};

// It oscillates on its elastic support, which nothing damps; the mean is its rest position, and nothing pushes it
// sideways.
TEST_P(HeavyOnLightAtRest, StaysWhereItIs) {
  const auto& [ratio, precision, even] = GetParam();
  const Scene scene = heavy_on_light(ratio, 0, precision, even);
  Simulation simulation(scene, {.threads = 1});
  const double start = upper_block(simulation).height;
  double walked = 0, sunk = 0;
  constexpr int steps = 120;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    const UpperBlock now = upper_block(simulation);
    walked = std::max(walked, now.walked), sunk += (start - now.height) / steps;
  }
  std::printf("%g to 1: walked %.1e m, sunk %.2e m\n", ratio, walked, sunk);
  EXPECT_LT(walked, 0.01 * kBlock);
  // The mean is over a number of oscillations that is not whole: within 15 %.
  EXPECT_NEAR(sunk, 0.92 * sinks_at_rest(ratio), 0.15 * sinks_at_rest(ratio));
}
INSTANTIATE_TEST_SUITE_P(OfManyMasses, HeavyOnLightAtRest,
                         testing::Values(Laid{100, Precision::Double, true}, Laid{100, Precision::Double, false},
                                         Laid{100, Precision::Float, true}, Laid{10, Precision::Float, false}));

// With the drag that the warning names it stays there also when it falls, and comes to rest.
TEST(HeavyOnLight, RestsInTheAirThatTheWarningNames) {
  for (const double ratio : {10.0, 100.0}) {
    const Scene scene = in_thick_air(heavy_on_light(ratio, 0.024));
    EXPECT_TRUE(warnings(build_model(scene)).empty());
    Simulation simulation(scene, {.threads = 1});
    const double start = upper_block(simulation).height - 0.024;
    double walked = 0;
    while (simulation.time() < 3) simulation.step(), walked = std::max(walked, upper_block(simulation).walked);
    const UpperBlock end = upper_block(simulation);
    std::printf("%g to 1: walked %.1e m, sunk %.2e m, %.1e J\n", ratio, walked, start - end.height, end.kinetic);
    EXPECT_LT(walked, 0.01 * kBlock);
    EXPECT_LT(end.kinetic, 1e-4 * ratio * kG * 0.024) << "of what the fall gave";
    EXPECT_NEAR(start - end.height, 0.92 * sinks_at_rest(ratio), 0.08 * sinks_at_rest(ratio));
  }
}

bool warns_of_weight(const Scene& scene) {
  bool found = false;
  for (const std::string& line : warnings(build_model(scene)))
    found = found || (has(line, "'heavy'") && has(line, "'light'") && has(line, "\"drag\""));
  return found;
}

TEST(WarningOfHeavyOnLight, ComesFromTenTimesTheMassOnWhereItFalls) {
  EXPECT_TRUE(warns_of_weight(heavy_on_light(100, 0.024)));
  EXPECT_TRUE(warns_of_weight(heavy_on_light(10, 0.024)));
  const Scene again = heavy_on_light(10, 0.024);
  EXPECT_EQ(warnings(Simulation(again, {.threads = 1}).model()), warnings(build_model(again)));
  EXPECT_TRUE(warns_of_weight(heavy_on_light(10, 0.024, Precision::Float, false)));
  EXPECT_FALSE(warns_of_weight(heavy_on_light(9, 0.024)));
  EXPECT_FALSE(warns_of_weight(heavy_on_light(0.01, 0.024))) << "a light one on a heavy one";
  EXPECT_FALSE(warns_of_weight(heavy_on_light(100, 0))) << "laid on";

  Scene thrown = heavy_on_light(100, 0);
  thrown.bodies[1].velocity = {0, 1, 0};  // and so falls from 5 cm
  EXPECT_TRUE(warns_of_weight(thrown));
  Scene both = heavy_on_light(100, 0);  // laid on, but the lower one falls from 5 cm
  for (BodySpec& body : both.bodies) body.transform.translate[1] += 0.05;
  EXPECT_TRUE(warns_of_weight(both));
  Scene release = heavy_on_light(100, 0.024);
  Pin pin = BoxPin{{-1, 1.2 * kBlock, -1}, {1, 9, 1}};
  pin.release_time = 0.1;
  release.bodies[1].pins = {pin};
  EXPECT_TRUE(warns_of_weight(release));
  release.bodies[1].pins[0].release_time.reset();
  EXPECT_FALSE(warns_of_weight(release));
  Scene sideways = heavy_on_light(100, 0.024);  // the same, with gravity along z
  for (BodySpec& body : sideways.bodies)
    body.transform.translate = {0, body.transform.translate[0], body.transform.translate[1]};
  sideways.gravity = {0, 0, -kG}, sideways.environment[0].transform.axis = {1, 0, 0},
  sideways.environment[0].transform.degrees = 90, sideways.environment[0].transform.translate = {-4, 4, 0};
  EXPECT_TRUE(warns_of_weight(sideways));
  Scene desbrun = heavy_on_light(100, 0.024);
  desbrun.solver.type = "desbrun";
  EXPECT_TRUE(warns_of_weight(desbrun));
}

TEST(WarningOfHeavyOnLight, DoesNotComeWhereTheHeavyBodyCannotSlideOff) {
  const Scene scene = heavy_on_light(100, 0.024);
  Scene beside = scene, apart = scene, alone = scene, pinned = scene, rigid = scene, between = scene, floating = scene;
  beside.bodies[1].transform.translate[0] = 1.1 * kBlock;
  EXPECT_FALSE(warns_of_weight(beside));
  apart.self_collision.reset();
  EXPECT_FALSE(warns_of_weight(apart));
  alone.self_collision->bodies = {"heavy"};
  EXPECT_FALSE(warns_of_weight(alone));
  pinned.bodies[0].pins = {ListPin{{0, 1, 2, 3, 4}}};
  EXPECT_FALSE(warns_of_weight(pinned));
  rigid.bodies[0].damping = 1;
  EXPECT_FALSE(warns_of_weight(rigid));
  EXPECT_FALSE(warns_of_weight(in_thick_air(scene)));
  floating.environment.clear();
  EXPECT_FALSE(warns_of_weight(floating)) << "both fall alike";
  Scene drapes = scene;
  drapes.bodies[1].shape = GridShape{{kBlock, kBlock}, {4, 4}},
  drapes.bodies[1].constraints = {stiff("distance", {"edges"})};
  drapes.bodies[1].transform.translate = {-kBlock / 2, 2 * kBlock, -kBlock / 2};
  EXPECT_FALSE(warns_of_weight(drapes));
  // A third block is heavy enough to carry it, and lies on the light one.
  BodySpec third = scene.bodies[1];
  third.name = "third", third.mass = 9, third.transform.translate[1] = 2 * kApart + 1.5 * kBlock;
  between.bodies.push_back(third), between.bodies[1].transform.translate[1] += kBlock + kApart;
  EXPECT_FALSE(warns_of_weight(between));
}

TEST(WarningOfHeavyOnLight, IsGivenByEveryCommandThatTakesTheScene) {
  const TemporaryFolder folder;
  const auto block = [](const char* name, int kg, double height) {
    return R"({"name": ")" + std::string(name) +
           R"(", "shape": {"tet_box": {"size": [0.2, 0.2, 0.2], "cells": [2, 2, 2]}}, "mass": )" + std::to_string(kg) +
           R"(, "transform": {"translate": [0, )" + std::to_string(height) +
           R"(, 0]}, "constraints": [{"type": "neo_hookean", "young_modulus": 1e6}]})";
  };
  folder.write("scene.json", R"({"name": "blocks", "solver": {"type": "pbd", "dt": 0.0166667, "substeps": 80},
    "gravity": [0, -9.81, 0], "bodies": [)" +
                                 block("light", 1, 0.105) + ", " + block("heavy", 100, 0.334) + R"(],
    "environment": [{"name": "ground", "shape": {"grid": {"size": [8, 8], "cells": [1, 1]}}, "sides": "one_sided",
                     "transform": {"translate": [-4, 0, -4]}}],
    "self_collision": {"thickness": 0.005}, "duration": 0.1})");
  for (const char* command : {"check", "plan", "run"}) {
    const Ended ended = malha_command({command, "scene.json"}, folder / ".");
    EXPECT_EQ(ended.status, 0) << ended.err;
    const std::string& said = command == std::string("check") ? ended.out : ended.err;
    EXPECT_TRUE(has(said, "'heavy'") && has(said, "'light'")) << command << ": " << said;
  }
}

/// Reference: the same blocks as linear finite elements (compressible neo-Hookean, symplectic Euler), with springs
/// where their nodes and the ground touch: these open, and slip by Coulomb's law. Inside is Kelvin-Voigt damping of
/// this relaxation time (s). It uses nothing of malha's solver.
class BlocksOfElements {
 public:
  BlocksOfElements(double ratio, double drop, double relaxation) : viscosity_(relaxation * kYoung) {
    const Mesh mesh = generate(TetBoxShape{{kBlock, kBlock, kBlock}, {4, 4, 4}});
    each_ = mesh.points.size();
    for (const bool upper : {false, true}) {
      const std::size_t first = x_.size();
      for (const Vec3& x : mesh.points)
        x_.push_back({x[0], x[1] + kApart + kBlock / 2 + (upper ? kApart + kBlock + drop : 0), x[2]});
      m_.resize(x_.size()), v_.resize(x_.size(), Vec3{upper ? 1e-5 : 0, 0, upper ? 1e-6 : 0});
      for (const Tetrahedron& t : mesh.tetrahedra) {
        Part part;
        for (int j = 0; j < 4; ++j) part.node[j] = static_cast<int>(first) + t[j];
        const Vec3 a = edge(part, 0), b = edge(part, 1), c = edge(part, 2);
        const double six = dot(a, cross(b, c));
        part.volume = std::abs(six) / 6;
        const Vec3 rows[3] = {cross(b, c), cross(c, a), cross(a, b)};
        for (int k = 0; k < 3; ++k)
          for (int r = 0; r < 3; ++r) part.inverse[k][r] = rows[k][r] / six;
        for (const int i : part.node) m_[i] += (upper ? ratio : 1) * part.volume / (4 * kBlock * kBlock * kBlock);
        parts_.push_back(part);
      }
    }
    f_.resize(x_.size()), anchor_.resize(x_.size()), touches_.resize(x_.size());
    for (std::size_t i = 0; i < each_; ++i)
      for (std::size_t j = 0; j < each_; ++j)
        if (mesh.points[i][1] > 0.49 * kBlock && mesh.points[j][1] < -0.49 * kBlock &&
            mesh.points[i][0] == mesh.points[j][0] && mesh.points[i][2] == mesh.points[j][2])
          pairs_.push_back({i, each_ + j});
  }

  void go_on(double seconds) {
    constexpr double h = 4e-5;  // a tenth of a contact's period
    for (long long steps = std::llround(seconds / h); steps > 0; --steps) {
      for (std::size_t i = 0; i < x_.size(); ++i) f_[i] = {0, -kG * m_[i], 0};
      for (const Part& part : parts_) pull(part);
      for (std::size_t i = 0; i < each_; ++i) touch(i, nullptr, minus(x_[i], {0, kApart, 0}));
      for (const auto& [low, high] : pairs_) touch(high, &f_[low], minus(minus(x_[high], x_[low]), {0, kApart, 0}));
      for (std::size_t i = 0; i < x_.size(); ++i)
        for (int k = 0; k < 3; ++k) v_[i][k] += h * f_[i][k] / m_[i], x_[i][k] += h * v_[i][k];
    }
  }
  double walked() const {
    double mass = 0, at[2] = {};
    for (std::size_t i = each_; i < x_.size(); ++i) mass += m_[i], at[0] += m_[i] * x_[i][0], at[1] += m_[i] * x_[i][2];
    return std::hypot(at[0], at[1]) / mass;
  }

 private:
  struct Part {
    int node[4];
    double volume = 0, inverse[3][3];
  };
  Vec3 edge(const Part& part, int k) const { return minus(x_[part.node[k + 1]], x_[part.node[0]]); }

  void pull(const Part& part) {
    constexpr double mu = kYoung / 2.6, lambda = kYoung * 0.3 / (1.3 * 0.4);
    Vec3 F[3]{}, rate[3]{};  // columns
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k)
        for (int r = 0; r < 3; ++r) {
          F[c][r] += edge(part, k)[r] * part.inverse[k][c];
          rate[c][r] += (v_[part.node[k + 1]][r] - v_[part.node[0]][r]) * part.inverse[k][c];
        }
    const Vec3 cofactor[3] = {cross(F[1], F[2]), cross(F[2], F[0]), cross(F[0], F[1])};
    const double J = dot(F[0], cofactor[0]), p = (lambda * std::log(J) - mu) / J;
    for (int k = 0; k < 3; ++k)
      for (int r = 0; r < 3; ++r) {
        double stress = 0;
        for (int c = 0; c < 3; ++c)
          stress += (mu * F[c][r] + p * cofactor[c][r] + viscosity_ * rate[c][r]) * part.inverse[k][c];
        f_[part.node[k + 1]][r] -= part.volume * stress, f_[part.node[0]][r] += part.volume * stress;
      }
  }
  /// `apart`: distance beyond the thickness.
  void touch(std::size_t i, Vec3* other, const Vec3& apart) {
    constexpr double stiffness = 4e5, friction = 0.5;  // N/m of a node
    if (!(apart[1] < 0)) return void(touches_[i] = false);
    if (!touches_[i]) touches_[i] = true, anchor_[i] = apart;
    Vec3 force{stiffness * (anchor_[i][0] - apart[0]), -stiffness * apart[1], stiffness * (anchor_[i][2] - apart[2])};
    const double rubs = std::hypot(force[0], force[2]), most = friction * force[1];
    for (const int k : {0, 2}) {
      if (rubs > most) force[k] *= most / rubs, anchor_[i][k] = apart[k] + force[k] / stiffness;
    }
    for (int k = 0; k < 3; ++k) {
      f_[i][k] += force[k];
      if (other) (*other)[k] -= force[k];
    }
  }

  double viscosity_;
  std::size_t each_ = 0;
  std::vector<Vec3> x_, v_, f_, anchor_;
  std::vector<double> m_;
  std::vector<bool> touches_;
  std::vector<Part> parts_;
  std::vector<std::array<std::size_t, 2>> pairs_;
};

TEST(Figures, DISABLED_HeavyOnLight) {
  const auto walked = [](const Scene& scene) {
    Simulation simulation(scene, {.threads = 1});
    double most = 0;
    while (simulation.time() < 4) simulation.step(), most = std::max(most, upper_block(simulation).walked);
    return most;
  };
  const auto of_elements = [](double ratio, double drop, double relaxation) {
    BlocksOfElements blocks(ratio, drop, relaxation);
    double most = 0;
    for (int k = 0; k < 80; ++k) blocks.go_on(0.05), most = std::max(most, blocks.walked());
    return most;
  };
  std::printf("in 4 s the upper block walks by (m)\n%16s %10s %10s %10s %10s %10s\n", "", "laid on", "24 mm",
              "elements", "0.2 ms", "in air");
  for (const double ratio : {1.0, 3.0, 10.0, 30.0, 100.0}) {
    const Scene falls = heavy_on_light(ratio, 0.024);
    const double with_friction = of_elements(ratio, 0.024, 2e-4), air = walked(in_thick_air(falls));
    std::printf("%11g to 1: %10.1e %10.1e %10.1e %10.1e %10.1e\n", ratio, walked(heavy_on_light(ratio, 0)),
                walked(falls), of_elements(ratio, 0.024, 0), with_friction, air);
    EXPECT_LT(with_friction, 0.01 * kBlock);
    EXPECT_LT(air, 0.01 * kBlock);
  }
}

}  // namespace
}  // namespace malha
