// Bending by its two constraints and by both methods is the same sheet: what sags, and how far, is the compliance's.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>

#include "host/simulation.h"
#include "tests/irregular_mesh.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kStripLength = 0.3, kStripDensity = 0.2;  // m, kg/m^2

struct StripMesh {
  std::string name;
  Shape shape;
  int across, along;  // cells
};

std::vector<StripMesh> strip_meshes(const TemporaryFolder& folder) {
  std::vector<StripMesh> all;
  for (const int n : {6, 9, 12}) {
    const int across = n / 3;
    all.push_back({"grid " + std::to_string(n), GridShape{{kStripLength / 3, kStripLength}, {across, n}}, across, n});
    const std::string file = "strip" + std::to_string(n) + ".obj";
    all.push_back({"irregular " + std::to_string(n),
                   MeshFile{folder.write(file, irregular_obj(kStripLength / 3, kStripLength, across, n, 0.25, n, 2))},
                   across, n});
  }
  return all;
}

/// How far the free end of a strip sags whose first two rows are held, m.
double sag(const StripMesh& mesh, ConstraintSpec bends, const std::string& method) {
  // Of a plate with D = 1 / compliance, which the hinges are near: a tenth of the length.
  const double D = kStripDensity * 9.81 * std::pow(kStripLength, 3) / (8 * 0.1);
  const double swing = 3.516 / std::pow(kStripLength, 2) * std::sqrt(D / kStripDensity), l = kStripLength / mesh.along;
  if (!bends.rigidity) bends.compliance = 1 / D;
  BodySpec strip;
  strip.name = "strip", strip.shape = mesh.shape, strip.density = kStripDensity;
  std::vector<int> held(2 * (mesh.across + 1));
  std::iota(held.begin(), held.end(), 0);
  strip.pins = {ListPin{held}};
  // Soft enough for the filter, and stretched by its weight by no more than a thousandth.
  strip.constraints = {compliant("distance", 5e-3, {"edges", "shear"}), bends};
  if (std::holds_alternative<MeshFile>(mesh.shape)) strip.constraints[0].on = {"edges"};
  // One sweep a substep meets a compliance but for (h / (l^2 sqrt(density / 4 D)))^2; l is not the shortest height.
  const double h = l * l * std::sqrt(kStripDensity / (4 * D)) / 10;
  Scene scene = scene_of({strip}, kEarth, 1.0 / 60, method == "pbd" ? static_cast<int>(std::ceil(1 / (60 * h))) : 10);
  scene.solver.type = method;
  if (method == "desbrun")
    scene.solver.desbrun.refine = 40;  // the filter alone brakes turning, and takes minutes to rest
  const double particles = (mesh.across + 1) * (mesh.along + 1);
  scene.wind = Wind{{0, 0, 0}, 2 * swing * kStripDensity * kStripLength * kStripLength / 3 / particles};
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 12 / swing);
  double lowest = 0;
  for (const Vec3& x : simulation.positions()) lowest = std::min(lowest, x[1]);
  return -lowest;
}

TEST(BendingOfOneCompliance, SagsAlikeByBothConstraintsAndBothMethods) {
  const TemporaryFolder folder;
  for (const StripMesh& mesh : strip_meshes(folder)) {
    const double expected = sag(mesh, stiff("bending"), "pbd");
    EXPECT_GT(expected, 0.02 * kStripLength) << mesh.name << ": it does sag";
    // Angles of a few degrees a hinge: theta and 2 sin(theta / 2) differ by 1e-3 of them. The rest is convergence.
    EXPECT_NEAR(sag(mesh, stiff("isometric_bending"), "pbd") / expected, 1, 0.02) << mesh.name;
    EXPECT_NEAR(sag(mesh, stiff("bending"), "desbrun") / expected, 1, 0.02) << mesh.name;
    EXPECT_NEAR(sag(mesh, stiff("isometric_bending"), "desbrun") / expected, 1, 0.02) << mesh.name;
  }
}

TEST(BendingOfOneRigidity, SagsAlikeByBothMethods) {
  const TemporaryFolder folder;
  const StripMesh mesh = strip_meshes(folder)[2];
  ConstraintSpec bends = stiff("bending");
  bends.rigidity = kStripDensity * 9.81 * std::pow(kStripLength, 3) / (8 * 0.1);
  EXPECT_NEAR(sag(mesh, bends, "desbrun") / sag(mesh, bends, "pbd"), 1, 0.02);
}

/// A shell that is curved at rest keeps its shape by Desbrun's method, and takes it up again.
TEST(Fold, OfACurvedShellIsItsRestByDesbrunsMethod) {
  BodySpec shell;
  shell.name = "shell", shell.shape = SphereShape{0.1, 2}, shell.mass = 0.1;
  shell.constraints = {compliant("distance", 1e-3, {"edges"}), compliant("bending", 10)};
  Scene scene = scene_of({shell}, {0, 0, 0}, 1.0 / 60);
  scene.solver.type = "desbrun";
  Simulation simulation(scene, {.threads = 1});
  const std::vector<Vec3> before = simulation.positions();
  run_for(simulation, scene, 0.5);
  const std::vector<Vec3> after = simulation.positions();
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_LT(length(after[i] - before[i]), 1e-12) << i;
  EXPECT_LT(simulation.measure().elastic, 1e-20);
}

}  // namespace
}  // namespace malha
