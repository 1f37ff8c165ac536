// Bending by its two constraints and by both methods is the same sheet: what sags, and how far, is the compliance's.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "tests/cantilever.h"
#include "tests/irregular_mesh.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kStripLength = 0.3;  // m
/// Of a plate that sags by about a tenth of that, N m.
const double kStripRigidity = 0.2 * 9.81 * std::pow(kStripLength, 3) / (8 * 0.1);

struct NamedStrip {
  std::string name;
  Cantilever strip;
};

std::vector<NamedStrip> strips(const TemporaryFolder& folder) {
  constexpr double L = kStripLength, W = L / 3;
  std::vector<NamedStrip> all;
  for (const int n : {6, 9, 12}) {
    const int across = n / 3;
    all.push_back({"grid " + std::to_string(n), {GridShape{{W, L}, {across, n}}, W, L, across, n}});
    const std::string file =
        folder.write("strip" + std::to_string(n) + ".obj", irregular_obj(W, L, across, n, 0.25, n, 2));
    all.push_back({"irregular " + std::to_string(n), {MeshFile{file}, W, L, across, n}});
  }
  return all;
}

double sag_by(const Cantilever& strip, const std::string& type, const std::string& method) {
  return sag_of(strip, compliant(type, 1 / kStripRigidity), kStripRigidity, method);
}

TEST(BendingOfOneCompliance, SagsAlikeByBothConstraintsAndBothMethods) {
  const TemporaryFolder folder;
  for (const auto& [name, strip] : strips(folder)) {
    const double expected = sag_by(strip, "bending", "pbd");
    EXPECT_GT(expected, 0.02 * kStripLength) << name << ": it does sag";
    for (const auto& [type, method] :
         {std::pair{"isometric_bending", "pbd"}, {"bending", "desbrun"}, {"isometric_bending", "desbrun"}}) {
      const double share = sag_by(strip, type, method) / expected;
      std::printf("%s, %s by %s: %.4f of the sag of bending by pbd\n", name.c_str(), type, method, share);
      // Angles of a few degrees a hinge: theta and 2 sin(theta / 2) differ by 1e-3 of them. The rest is convergence.
      EXPECT_NEAR(share, 1, 0.02) << name;
    }
  }
}

TEST(BendingOfOneRigidity, SagsAlikeByBothMethods) {
  const TemporaryFolder folder;
  const Cantilever strip = strips(folder)[2].strip;
  ConstraintSpec bends = stiff("bending");
  bends.rigidity = kStripRigidity;
  const double by_pbd = sag_of(strip, bends, kStripRigidity, "pbd");
  EXPECT_NEAR(sag_of(strip, bends, kStripRigidity, "desbrun") / by_pbd, 1, 0.02);
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
