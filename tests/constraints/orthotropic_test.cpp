// SPDX-License-Identifier: Apache-2.0
// Sheets and plates of two moduli: their energies, and the moduli that strips on irregular triangles show in every
// direction by both methods.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "host/measure/measure.h"
#include "host/mesh/generate.h"
#include "host/model/coarsening_graph.h"
#include "malha/fabrics.h"
#include "malha/simulation.h"
#include "tests/constraints/cantilever.h"
#include "tests/constraints/uneven_sheet.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/refusal.h"

namespace malha {
namespace {

constexpr double kAcross = 0.3, kShearOver = 0.05, kNu12 = 0.4;  // E_2 / E_1, G_12 / E_1, and nu_12

Vec3 direction_in_xy(double angle) { return {std::cos(angle), std::sin(angle), 0}; }

ConstraintSpec woven(double E1, double angle) {
  ConstraintSpec spec = membrane(E1, kNu12);
  spec.orthotropy = Orthotropy{kAcross * E1, kShearOver * E1, direction_in_xy(angle)};
  return spec;
}

/// 1 / E(theta) of the closed form (Lekhnitskii, "Theory of elasticity of an anisotropic body", 1963), for E_1 = 1.
double compliance_at(double angle) {
  const double c2 = std::pow(std::cos(angle), 2), s2 = 1 - c2;
  return c2 * c2 + (1 / kShearOver - 2 * kNu12) * c2 * s2 + s2 * s2 / kAcross;
}

double orthotropic_energy(const Model& model, const std::vector<Vec3>& x) {
  Measures measures;
  measure_constraints(Serial{}, model, x, measures);
  return measures.elastic;
}

/// The compliance matrix of strains (e_xx, e_yy, 2 e_xy) whose first axis of the material is at `angle`, for E_1 = 1.
Eigen::Matrix3d compliance_matrix(double angle) {
  Eigen::Matrix3d own, turn;
  own << 1, -kNu12, 0, -kNu12, 1 / kAcross, 0, 0, 0, 1 / kShearOver;
  const double c = std::cos(angle), s = std::sin(angle);
  turn << c * c, s * s, 2 * c * s, s * s, c * c, -2 * c * s, -c * s, c * s, c * c - s * s;  // stresses to those axes
  return turn.transpose() * own * turn;
}

TEST(OrthotropicMembrane, StoresTheEnergyOfItsMatrixInEveryDirection) {
  const TemporaryFolder folder;
  const MeshFile mesh = written(folder, uneven_sheet(2, 0.5, 8, 3, 2));
  const double E1 = 30;
  Random random(3);
  for (const std::string method : {"pbd", "desbrun"})
    for (double angle = 0; angle < 3.1; angle += 0.4) {
      BodySpec body;
      body.name = "sheet", body.mass = 1, body.shape = mesh, body.constraints = {woven(E1, angle)};
      Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60);
      scene.solver.type = method;
      const Model model = build_model(scene);
      for (int k = 0; k < 10; ++k) {
        // A symmetric stretch, turned in space.
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(random(-3, 3), Eigen::Vector3d(1, 2, -2).normalized()).matrix();
        const Eigen::Vector3d e(random(-0.2, 0.2), random(-0.2, 0.2), random(-0.2, 0.2));
        std::vector<Vec3> x;
        for (const Vec3& X : model.x) {
          const Eigen::Vector3d at =
              turn * Eigen::Vector3d(X[0] + e[0] * X[0] + e[2] / 2 * X[1], X[1] + e[1] * X[1] + e[2] / 2 * X[0], 0);
          x.push_back({at[0], at[1], at[2]});
        }
        const double expected = E1 * 2 * 0.5 / 2 * e.dot(compliance_matrix(angle).inverse() * e);
        EXPECT_NEAR(orthotropic_energy(model, x) / expected, 1, 1e-11) << method << ", " << angle;
      }
    }
}

TEST(OrthotropicMembrane, OfEqualModuliIsTheIsotropicOne) {
  const TemporaryFolder folder;
  Random random(4);
  const auto energy_of = [&](const ConstraintSpec& spec) {
    BodySpec body;
    body.name = "sheet", body.mass = 1, body.constraints = {spec};
    body.shape = written(folder, uneven_sheet(1, 1, 4, 4, 2));
    const Model model = build_model(scene_of({body}, {0, 0, 0}, 1.0 / 60));
    std::vector<Vec3> x = model.x;
    Random off(5);
    for (Vec3& at : x)
      for (double& a : at) a += off(-0.05, 0.05);
    return orthotropic_energy(model, x);
  };
  for (const double nu : {0.0, 0.3, 0.7}) {
    ConstraintSpec two = membrane(20, nu);
    two.orthotropy = Orthotropy{20, {}, direction_in_xy(random(-3, 3))};  // the shear modulus is Huber's
    EXPECT_NEAR(energy_of(two) / energy_of(membrane(20, nu)), 1, 1e-12) << nu;
    ConstraintSpec bends = stiff("plate", {}, 1, nu), both = bends;
    bends.rigidity = both.rigidity = 1e-3;
    both.orthotropy = Orthotropy{1e-3, {}, direction_in_xy(random(-3, 3))};
    EXPECT_NEAR(energy_of(both) / energy_of(bends), 1, 1e-9) << nu;
  }
}

struct StretchCase {
  const char* method;
  int degrees;
};
class WovenStrip : public testing::TestWithParam<StretchCase> {};

/// A strip hangs by its upper edge, as IrregularMembrane of membrane_moduli_test.cpp. Away from the axes tension brings
/// about shear, and what a clamp would disturb decays slowly: its particles are pinned where the exact field has them,
///   u_x = a (L + y) x + c (L y + y^2 / 2), u_y = b (L y + y^2 / 2) - a x^2 / 2, (a, b, c) the strains over L + y,
/// so that the edge contracts and curves freely. The lean c (L y + y^2 / 2) is given to all particles at the start,
/// because bending in the plane is ten times as slow as stretch; the strip keeps it only if it is in balance.
TEST_P(WovenStrip, ShowsTheModulusOfItsDirection) {
  const auto& [method, degrees] = GetParam();
  constexpr double L = 1, W = 0.2, cell = 0.04, E1 = 100, density = 0.2;
  const double angle = degrees * kPi / 180, theta = kPi / 2 - angle;  // of u with the direction of the pull, y
  const double E = E1 / compliance_at(theta), gravity = 0.01 * E / (density * L);
  const TemporaryFolder folder;
  const Mesh mesh = uneven_sheet(W, L, 5, 25, 4);
  BodySpec body;
  body.name = "strip", body.density = density, body.constraints = {woven(E1, angle)},
  body.shape = written(folder, mesh);
  body.pins = {upper_edge(mesh)};
  const double swing = kPi / 2 * std::sqrt(E / density) / L, wave = std::sqrt(1.2 * E1 / density);
  const bool by_pbd = std::string(method) == "pbd";
  const double h = by_pbd ? 0.02 * cell / wave : 0.5 / swing;
  Scene scene = scene_of({body}, {0, -gravity, 0}, by_pbd ? 100 * h : h, by_pbd ? 100 : 1);
  scene.solver.type = method;
  if (!by_pbd) scene.solver.desbrun.refinement_iterations = 10;
  scene.wind = Wind{{0, 0, 0}, 2 * swing * density * area_of(mesh) / static_cast<double>(mesh.points.size())};
  Simulation simulation(scene, {.threads = 1});
  const Eigen::Matrix3d at = compliance_matrix(angle);
  const Eigen::Vector3d strain = at.col(1) * (density * gravity / E1);  // per length that hangs below
  std::vector<Vec3> start = mesh.points;
  for (Vec3& p : start) {
    const double across = p[0] - W / 2, y = p[1];
    p[0] += strain[2] * (L * y + y * y / 2);
    if (y == 0) p[0] += strain[0] * L * across, p[1] -= strain[0] * across * across / 2;
  }
  simulation.set_positions(start);
  run_for(simulation, scene, 15 / swing);
  const std::vector<Vec3> x = simulation.positions();
  double along = 0, across = 0, shear = 0, depth = 0, sum = 0;
  for (const Quad& t : mesh.faces) {
    double y = 0;
    for (int k = 0; k < 3; ++k) y += mesh.points[t[k]][1] / 3;
    if (y < -0.7 * L || y > -0.4 * L) continue;  // away from the pins, and from the free edge
    const Eigen::Matrix<double, 3, 2> F = gradient_of(mesh.points, x, t);
    const double A = area_of(mesh.points, t);
    // In the frame of the sheet, which the shear may have turned.
    const Eigen::Matrix2d S = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(F.transpose() * F).operatorSqrt();
    sum += A, depth -= A * y;
    along += A * (S(1, 1) - 1), across += A * (S(0, 0) - 1), shear += A * 2 * S(0, 1);
  }
  along /= sum, across /= sum, shear /= sum, depth /= sum;
  const double shows = density * gravity * (L - depth) / along / E;
  std::printf("%s, %d degrees: shows %.4f of E(theta), ratios %.3f (%.3f) across and %.3f (%.3f) in shear\n", method,
              degrees, shows, across / along, at(0, 1) / at(1, 1), shear / along, at(2, 1) / at(1, 1));
  EXPECT_NEAR(shows, 1, 0.01);
  EXPECT_NEAR(across / along, at(0, 1) / at(1, 1), 0.01);
  EXPECT_NEAR(shear / along, at(2, 1) / at(1, 1), 0.02) << "strains of 1 %";
}
INSTANTIATE_TEST_SUITE_P(, WovenStrip,
                         testing::Values(StretchCase{"pbd", 0}, StretchCase{"pbd", 30}, StretchCase{"pbd", 45},
                                         StretchCase{"pbd", 90}, StretchCase{"desbrun", 0}, StretchCase{"desbrun", 45},
                                         StretchCase{"desbrun", 90}),
                         [](const auto& tested) {
                           return std::string(tested.param.method) + std::to_string(tested.param.degrees);
                         });

constexpr double kD2 = 0.2, kD66 = 0.12, kNuOfPlate = 0.5;  // over D_1

ConstraintSpec woven_plate(double D1, double angle) {
  ConstraintSpec spec = stiff("plate", {}, 1, kNuOfPlate);
  spec.rigidity = D1;
  spec.orthotropy = Orthotropy{kD2 * D1, kD66 * D1, Vec3{std::cos(angle), 0, std::sin(angle)}};
  return spec;
}
double rigidity_at(double angle) {
  const double c2 = std::pow(std::cos(angle), 2), s2 = 1 - c2;
  return c2 * c2 + 2 * (kNuOfPlate * kD2 + 2 * kD66) * c2 * s2 + kD2 * s2 * s2;
}

TEST(OrthotropicPlate, HasTheEnergyOfACylinderInEveryDirectionOnIrregularTriangles) {
  const TemporaryFolder folder;
  constexpr double kappa = 1e-3;  // 1/m, so small that the slope is small beside the error to measure
  for (const Diagonals diagonals : {Diagonals::Random, Diagonals::Delaunay, Diagonals::Alike}) {
    double worst = 0;
    for (const double along : {0.0, 0.5, 2.0}) {
      BodySpec body;
      body.name = "sheet", body.mass = 1, body.constraints = {woven_plate(1, along)};
      body.shape = MeshFile{folder.write("sheet.obj", irregular_obj(1, 1, 45, 45, 0.3, 3, 0, diagonals))};
      const Model model = build_model(scene_of({body}, {0, 0, 0}, 1.0 / 60));
      for (double bent = 0; bent < 3.1; bent += kPi / 12) {
        std::vector<Vec3> x = model.x;
        for (Vec3& at : x) at[1] = kappa / 2 * std::pow(at[0] * std::cos(bent) + at[2] * std::sin(bent), 2);
        const double energy = orthotropic_energy(model, x) / (kappa * kappa / 2);
        worst = std::max(worst, std::abs(energy / rigidity_at(bent - along) - 1));
      }
    }
    std::printf("orthotropic plate, diagonals %d: energy within %.2f %%\n", int(diagonals), 100 * worst);
    // Where diagonals do not follow the points, hinges stand for many triangles without a fit; the error is of
    // D(theta), which falls to a fifth of D_1.
    EXPECT_LT(worst, diagonals == Diagonals::Random ? 0.03 : 0.02) << int(diagonals);
  }
}

struct SagCase {
  const char* method;
  int degrees;
};
class WovenCantilever : public testing::TestWithParam<SagCase> {};

/// A wide strip that bends to a cylinder sags as a beam of the rigidity of its direction. Its material has Poisson's
/// ratio 0, so that its sides do not curl, and at 45 degrees a twist couples with the bending, which the clamp and the
/// width prevent in part: there the energy above is the test.
TEST_P(WovenCantilever, SagsByTheRigidityOfItsDirection) {
  const auto& [method, degrees] = GetParam();
  const TemporaryFolder folder;
  constexpr double L = 0.4, W = 0.2, sag = 0.05 * L;
  const double free = L - L / 12, D = 0.2 * 9.81 * std::pow(free, 4) / (8 * sag);  // of its direction
  const Cantilever strip{
      MeshFile{folder.write("strip.obj", irregular_obj(W, L, 6, 12, 0.25, 7, 2, Diagonals::Delaunay))}, W, L, 6, 12};
  ConstraintSpec plate = stiff("plate", {}, 1, 0);  // the strip runs along z
  plate.rigidity = degrees == 0 ? D : 5 * D;
  plate.orthotropy =
      Orthotropy{degrees == 0 ? 5 * D : D, D, Vec3{degrees == 0 ? 0.0 : 1.0, 0, degrees == 0 ? 1.0 : 0.0}};
  const double shows = sag_of(strip, plate, D, method);
  std::printf("%s, %d degrees: sags %.1f %% too far\n", method, degrees, 100 * (shows / sag - 1));
  EXPECT_NEAR(shows / sag, 1, 0.07);
}
INSTANTIATE_TEST_SUITE_P(, WovenCantilever,
                         testing::Values(SagCase{"pbd", 0}, SagCase{"pbd", 90}, SagCase{"desbrun", 0},
                                         SagCase{"desbrun", 90}),
                         [](const auto& tested) {
                           return std::string(tested.param.method) + std::to_string(tested.param.degrees);
                         });

/// The tip of a strip clamped at z = 0 after a third of a second, by bending through the filter.
double filtered_tip(double D_along, double D_across, bool two) {
  const TemporaryFolder folder;
  BodySpec body;
  body.name = "strip", body.density = 0.2;
  body.shape = MeshFile{folder.write("strip.obj", irregular_obj(0.2, 0.4, 6, 12, 0.25, 7, 2, Diagonals::Delaunay))};
  ListPin held;
  for (int i = 0; i < 14; ++i) held.particles.push_back(i);
  body.pins = {held};
  ConstraintSpec plate = stiff("plate", {}, 1, 0);
  plate.rigidity = D_along;
  if (two) plate.orthotropy = Orthotropy{D_across, std::sqrt(D_along * D_across) / 2, Vec3{0, 0, 1}};
  body.constraints = {membrane(2000, 0.3), plate};
  Scene scene = scene_of({body}, kEarth, 1.0 / 60, 20);
  scene.solver.bending = BendingMethod::Filtered;
  Simulation simulation(scene, {.threads = 1});
  EXPECT_FALSE(simulation.model().stencils.empty());
  run_for(simulation, scene, 1.0 / 3);
  return simulation.positions().back()[1];
}

TEST(OrthotropicPlate, BendsThroughTheFilterByTheRigidityOfItsDirection) {
  const double alone = filtered_tip(0.01, 0.01, false);
  ASSERT_LT(alone, -0.02);
  EXPECT_NEAR(filtered_tip(0.01, 0.05, true) / alone, 1, 0.05) << "stiffer across, where it does not bend";
  EXPECT_LT(filtered_tip(0.05, 0.01, true) / alone, 0.5);
}

TEST(OrthotropicMembrane, HasLevelsOfTheModulusInWhichItHangs) {
  const TemporaryFolder folder;
  const Mesh mesh = uneven_sheet(0.2, 1, 5, 25, 4);
  const auto stretched = [&](const ConstraintSpec& spec) {
    BodySpec body;
    body.name = "strip", body.density = 0.2, body.constraints = {spec}, body.shape = written(folder, mesh);
    ListPin held;
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      if (mesh.points[i][1] == 0) held.particles.push_back(static_cast<int>(i));
    body.pins = {held};
    const Model model = build_model(scene_of({body}, kEarth, 1.0 / 60));
    std::vector<double> w = model.w;
    double sum = 0;
    for (const auto& of : coarsening_graph(model, w).stretch) sum += dot(of, of);
    return sum / static_cast<double>(mesh.points.size());
  };
  for (const double angle : {0.0, 0.5, kPi / 2}) {
    // Directions of pull are estimated at each particle, to some degrees, in which a weave loses a fifth of its
    // modulus.
    const double E = 100 / compliance_at(kPi / 2 - angle);
    EXPECT_NEAR(stretched(woven(100, angle)) / stretched(membrane(E, 0.3)), 1, 0.25) << angle;
  }
}

Scene woven_scene(const Vec3& along, const Transform& transform) {
  BodySpec body;
  body.name = "sheet", body.mass = 1, body.shape = GridShape{{1, 1}, {4, 4}}, body.transform = transform;
  ConstraintSpec spec = woven(30, 0);
  spec.orthotropy->along = along, body.constraints = {spec};
  return scene_of({body}, {0, 0, 0}, 1.0 / 60);
}

TEST(Orthotropy, TurnsWithTheBody) {
  Transform turned;
  turned.axis = {1, 2, 3}, turned.degrees = 100;
  const auto stretched = [](const Transform& transform, double by_x, double by_z) {
    const Model start = build_model(woven_scene({1, 0, 0}, {})), model = build_model(woven_scene({1, 0, 0}, transform));
    std::vector<Vec3> x(model.x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = {start.x[i][0] * (1 + by_x), start.x[i][1], start.x[i][2] * (1 + by_z)};
    return orthotropic_energy(model, x);
  };
  for (const auto& [by_x, by_z] : {std::pair{0.1, 0.0}, {0.0, 0.1}, {0.1, -0.1}})
    EXPECT_NEAR(stretched(turned, by_x, by_z) / stretched({}, by_x, by_z), 1, 1e-12);
  EXPECT_GT(stretched({}, 0.1, 0), 2 * stretched({}, 0, 0.1));
}

TEST(Orthotropy, OfNoDirectionTakesOneThatAllTrianglesHave) {
  Scene upright = woven_scene({0, 1, 0}, {});  // a sheet of y and z
  Mesh sheet = make_mesh(upright.bodies[0].shape);
  for (Vec3& x : sheet.points) std::swap(x[0], x[1]);
  upright.bodies[0].shape = MeshDataShape{sheet.points, sheet.faces, {}, {}};
  Scene without = upright;
  without.bodies[0].constraints[0].orthotropy->along.reset();
  const Model given = build_model(upright), found = build_model(without);
  for (const double stretch : {1.0, 1.1}) {
    std::vector<Vec3> x = given.x;
    for (Vec3& at : x) at[1] *= stretch;
    EXPECT_EQ(orthotropic_energy(found, x), orthotropic_energy(given, x)) << stretch;
  }
  BodySpec box;
  box.name = "box", box.shape = BoxShape{{1, 1, 1}, {{3, 3, 3}}};
  apply_material(box, "gray interlock");
  EXPECT_NO_THROW(build_model(scene_of({box}, {0, 0, 0}, 1.0 / 60))) << "whose faces have all three normals";
}

TEST(Orthotropy, RefusesADirectionThatATriangleDoesNotHave) {
  const std::string said = refusal([] { build_model(woven_scene({0, 1, 0}, {})); });
  EXPECT_NE(said.find("/bodies/0/constraints/0/along"), std::string::npos) << said;
  EXPECT_NE(said.find("perpendicular to the triangle of the vertices 0, "), std::string::npos) << said;
  EXPECT_NE(said.find("body 'sheet'"), std::string::npos) << said;
}

}  // namespace
}  // namespace malha
