// SPDX-License-Identifier: Apache-2.0
// Bending by both constraints and by both methods: a sheet sags as its compliance says, whichever bends it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "tests/constraints/cantilever.h"
#include "tests/constraints/sheet_statics.h"
#include "tests/mesh/irregular_mesh.h"
#include "tests/support.h"

namespace malha {
namespace {

constexpr double kStripLength = 0.3;  // m
/// The rigidity of a plate that sags by about a tenth of that length, N m.
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

/// A strip of 0.4 m x 0.1 m that curls upwards by a radius of 0.25 m from its two clamped rows on.
MeshDataShape curled_strip(bool grid) {
  constexpr double L = 0.4, W = 0.1, R = 0.25;
  MeshDataShape strip = grid ? quads_between(graded(W, 3), graded(L, 12))
                             : listed_of_obj(irregular_obj(W, L, 3, 12, 0.25, 5, 2, Diagonals::Delaunay));
  const double clamp = L / 12;
  for (Vec3& at : strip.points)
    if (const double turned = (at[2] - clamp) / R; turned > 0)
      at = {at[0], R * (1 - std::cos(turned)), clamp + R * std::sin(turned)};
  return strip;
}

/// The middle of the strip's last row at rest under its weight, times `load`.
Vec3 end_of_curled_strip(const MeshDataShape& strip, const std::string& type, double load) {
  constexpr double density = 0.2, L = 0.4, D = density * kG * L * L * L / 20;
  BodySpec body;
  body.name = "strip", body.shape = strip, body.density = density;
  body.pins = {ListPin{{0, 1, 2, 3, 4, 5, 6, 7}}};
  ConstraintSpec bends = stiff(type, {}, 1, type == "plate" ? 0 : 1);
  bends.rigidity = D;
  const bool quads = strip.faces[0][3] >= 0;
  body.constraints = {
      stiff("distance", quads ? std::vector<std::string>{"edges", "shear"} : std::vector<std::string>{"edges"}), bends};
  Scene scene = scene_of({body}, {0, -kG * load, 0}, 1.0 / 60, 60);
  const double swing = 3.516 / (L * L) * std::sqrt(D / density);
  scene.wind = Wind{{0, 0, 0}, 2 * swing * density * L * 0.1 / static_cast<double>(strip.points.size())};
  Simulation simulation(scene, {.threads = 1});
  run_for(simulation, scene, 12 / swing);
  const std::vector<Vec3> x = simulation.positions();
  return x[x.size() - 3];
}

TEST(CurvedStrip, PulledThroughItsFlatShapeEndsAlikeByBothHinges) {
  for (const bool grid : {true, false}) {
    const MeshDataShape strip = curled_strip(grid);
    const Vec3 rest = strip.points[strip.points.size() - 3];
    const Vec3 hung = end_of_curled_strip(strip, "bending", 1);
    EXPECT_LT(hung[1], 0) << "its weight bends it the other way";
    for (const std::string type : {"bending", "isometric_bending"}) {
      // Folds of a few degrees, whose angle and sine differ by 1e-3; what is left is inextensible triangles.
      const double off = length(end_of_curled_strip(strip, type, 1) - hung) / 0.4;
      std::printf("curled strip, %s, %s: its end is %.4f of its length off\n", grid ? "grid" : "irregular",
                  type.c_str(), off);
      EXPECT_LT(off, grid ? 0.005 : 0.02) << type << ", " << grid;
      EXPECT_LT(length(end_of_curled_strip(strip, type, 0) - rest) / 0.4, 1e-6) << type << ", " << grid;
    }
  }
}

/// A shell that is curved at rest keeps its shape by Desbrun's method, and returns to it after a deformation.
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
