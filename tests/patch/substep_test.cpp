// SPDX-License-Identifier: Apache-2.0
// Conservation and convergence of a substep of Position Based Dynamics: sweeps there and back, along the gradients
// where it began, on displacements (METHODS, section 8). The bounds follow from converged references and conserved
// quantities.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/mesh/irregular_sheet.h"
#include "tests/scene_builders.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A sheet of edges and both diagonals hardly shears and does not stretch: its rows of cells are rigid links with the
/// masses of their rows. Released from the horizontal, it is a chain of n links, integrated here in angles, in double,
/// by Runge-Kutta's fourth order. The result is the positions (z, y) of the rows after `time`.
std::vector<std::array<double, 2>> rows_of_a_chain(int n, double time, double dt) {
  const double a = 1.0 / n;
  Eigen::VectorXd m = Eigen::VectorXd::Constant(n, a), mu(n);
  m[n - 1] /= 2;
  for (int i = n - 1; i >= 0; --i) mu[i] = m[i] + (i + 1 < n ? mu[i + 1] : 0);
  const auto acceleration = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& w) {
    Eigen::MatrixXd M(n, n);
    Eigen::VectorXd right(n);
    for (int i = 0; i < n; ++i) {
      right[i] = -kG * a * mu[i] * std::cos(q[i]);
      for (int j = 0; j < n; ++j) {
        const double of = mu[std::max(i, j)] * a * a;
        M(i, j) = of * std::cos(q[i] - q[j]), right[i] -= of * std::sin(q[i] - q[j]) * w[j] * w[j];
      }
    }
    return Eigen::VectorXd(M.llt().solve(right));
  };
  Eigen::VectorXd q = Eigen::VectorXd::Zero(n), w = q;
  for (int k = 0; k < static_cast<int>(std::round(time / dt)); ++k) {
    const Eigen::VectorXd a1 = acceleration(q, w), a2 = acceleration(q + dt / 2 * w, w + dt / 2 * a1);
    const Eigen::VectorXd a3 = acceleration(q + dt / 2 * (w + dt / 2 * a1), w + dt / 2 * a2);
    const Eigen::VectorXd a4 = acceleration(q + dt * (w + dt / 2 * a2), w + dt * a3);
    q += dt * w + dt * dt / 6 * (a1 + a2 + a3), w += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  std::vector<std::array<double, 2>> rows{{0, 0}};
  for (int i = 0; i < n; ++i) rows.push_back({rows[i][0] + a * std::cos(q[i]), rows[i][1] + a * std::sin(q[i])});
  return rows;
}

/// RMS distance (m) between a sheet of 1 m, hung by its first row, and that chain half a second after its release.
double error_of_hung_sheet(int n, int substeps, const std::vector<std::array<double, 2>>& rows) {
  BodySpec sheet = body("sheet", GridShape{{1, 1}, {n, n}}, {constraint("distance")});
  sheet.constraints[0].elements = {"edges", "shear"};
  sheet.pins = {RowPin{}};
  Scene scene = scene_of({sheet});
  scene.gravity = kEarth, scene.solver.substeps = substeps;
  Simulation simulation(scene, {.threads = 1});
  for (int step = 0; step < 30; ++step) simulation.step();
  double sum = 0;
  const std::vector<Vec3> x = simulation.positions();
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const Vec3& at = x[i * (n + 1) + j];
      sum += std::pow(at[0] - double(j) / n, 2) + std::pow(at[1] - rows[i][1], 2) + std::pow(at[2] - rows[i][0], 2);
    }
  return std::sqrt(sum / static_cast<double>(x.size()));
}

TEST(Substep, TakesAHungSheetToWhereAChainOfItsRowsIs) {
  struct Row {
    int edges, substeps;
    double most;  // m, of a sheet of 1 m
  };
  // At first order, along the gradients at the end, errors were .026, .012, .0065; .10, .035, .012.
  for (const auto& [edges, rows] :
       {std::pair{16, rows_of_a_chain(16, 0.5, 1e-3)}, {46, rows_of_a_chain(46, 0.5, 5e-4)}}) {
    const std::vector<Row> bars = edges == 16 ? std::vector<Row>{{16, 10, 0.004}, {16, 20, 0.0025}, {16, 40, 0.0013}}
                                              : std::vector<Row>{{46, 10, 0.009}, {46, 20, 0.0045}, {46, 40, 0.0035}};
    for (const Row& row : bars) EXPECT_LT(error_of_hung_sheet(edges, row.substeps, rows), row.most) << row.substeps;
  }
}

/// Free sheets of 0.5 m, of squares and of irregular triangles.
std::vector<Shape> free_sheets(const TemporaryFolder& folder) {
  Random random(11);
  const std::string obj = irregular_sheet(0.5, 0.5, 16, 16, random);
  return {GridShape{{0.5, 0.5}, {16, 16}}, MeshFile{folder.write("sheet.obj", obj)}};
}

TEST(Substep, GivesAFreeSheetNoSpeedByItsSweeps) {
  const TemporaryFolder folder;
  for (const Shape& shape : free_sheets(folder))
    for (const std::vector<ConstraintSpec>& kinds :
         {std::vector{constraint("distance")}, {constraint("distance"), stiff("bending", {}, 0.02)}})
      for (const auto& [precision, substeps, most] : {std::tuple{Precision::Double, 10, 1e-12},
                                                      {Precision::Double, 160, 1e-11},
                                                      {Precision::Float, 10, 2e-4},
                                                      {Precision::Float, 160, 2e-3}}) {
        BodySpec sheet = body("sheet", shape, kinds);
        sheet.velocity = {0.01, 0.02, -0.005};  // without a velocity, double would have nothing to round
        Scene scene = scene_of({sheet});
        scene.solver.precision = precision, scene.solver.substeps = substeps;
        Simulation simulation(scene, {.threads = 1});
        const double seconds = substeps == 10 ? 4 : 1;  // one-way sweeps gained 0.1 to 1 m/s in that many substeps
        for (int step = 0; step < 60 * seconds; ++step) simulation.step();
        double gained = 0;
        for (const Vec3& v : simulation.velocities()) gained = std::max(gained, length(v - sheet.velocity));
        EXPECT_LT(gained, most) << substeps;
      }
}

/// kg m^2/s about the mass centre.
Vec3 spin_of(const Simulation& simulation, const std::vector<double>& mass) {
  const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
  Eigen::Vector3d c(0, 0, 0), u(0, 0, 0), L(0, 0, 0);
  double m = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    c += mass[i] * Eigen::Vector3d(x[i].data()), u += mass[i] * Eigen::Vector3d(v[i].data()), m += mass[i];
  c /= m, u /= m;
  for (std::size_t i = 0; i < x.size(); ++i)
    L += mass[i] * (Eigen::Vector3d(x[i].data()) - c).cross(Eigen::Vector3d(v[i].data()) - u);
  return {L[0], L[1], L[2]};
}

TEST(Substep, KeepsTheAngularMomentumOfAFreeBodyToRounding) {
  for (const auto& [precision, most] : {std::pair{Precision::Double, 1e-12}, {Precision::Float, 3e-5}})
    for (const std::vector<ConstraintSpec>& kinds :
         {std::vector{constraint("distance"), stiff("bending", {}, 0.1)},
          {compliant("distance", 1e-4, {"edges"}), constraint("pressure", 1.1)},
          {constraint("distance"), constraint("distance_limit", 0.1)}}) {
      Scene scene = scene_of({tumbling_ellipsoid(2, kinds)});
      scene.solver.precision = precision;
      Simulation simulation(scene, {.threads = 1});
      std::vector<double> mass;
      for (const double w : simulation.inverse_masses()) mass.push_back(1 / w);
      const Vec3 before = spin_of(simulation, mass);
      for (int step = 0; step < 600; ++step) simulation.step();
      EXPECT_LT(length(spin_of(simulation, mass) - before), most * length(before)) << kinds[1].type;
    }
}

TEST(Substep, TurnsNoSheetThatHangsByACorner) {
  BodySpec sheet = body("sheet", GridShape{{1, 1}, {16, 16}}, {constraint("distance")});
  sheet.constraints[0].elements = {"edges", "shear"};
  sheet.pins = {ListPin{{0}}};
  Scene scene = scene_of({sheet});
  scene.gravity = kEarth;
  Simulation simulation(scene, {.threads = 1});
  std::vector<double> mass;
  for (const double w : simulation.inverse_masses()) mass.push_back(w > 0 ? 1 / w : 0);
  double most = 0;  // kg m^2/s about the vertical through the corner
  for (int step = 0; step < 600; ++step) {
    simulation.step();
    const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
    double L = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      L += mass[i] * ((x[i][2] - x[0][2]) * v[i][0] - (x[i][0] - x[0][0]) * v[i][2]);
    most = std::max(most, std::abs(L));
  }
  // The sheet swings past the vertical: the force of its corner then acts partly along the gradients at the end.
  EXPECT_LT(most, 1e-3) << "0.02, and growing, along the gradients at the end";
}

TEST(Substep, StopsWhatSlidesWhereCoulombSaysHoweverFarFromTheOriginAndShort) {
  const double v = 3, mu = 0.5, truth = v * v / (2 * mu * kG);
  for (const double far : {0.0, 50.0})
    for (const int substeps : {10, 60, 160}) {
      BodySpec sheet = body("sheet", GridShape{{0.2, 0.2}, {4, 4}}, {constraint("distance")});
      sheet.velocity = {v, 0, 0}, sheet.transform.translate = {far, 1e-3, far};
      EnvironmentSpec ground = obstacle("ground", GridShape{{200, 200}, {1, 1}}, Sides::TwoSided);
      ground.transform.translate = {-20, 0, -20}, ground.friction = mu;
      Scene scene = scene_of({sheet}, {ground});
      scene.gravity = kEarth, scene.solver.substeps = substeps;
      Simulation simulation(scene, {.threads = 1});
      const double from = simulation.positions()[0][0];
      for (int step = 0; step < 60; ++step) simulation.step();  // it stops after 0.61 s
      EXPECT_NEAR((simulation.positions()[0][0] - from) / truth, 1, 0.03) << far << " m, " << substeps;
    }
}

TEST(Substep, IsAsGoodInFloatAsInDoubleTenKilometresAway) {
  std::vector<std::vector<Vec3>> places;
  for (const Precision precision : {Precision::Float, Precision::Double}) {
    BodySpec sheet = body("sheet", GridShape{{1, 1}, {10, 10}}, {constraint("distance")});
    sheet.pins = {RowPin{}}, sheet.transform.translate = {1e4, 1e4, -1e4};
    Scene scene = scene_of({sheet});
    scene.gravity = kEarth, scene.solver.precision = precision;
    Simulation simulation(scene, {.threads = 1});
    for (int step = 0; step < 30; ++step) simulation.step();
    places.push_back(simulation.positions());
  }
  for (std::size_t i = 0; i < places[0].size(); ++i) EXPECT_LT(length(places[0][i] - places[1][i]), 1e-3) << i;
}

// Three pins in a line: wherever the free corner is, both triangles lie in one plane through the line with it, and no
// displacement of it turns the hinge. The remaining gradient is rounding, and so is C.
TEST(AHingeWithPinsInALine, LeavesItsFreeCornerAlone) {
  for (const double slope : {0.0, 0.3, -2.1}) {
    const auto on_line = [&](double t) { return Vec3{t, slope * t, 0.7 * slope * t}; };
    BodySpec hinge =
        body("hinge",
             MeshDataShape{
                 {on_line(0), on_line(0.47), on_line(1), {0.41, 0.1, 0.53}}, {{0, 1, 3, -1}, {1, 2, 3, -1}}, {}, {}},
             {stiff("bending")});
    hinge.pins = {ListPin{{0, 1, 2}}};
    hinge.velocity = {1e-3, 7e-4, 3e-4};
    const Scene scene = scene_of({hinge}, {}, 1.0 / 60, 10, Precision::Double);
    EXPECT_NEAR(after(scene, 0.1).measure().speed_max, length(hinge.velocity), 1e-12) << slope;
  }
}

// Without a multiplier of one sign, and with fixed directions across a fold of no length, the vector of the fold kept
// such a sheet moving at 4.5 mm/s for good.
TEST(APinnedSheetOfAnIrregularMesh, RestsInAirWithEveryBending) {
  const TemporaryFolder folder;
  for (const std::string kind : {"bending", "isometric_bending", "plate"}) {
    BodySpec sheet = body("sheet", MeshFile{folder.write("sheet.obj", irregular_obj(1, 1, 7, 7, 0.3, 5))},
                          {stiff("distance", {"edges"}), stiff(kind)});
    sheet.constraints[1].rigidity = 0.01;
    if (kind == "plate") sheet.constraints[1].parameter = 0;
    sheet.pins = {ListPin{{0, 7}}};
    Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 20, Precision::Double);
    scene.wind = Wind{{0, 0, 0}, 6.0 / 64};
    EXPECT_LT(after(scene, 20).measure().speed_max, 1e-9) << kind;
  }
}

/// The largest speed of a particle after any step of `time` s, m/s.
double fastest_ever(const Scene& scene, double time) {
  Simulation simulation(scene, {.threads = 1});
  double most = 0;
  while (simulation.time() < time) simulation.step(), most = std::max(most, simulation.measure().speed_max);
  return most;
}

// With levels in every second substep it reached 5.3 km/s.
TEST(AFlagInAStorm, IsNotThrownFasterThanTwiceTheWind) {
  BodySpec flag = body("flag", GridShape{{1.5, 1}, {45, 30}}, {constraint("distance"), constraint("bending", 1)});
  flag.constraints[0].elements = {"edges", "shear"}, flag.constraints[1].stiffness = 0.02;
  flag.mass = 0.225;
  flag.transform.axis = {1, 0, 0}, flag.transform.degrees = 90;
  flag.pins = {BoxPin{{-1e-3, -2, -2}, {1e-3, 2, 2}}};
  for (const double wind : {60., 300., 3000.}) {
    Scene scene = scene_of({flag});
    scene.gravity = kEarth, scene.solver.substeps = 20;
    scene.wind = Wind{{wind, 0, wind * 2 / 9}, 1.2};
    ASSERT_FALSE(Simulation(scene, {.threads = 1}).solver().facts().levels.empty());
    // A particle that is whipped round is thrown ahead: an elastic impact gives it twice the wind's speed.
    EXPECT_LT(fastest_ever(scene, 2), 2 * wind) << wind;
  }
}

// The gradient of a stiff angle whose triangles are crushed and stretched changes by more than its size. With the
// directions of the start alone this sheet reached 247 m/s, and 2.8 km/s with 160 substeps.
TEST(HardFolds, DoNotDriveASoftSheetThatIsTornAbout) {
  BodySpec sheet =
      body("sheet", GridShape{{0.738, 0.72324}, {13, 26}}, {stiff("distance", {"edges"}), stiff("bending")});
  sheet.constraints[0].stiffness = 0.32;
  sheet.transform.axis = {1.562, -0.153, 0.355}, sheet.transform.degrees = 40;
  constexpr double kPull = 12.3;  // m/s, of the pins
  sheet.pins = {ListPin{{0, 1, 2, 3, 4, 5}}};
  sheet.pins[0].motion = {{0.3}, {0.51, {-0.84, 1.75, 1.68}}}, sheet.pins[0].release_time = 1.5;
  Scene scene = scene_of({sheet}, kEarth, 1.0 / 60, 40, Precision::Double);
  // A whip's end: it has 60 to 140 m/s, whatever the substeps from 36 to 44, because the motion is chaotic.
  EXPECT_LT(fastest_ever(scene, 2.5), 12 * kPull);
}

/// An irregular sheet of 1 m with a pinned boundary, 1.1 to 2 times as wide as its constraints are long.
Scene drum(const TemporaryFolder& folder, unsigned seed, const ConstraintSpec& distance, int substeps, int iterations) {
  const std::string name = "drum" + std::to_string(seed) + ".obj";
  BodySpec sheet = body("drum", MeshFile{folder.write(name, irregular_obj(1, 1, 12, 12, 0.25, seed))}, {distance});
  sheet.mass = 0.2;
  constexpr double kWide = 1e-6;
  sheet.pins = {BoxPin{{-kWide, -1, -1}, {kWide, 1, 2}}, BoxPin{{1 - kWide, -1, -1}, {1 + kWide, 1, 2}},
                BoxPin{{-1, -1, -kWide}, {2, 1, kWide}}, BoxPin{{-1, -1, 1 - kWide}, {2, 1, 1 + kWide}}};
  Scene scene = scene_of({sheet}, {0, 0, 0}, 1.0 / 60, substeps, Precision::Double);
  scene.solver.iterations = iterations;
  return scene;
}

double fastest(const std::vector<Vec3>& v) {
  double most = 0;
  for (const Vec3& one : v) most = std::max(most, length(one));
  return most;
}

// With the directions of the start alone, whatever the force of a constraint, taut sheets oscillated: at 14 m/s with
// one iteration, at 26 to 33 with several, and more with more substeps. With a switch from one direction to the other,
// 1 to 20 m/s remained.
TEST(TautSheets, ComeToRestFromABlow) {
#if !defined(NDEBUG)
  GTEST_SKIP() << "a minute without optimisation";
#endif
  const TemporaryFolder folder;
  for (const double compliance : {0.0, 1e-4, 1e-3})
    for (const double part : {0.9, 0.8, 0.5})
      for (const unsigned seed : {1u, 2u, 5u})
        for (const auto& [substeps, iterations] : {std::pair{10, 1}, {40, 1}, {10, 2}, {10, 3}, {10, 10}}) {
          ConstraintSpec distance = with_compliance("distance", compliance, part);
          if (compliance == 0) distance = stiff("distance", {"edges"}), distance.parameter = part;
          Simulation simulation(drum(folder, seed, distance, substeps, iterations), {.threads = 1});
          simulation.step();
          std::vector<Vec3> v = simulation.velocities();
          Random random(seed);
          for (Vec3& one : v)
            for (double& axis : one) axis += random(-1e-3, 1e-3);
          simulation.set_velocities(v);
          // With a compliance the sheet oscillates by what the blow gave; without, an edge at a bound may still jitter.
          while (simulation.time() < 4) simulation.step();
          EXPECT_LT(fastest(simulation.velocities()), compliance > 0 || iterations > 1 ? 0.02 : 1e-4)
              << compliance << " m/N, " << part << ", seed " << seed << ", " << substeps << " x " << iterations;
        }
}

// The same for a cloth in still air that is pulled to 1.4 times its length: it kept 3 to 50 m/s for good.
TEST(TautSheets, ComeToRestWhenPinsHavePulledThem) {
#if !defined(NDEBUG)
  GTEST_SKIP() << "a minute without optimisation";
#endif
  const TemporaryFolder folder;
  const std::string mesh = folder.write("cloth.obj", irregular_obj(1, 1, 16, 16, 0.25, 3));
  ConstraintSpec membrane;
  membrane.type = "membrane", membrane.young_modulus = 1e4, membrane.parameter = 0.3;
  for (const ConstraintSpec& kind : {stiff("distance", {"edges"}), with_compliance("distance", 1e-4), membrane})
    for (const auto& [substeps, iterations] : {std::pair{10, 1}, {40, 1}, {10, 3}}) {
      BodySpec cloth = body("cloth", MeshFile{mesh}, {kind});
      cloth.mass = 0.2;
      constexpr double kWide = 1e-6, kPull = 0.4;
      cloth.pins = {BoxPin{{-kWide, -1, -1}, {kWide, 1, 2}}, BoxPin{{1 - kWide, -1, -1}, {1 + kWide, 1, 2}}};
      cloth.pins[1].motion = {{0}, {1, {kind.type == "membrane" ? kPull / 2 : kPull, 0, 0}}};
      Scene scene = scene_of({cloth}, kEarth, 1.0 / 60, substeps, Precision::Float);
      scene.solver.iterations = iterations, scene.wind = Wind{{0, 0, 0}, 0, 1.2};
      Simulation simulation(scene, {.threads = 1});
      while (simulation.time() < 5) simulation.step();
      // An edge at the bound between both directions still jitters by a hundredth of a millimetre.
      EXPECT_LT(fastest(simulation.velocities()), 0.1) << kind.type << ", " << substeps << " x " << iterations;
    }
}

// A cloth that is stretched along shrinks across. While its compressed edges went along their directions at the moment,
// which gives energy to motion across them, it flapped at 5 to 50 m/s for good.
TEST(TautSheets, ComeToRestAlthoughTheyShrinkAcross) {
#if !defined(NDEBUG)
  GTEST_SKIP() << "a minute without optimisation";
#endif
  const TemporaryFolder folder;
  const std::string irregular = folder.write("cloth.obj", irregular_obj(1, 1, 16, 16, 0.25, 3));
  const std::pair<Shape, std::vector<std::string>> cloths[] = {{GridShape{{1, 1}, {12, 12}}, {"edges", "shear"}},
                                                               {GridShape{{1, 1}, {20, 20}}, {"edges", "shear"}},
                                                               {MeshFile{irregular}, {"edges"}}};
  for (const auto& [shape, elements] : cloths)
    for (const double pull : {0.1, 0.2})
      for (const auto& [substeps, iterations] : {std::pair{10, 1}, {40, 1}, {10, 4}}) {
        BodySpec cloth = body("cloth", shape, {stiff("distance", elements)});
        cloth.mass = 0.15;
        constexpr double kWide = 1e-6;
        cloth.pins = {BoxPin{{-kWide, -1, -1}, {kWide, 1, 2}}, BoxPin{{1 - kWide, -1, -1}, {1 + kWide, 1, 2}}};
        cloth.pins[1].motion = {{0}, {1, {pull, 0, 0}}};
        Scene scene = scene_of({cloth}, kEarth, 1.0 / 60, substeps, Precision::Double);
        scene.solver.iterations = iterations;
        Simulation simulation(scene, {.threads = 1});
        while (simulation.time() < 5) simulation.step();
        EXPECT_LT(fastest(simulation.velocities()), 0.1)
            << simulation.positions().size() << " particles, " << pull << ", " << substeps << " x " << iterations;
      }
}

// With the directions of the start alone this cloth gained .26 J.
TEST(SeveralIterations, GiveAHungClothNothing) {
#if !defined(NDEBUG)
  GTEST_SKIP() << "a minute without optimisation";
#endif
  BodySpec cloth = body("cloth", GridShape{{1, 1}, {46, 46}}, {stiff("distance", {"edges", "shear"})});
  cloth.mass = 0.2, cloth.pins = {ListPin{{0}}};
  Scene scene = scene_of({cloth}, kEarth, 1.0 / 60, 10, Precision::Double);
  scene.solver.iterations = 10;
  Simulation simulation(scene, {.threads = 1});
  const double at_start = simulation.measure().energy();
  while (simulation.time() < 5) {
    simulation.step();
    ASSERT_LT(simulation.measure().energy(), at_start + 1e-3 * 0.2 * kG) << simulation.time();
  }
}

// Face normals for air are differences of positions, which lose digits far away: the sheet was .14 m off after two
// seconds.
TEST(Wind, BlowsInFloatAsInDoubleTenKilometresAway) {
  const auto after_two_seconds = [](Precision precision) {
    BodySpec cloth = body("cloth", GridShape{{0.4, 0.4}, {16, 16}}, {stiff("distance", {"edges", "shear"})});
    cloth.mass = 0.032, cloth.pins = {RowPin{}};
    cloth.transform.translate = {1e4, 0, 0};
    Scene scene = scene_of({cloth}, kEarth, 1.0 / 60, 10, precision);
    scene.wind = Wind{{0, 0, 1}, 1.2};
    return after(scene, 2).positions();
  };
  const auto near = after_two_seconds(Precision::Float), exact = after_two_seconds(Precision::Double);
  double farthest = 0;
  for (std::size_t i = 0; i < near.size(); ++i) farthest = std::max(farthest, length(near[i] - exact[i]));
  EXPECT_LT(farthest, 2e-3) << "two spacings of float there";
}

}  // namespace
}  // namespace malha
