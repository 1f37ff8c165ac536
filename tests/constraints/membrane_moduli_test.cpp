// SPDX-License-Identifier: Apache-2.0
// Young's modulus, Poisson's ratio and shear modulus that a membrane of irregular triangles shows by both methods.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/constraints/uneven_sheet.h"

namespace malha {
namespace {

/// Measures of a window of a sheet, weighted by the areas of its triangles: stretches along x and y less 1, the shear
/// between them, and the distance below the upper edge (m).
struct Shown {
  double along_x = 0, along_y = 0, shear = 0, depth = 0;
};
Shown shown(const Mesh& mesh, const std::vector<Vec3>& x, const Vec3& low, const Vec3& high) {
  Shown mean;
  double sum = 0;
  for (const Quad& t : mesh.faces) {
    Vec3 centre{0, 0, 0};
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 2; ++axis) centre[axis] += mesh.points[t[k]][axis] / 3;
    if (centre[0] < low[0] || centre[0] > high[0] || centre[1] < low[1] || centre[1] > high[1]) continue;
    const Eigen::Matrix<double, 3, 2> F = gradient_of(mesh.points, x, t);
    const double A = area_of(mesh.points, t);
    sum += A;
    mean.along_x += A * (F.col(0).norm() - 1), mean.along_y += A * (F.col(1).norm() - 1);
    mean.shear += A * F.col(0).dot(F.col(1)), mean.depth -= A * centre[1];
  }
  return {mean.along_x / sum, mean.along_y / sum, mean.shear / sum, mean.depth / sum};
}

struct MembraneCase {
  const char* method;
  double Y, nu;
};
class IrregularMembrane : public testing::TestWithParam<MembraneCase> {
 protected:
  static constexpr double kDensity = 0.2;  // kg/m^2

  /// Hangs the sheet by its upper edge until it rests. `swing`: the frequency of its slowest mode, rad/s; `wave`: the
  /// speed of its fastest wave, m/s.
  static std::vector<Vec3> at_rest(const std::string& method, const ConstraintSpec& material, const Mesh& mesh,
                                   const Vec3& gravity, double cell, double swing, double wave) {
    const TemporaryFolder folder;
    BodySpec body;
    body.name = "sheet", body.density = kDensity, body.constraints = {material};
    body.shape = written(folder, mesh);
    body.pins = {upper_edge(mesh)};
    // One sweep of XPBD a substep is short of the compliance by some (2 wave h / cell)^2: 0.2 %. Desbrun's rests in the
    // balance itself, in steps of any length.
    const bool by_pbd = method == "pbd";
    const double h = by_pbd ? 0.02 * cell / wave : 0.5 / swing;
    Scene scene = scene_of({body}, gravity, by_pbd ? 100 * h : h, by_pbd ? 100 : 1);
    scene.solver.type = method;
    scene.wind = Wind{{0, 0, 0}, 2 * swing * kDensity * area_of(mesh) / static_cast<double>(mesh.points.size())};
    return after(scene, (by_pbd ? 15 : 60) / swing).positions();
  }

  struct Moduli {
    double young, poisson;  // young: over Y; poisson: over that of the material
  };
  /// The moduli that a strip shows whose material has Y (N/m), with waves of up to `wave` m/s.
  static Moduli stretched(const std::string& method, const ConstraintSpec& material, double Y, double wave) {
    const double L = 1, W = 0.2, cell = 0.04, gravity = 0.02 * Y / (kDensity * L);  // 2 % at the upper edge
    const Mesh mesh = uneven_sheet(W, L, 5, 25, 4);
    const double swing = kPi / 2 * std::sqrt(Y / kDensity) / L;
    const std::vector<Vec3> x = at_rest(method, material, mesh, {0, -gravity, 0}, cell, swing, wave);
    // The window is away from the edge that is pinned, and from the free one.
    const Shown mean = shown(mesh, x, {0, -0.7 * L, 0}, {W, -0.4 * L, 0});
    const double tension = kDensity * gravity * (L - mean.depth);  // of what hangs below, N/m
    return {tension / mean.along_y / Y, -mean.along_x / mean.along_y};
  }
};

TEST_P(IrregularMembrane, ShowsItsYoungsModulusAndPoissonsRatioWhereItIsStretched) {
  const auto& [method, Y, nu] = GetParam();
  const Moduli shows = stretched(method, membrane(Y, nu), Y, std::sqrt(Y / kDensity / (1 - nu * nu)));
  std::printf("%s, Y %g N/m, nu %g: shows %.4f of Y, and nu %.4f\n", method, Y, nu, shows.young, shows.poisson);
  EXPECT_NEAR(shows.young, 1, 0.01);
  EXPECT_NEAR(shows.poisson, nu, 0.01 * std::max(nu, 0.3));
}

/// Springs have a Poisson's ratio that follows from their pattern; the page quotes what this strip shows.
class SpringsOnIrregularTriangles : public IrregularMembrane {};
TEST_P(SpringsOnIrregularTriangles, AreSofterThanTheirModulusAndHaveARatioOfTheirOwn) {
  const auto& [method, Y, nu] = GetParam();
  ConstraintSpec springs = stiff("distance", {"edges"});
  springs.rigidity = Y;
  const Moduli shows = stretched(method, springs, Y, std::sqrt(Y / kDensity / (1 - nu * nu)));
  std::printf("springs of %g N/m by %s: show %.2f of it, and a ratio of %.2f\n", Y, method, shows.young, shows.poisson);
  EXPECT_NEAR(shows.young, 0.85, 0.05);
  EXPECT_NEAR(shows.poisson, 0.21, 0.05) << "not the third of equilateral triangles";
}
INSTANTIATE_TEST_SUITE_P(, SpringsOnIrregularTriangles, testing::Values(MembraneCase{"pbd", 20, 1.0 / 3}));

TEST_P(IrregularMembrane, ShowsItsShearModulusWhereItIsSheared) {
  const auto& [method, Y, nu] = GetParam();
  const double G = Y / (2 * (1 + nu)), H = 0.12, W = 2.4, cell = 0.03, gravity = 0.02 * G / (kDensity * H);
  const Mesh mesh = uneven_sheet(W, H, 80, 4, 5);
  const double wave = std::sqrt(Y / kDensity);
  const std::vector<Vec3> x = at_rest(method, membrane(Y, nu), mesh, {gravity, 0, 0}, cell,
                                      kPi / 2 * std::sqrt(G / kDensity) / H, wave / std::sqrt(1 - nu * nu));
  // Nine heights from both ends, which slant.
  const Shown mean = shown(mesh, x, {0.45 * W, -H, 0}, {0.55 * W, 0, 0});
  const double shows = -kDensity * gravity * (H - mean.depth) / mean.shear / G;
  std::printf("%s, Y %g N/m, nu %g: shows %.4f of Y / (2 (1 + nu))\n", method, Y, nu, shows);
  EXPECT_NEAR(shows, 1, 0.01);
}

INSTANTIATE_TEST_SUITE_P(, IrregularMembrane,
                         testing::Values(MembraneCase{"pbd", 20, 0.3}, MembraneCase{"pbd", 3, 0},
                                         MembraneCase{"pbd", 500, 0.6}, MembraneCase{"desbrun", 20, 0.3},
                                         MembraneCase{"desbrun", 3, 0}, MembraneCase{"desbrun", 500, 0.6}),
                         [](const auto& tested) {
                           return std::string(tested.param.method) + std::to_string(tested.index % 3);
                         });

}  // namespace
}  // namespace malha
