// SPDX-License-Identifier: Apache-2.0
// Materials: constraints whose compliance follows from a material bend and stretch as its cloth does, however fine the
// mesh. Both methods are compared with formulas of beams, not with each other.
#include "host/model/material.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <string>

#include "host/measure/measure.h"
#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

constexpr double kSheetDensity = 0.2;  // kg/m^2
#if defined(NDEBUG)
constexpr int kSides[] = {17, 46, 100, 316};  // particles along a side
constexpr int kSwinging[] = {17, 46};
#else  // without optimisation these sizes are too slow, and run the same code
constexpr int kSides[] = {17, 46};
constexpr int kSwinging[] = {17};
#endif

ConstraintSpec rigid(const std::string& type, double rigidity, std::vector<std::string> on = {}) {
  ConstraintSpec spec = stiff(type, std::move(on));
  spec.rigidity = rigidity;
  return spec;
}

/// A strip of 1 m with n particles along z and three across, of square cells.
BodySpec strip(int n, std::vector<ConstraintSpec> constraints) {
  BodySpec body;
  body.name = "strip";
  body.shape = GridShape{{2.0 / (n - 1), 1}, {2, n - 1}};
  body.density = kSheetDensity;
  body.pins = {RowPin{}};
  body.constraints = std::move(constraints);
  return body;
}

/// Hangs the strip in air with critical drag for its slowest mode (rad/s), until it rests. h: duration of a substep, s.
double tip_at_rest(BodySpec body, double gravity, double swing, double h, int particles, double seconds) {
  const double mass = 2.0 / (particles - 1) * kSheetDensity;
  Scene scene = scene_of({std::move(body)}, {0, -gravity, 0}, 1.0 / 60, static_cast<int>(std::ceil(1 / (60 * h))));
  scene.wind = Wind{{0, 0, 0}, 2 * swing * mass / (3.0 * particles)};
  Simulation simulation(scene, {1});
  run_for(simulation, scene, seconds);
  return simulation.positions()[3 * particles - 2][1];
}

TEST(EdgeSoftness, IsThatOfTheAreaAroundAnEdge) {
  // A grid of 3 x 2 cells of 0.5 m x 0.25 m. Edges along x have 0.125 m^2 around them, at the rim half of it.
  Mesh grid = make_mesh(GridShape{{1.5, 0.5}, {3, 2}});
  const std::vector<Edge> all = edges(grid);
  const std::vector<double> softness = edge_softness(grid, all);
  for (std::size_t e = 0; e < all.size(); ++e) {
    const Vec3 &a = grid.points[all[e][0]], &b = grid.points[all[e][1]], d = b - a;
    const bool along_x = d[0] != 0;
    const bool rim = along_x ? a[2] == 0 || a[2] == 0.5 : a[0] == 0 || a[0] == 1.5;
    EXPECT_NEAR(softness[e], (along_x ? 2 : 0.5) * (rim ? 2 : 1), 1e-12);
  }
  for (const double s : shear_softness(grid)) EXPECT_NEAR(s, 2 * 0.125 / (0.25 + 0.0625), 1e-12);
  grid.lines = {{0, 11}};
  EXPECT_NEAR(edge_softness(grid, {{0, 11}})[0], std::hypot(1.5, 0.5), 1e-12) << "a line, of its length";
}

TEST(EdgeSoftness, OfEquilateralTrianglesGivesTheirYoungsModulus) {
  // Springs k = Y sqrt(3) / 2 on a triangular lattice: its Young's modulus is 2 k / sqrt(3) (Seung, Nelson 1988).
  const double h = std::sqrt(3.0) / 2;
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {0.5, -h, 0}};
  mesh.faces = {{0, 1, 2, -1}, {1, 0, 3, -1}};
  EXPECT_NEAR(1 / edge_softness(mesh, {{0, 1}})[0], h, 1e-12);
}

TEST(HingeSoftness, IsTheAreaOverTheEdge) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, -2, 0}};
  mesh.faces = {{0, 1, 2, -1}, {1, 0, 3, -1}};
  const PlateHinges all = plate_hinges(mesh, std::vector<bool>(4));
  ASSERT_EQ(all.list.size(), 1u);
  EXPECT_EQ(all.list, hinges(mesh));
  EXPECT_NEAR(all.softness[0], 3.0 / 4, 1e-12);
  EXPECT_NEAR(plate_hinges(mesh, {true, true, true, false}).softness[0], 2.0 / 4, 1e-12)
      << "a triangle that is held does not bend";
}

/// Elastic energy of a model's only set when its flat 1 m sheet is bent to a cylinder of curvature c, whose axis is
/// turned by `angle`.
double energy_of_a_cylinder(const Model& model, double c, double angle) {
  std::vector<Vec3> x = model.x;
  for (Vec3& at : x) {
    const double s = at[0] * std::cos(angle) + at[2] * std::sin(angle),
                 t = at[2] * std::cos(angle) - at[0] * std::sin(angle);
    at = {std::sin(c * s) / c, (1 - std::cos(c * s)) / c, t};
  }
  Measures measures;
  measure_constraints(Serial{}, model, x, measures);
  return measures.elastic;
}

TEST(Rigidity, OfBendingIsTheEnergyOfAPlateInAllDirectionsAtEveryResolution) {
  const double D = 0.01, c = 0.1, plate = D * c * c / 2;
  for (const std::string type : {"bending", "isometric_bending"})
    for (const int n : kSides) {
      BodySpec sheet = strip(n, {rigid(type, D)});
      sheet.shape = GridShape{{1, 1}, {n - 1, n - 1}};
      const Model model = build_model(scene_of({sheet}, {0, 0, 0}, 1.0 / 60));
      // Nothing bends along the sides in the outer half of the cells at the rim, where twist is whole; folds are chords
      // of the curve, to (c l)^2 / 24.
      for (const double angle : {0.0, kPi / 4, -kPi / 4, kPi / 6}) {
        const double along = std::pow(std::cos(angle), 4) + std::pow(std::sin(angle), 4);
        EXPECT_NEAR(energy_of_a_cylinder(model, c, angle) / plate, 1 - along / (n - 1), 1e-4)
            << type << ", " << n << ", " << angle;
      }
    }
}

TEST(Rigidity, OfAHangingStripIsItsStretchAtEveryResolution) {
  // Springs along both sides (Y) and diagonals (G) are a material of Young's modulus Y (1 + nu), nu = G / (Y + G).
  const double Y = 20, G = 10, nu = G / (Y + G), modulus = Y * (1 + nu);
  const double gravity = 1, expected = kSheetDensity * gravity / (2 * modulus);  // a strain so small that all is linear
  const double speed = std::sqrt(modulus / kSheetDensity);
  for (const int n : kSides) {
    BodySpec body = strip(n, {rigid("distance", Y, {"edges"}), rigid("distance", G, {"shear"})});
    body.transform.axis = {1, 0, 0}, body.transform.degrees = 90;
    // One sweep a substep reaches the compliance up to (speed h / l)^2; the pinned row cannot contract laterally.
    const double h = 0.07 / (n - 1) / speed;
    const double stretch = -tip_at_rest(body, gravity, kPi / 2 * speed, h, n, 0.8) - 1;
    std::printf("%d particles along the strip: %.4f of its stretch\n", n, stretch / expected);
    EXPECT_NEAR(stretch / expected, 1, 0.012) << n;
  }
}

/// Sag of the tip of a strip whose first two rows are pinned, over that of beam theory.
double sag_of_a_cantilever(const std::string& type, int n) {
  const double l = 1.0 / (n - 1);
  const double L = 1 - l, sag = 0.05 * L, D = kSheetDensity * 9.81 * std::pow(L, 4) / (8 * sag);
  const double swing = 3.516 / (L * L) * std::sqrt(D / kSheetDensity);
  BodySpec body = strip(n, {stiff("distance", {"edges", "shear"}), rigid(type, D)});
  std::vector<int> held(6);
  std::iota(held.begin(), held.end(), 0);
  body.pins = {ListPin{held}};
  // One sweep a substep reaches the compliance up to (h / (l^2 sqrt(density / 4 D)))^2 of about a quarter.
  const double h = l * l * std::sqrt(kSheetDensity / (4 * D)) / 6;
  return -tip_at_rest(body, 9.81, swing, h, n, 12 / swing) / sag;
}

TEST(Rigidity, OfACantileverIsItsSagAtEveryResolution) {
  for (const std::string type : {"bending", "isometric_bending"})
    for (const int n : kSwinging) {
      const double sag = sag_of_a_cantilever(type, n);
      std::printf("%s, %d particles along the strip: %.4f of its sag\n", type.c_str(), n, sag);
      EXPECT_NEAR(sag, 1, 0.012) << type << ", " << n;
    }
}

// The number of substeps grows as n^2, so this takes minutes; --gtest_also_run_disabled_tests runs it.
TEST(Rigidity, DISABLED_OfACantileverIsItsSagAtTheFinestResolutions) {
  for (const int n : {100, 316}) EXPECT_NEAR(sag_of_a_cantilever("bending", n), 1, 0.012) << n;
}

TEST(Rigidity, OfDesbrunsSpringsIsThatOfTheirEdges) {
  BodySpec body = strip(5, {rigid("distance", 20, {"edges"})});
  Scene scene = scene_of({body}, {0, 0, 0}, 1.0 / 60);
  scene.solver.type = "desbrun";
  const Model model = build_model(scene);
  ASSERT_EQ(model.springs.size(), 1u);
  for (std::size_t s = 0; s < model.springs[0].ends.size(); ++s) {
    const auto& [a, b] = model.springs[0].ends[s];
    const bool along = model.x[a][0] == model.x[b][0], rim = model.x[a][0] != 0.25 || !along;
    // Cells of 0.25 m; the last row has cells on one side only, as the long sides have.
    const bool inner_row = !along && model.x[a][2] != 1;
    EXPECT_NEAR(model.springs[0].stiffness[s], rim && !inner_row ? 10 : 20, 1e-9);
  }
}

}  // namespace
}  // namespace malha
