// SPDX-License-Identifier: Apache-2.0
// Figures of scenes/accuracy.md on materials: the softening of strips by too few substeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/model/softening.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A strip of 0.2 m that sags, or is stretched in its plane, by some percent; drag damps it.
struct FigureStrip {
  Shape shape = GridShape{{0.8 / 9, 0.2}, {4, 9}};
  ConstraintSpec material;
  int across = 4, rows = 9;  // cells
  double width = 0.8 / 9;
  static constexpr double kDensity = 0.2;  // kg/m^2

  bool stretched() const { return material.type == "membrane" || material.type == "distance"; }
  Scene scene(int substeps, int iterations) const {
    const double mass = kDensity * width * 0.2;
    BodySpec body;
    body.name = "strip", body.mass = mass, body.shape = shape, body.constraints = {material};
    if (!stretched()) {
      body.constraints.push_back(stiff("distance", {"edges"}));
      if (std::holds_alternative<GridShape>(shape)) body.constraints.back().elements.push_back("shear");
    }
    ListPin rim;
    for (int i = 0; i < (stretched() ? 1 : 2) * (across + 1); ++i) rim.particles.push_back(i);
    body.pins = {rim};
    Scene in = scene_of({body}, stretched() ? Vec3{0, 0, 0.1} : Vec3{0, -0.1, 0}, 1.0 / 60, substeps);
    in.solver.iterations = iterations, in.solver.bending = BendingMethod::Projected;
    in.wind = Wind{};
    in.wind->drag = 10 * mass / ((rows + 1) * (across + 1));
    return in;
  }
  /// The mean displacement in the direction of gravity at rest, m.
  double way(int substeps, int iterations = 1) const {
    const Scene in = scene(substeps, iterations);
    Simulation simulation(in, {.threads = 1});
    const double before = simulation.measure().potential;
    run_for(simulation, in, 3);
    return (before - simulation.measure().potential) / (length(in.gravity) * *in.bodies[0].mass);
  }
  /// The relative excess of the displacement; the reference is that of `truth` substeps.
  double too_far(int substeps, int truth, int iterations = 1) const {
    return way(substeps, iterations) / way(truth) - 1;
  }
  double estimate(int substeps) const { return worst_softening(build_model(scene(substeps, 1))).share; }
};

ConstraintSpec material_of_rigidity(const std::string& type, double rigidity, std::vector<std::string> on = {}) {
  ConstraintSpec spec = stiff(type, std::move(on), 1, type == "plate" ? 0 : 1);
  spec.rigidity = rigidity;
  return spec;
}

constexpr double kFigureD = 1e-3, kFigureY = 2, kFigureCell = 0.2 / 9;  // N m, N/m, m

// The factors that the page states.
TEST(Figures, DISABLED_SofteningOfStripsOfSquareCells) {
  ConstraintSpec membrane = stiff("membrane", {}, 1, 0.3);
  membrane.young_modulus = kFigureY;
  const auto row = [](const char* name, const ConstraintSpec& material, double least, double most) {
    FigureStrip strip;
    strip.material = material;
    for (const int substeps : {4, 6, 8}) {
      const double h = 1.0 / 60 / substeps, l = kFigureCell;
      const double formula = strip.stretched() ? kFigureY / FigureStrip::kDensity * h * h / (l * l)
                                               : h * h / std::pow(l, 4) * kFigureD / FigureStrip::kDensity;
      const double share = strip.too_far(substeps, 60), iterated = strip.too_far(substeps, 60, 4);
      std::printf("%-32s %d substeps: %5.1f %% too far, %.2f of the formula; with 4 iterations %.1f %%\n", name,
                  substeps, 100 * share, share / formula, 100 * iterated);
      EXPECT_GT(share, least * formula) << name;
      EXPECT_LT(share, most * formula) << name;
      EXPECT_LT(iterated, share / 4) << name;
    }
  };
  row("stretch by distance", material_of_rigidity("distance", kFigureY, {"edges"}), 0.08, 0.5);
  row("stretch by membrane", membrane, 0.07, 0.5);
  row("bending", material_of_rigidity("bending", kFigureD), 0.4, 1.2);
  row("isometric_bending", material_of_rigidity("isometric_bending", kFigureD), 0.4, 1.2);
  row("plate", material_of_rigidity("plate", kFigureD), 1, 1.6);
}

// The same formula, of the cells' mean size.
TEST(Figures, DISABLED_SofteningOfStripsOfIrregularTriangles) {
  const TemporaryFolder folder;
  for (const char* type : {"bending", "plate"}) {
    FigureStrip strip;
    strip.material = material_of_rigidity(type, kFigureD);
    double least = 1e9, most = 0, least_estimated = 1e9, most_estimated = 0;
    for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
      strip.shape = MeshFile{folder.write("strip.obj", irregular_obj(strip.width, 0.2, 4, 9, 0.3, seed, 1))};
      const int substeps = 12;
      const double h = 1.0 / 60 / substeps, share = strip.too_far(substeps, 100);
      const double of_formula = share / (h * h / std::pow(kFigureCell, 4) * kFigureD / FigureStrip::kDensity);
      const double of_estimate = share / strip.estimate(substeps);
      least = std::min(least, of_formula), most = std::max(most, of_formula);
      least_estimated = std::min(least_estimated, of_estimate), most_estimated = std::max(most_estimated, of_estimate);
    }
    std::printf("%s: %.1f to %.1f times the formula of a grid, %.2f to %.2f of what the warning says\n", type, least,
                most, least_estimated, most_estimated);
    EXPECT_LT(most, 20) << type << ": short heights count by their fourth power";
    EXPECT_GT(least_estimated, 0.08) << type;
    EXPECT_LT(most_estimated, 1) << type << ": the warning says more rather than less";
  }
}

// Meshes for which the warning's median of all constraints says little.
TEST(Figures, DISABLED_SofteningOfGradedAndLongCells) {
  FigureStrip graded;
  graded.across = 4, graded.width = 0.04;
  MeshDataShape mesh;
  // Cells of 2 mm on the first tenth, where it bends most, and of 10 mm.
  for (double z = 0; z < 0.2001; z += z < 0.0199 ? 0.002 : 0.01)
    for (int i = 0; i <= 4; ++i) mesh.points.push_back({0.01 * i, 0, z});
  graded.rows = static_cast<int>(mesh.points.size()) / 5 - 1;
  for (int j = 0; j < graded.rows; ++j)
    for (int i = 0; i < 4; ++i) mesh.faces.push_back({5 * j + i, 5 * j + i + 5, 5 * j + i + 6, 5 * j + i + 1});
  graded.shape = mesh;
  graded.material = material_of_rigidity("bending", kFigureD);
  int substeps = 1;
  while (graded.estimate(substeps) > 0.1) ++substeps;
  const double unwarned = graded.too_far(substeps, 20 * substeps);
  std::printf("cells of 2 and 10 mm, %d substeps without a warning: %.0f %% too far\n", substeps, 100 * unwarned);
  EXPECT_GT(unwarned, 0.1) << "or the page need not tell of it";

  FigureStrip lengthy;
  lengthy.width = 0.08, lengthy.across = 4, lengthy.rows = 40;
  lengthy.shape = GridShape{{0.08, 0.2}, {4, 40}}, lengthy.material = material_of_rigidity("bending", kFigureD);
  for (const int n : {40, 80}) {
    const double share = lengthy.too_far(n, 800);
    std::printf("cells of 20 x 5 mm, %d substeps: %.0f %% too far; the warning's estimate is %.0f %%\n", n, 100 * share,
                100 * lengthy.estimate(n));
    EXPECT_LT(share, 10) << "it may be off, but not without bound";
  }
}

}  // namespace
}  // namespace malha
