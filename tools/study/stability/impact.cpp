// SPDX-License-Identifier: Apache-2.0
// Part of the study "stability": stiff shells of irregular meshes hit the ground.
#include <algorithm>
#include <cmath>
#include <fstream>

#include "kernels/projection/project_constraint.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "tools/bench/cloth.h"
#include "tools/bench/output.h"
#include "tools/study/irregular_mesh.h"
#include "tools/study/rows.h"
#include "tools/study/stability/lines.h"
#include "tools/study/stability/map.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kDrop = 0.5;  // m
constexpr int kImpactFrames = 60;

Scene falling_shell(const std::string& file, double lowest, const ConstraintSpec& bending) {
  BodySpec shell;
  shell.name = "shell", shell.shape = MeshFile{file}, shell.mass = 1;
  shell.transform.translate = {0, kDrop - lowest, 0};
  ConstraintSpec lengths;
  lengths.type = "distance", lengths.elements = {"edges"};
  shell.constraints = {lengths, bending};
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = GridShape{{20, 20}, {1, 1}}, ground.transform.translate = {-10, 0, -10};
  ground.sides = Sides::OneSided, ground.friction = 0.3;
  Scene scene;
  scene.file = "malha study", scene.name = "impact", scene.gravity = {0, -kGravity, 0};
  scene.solver.dt = kFrame, scene.bodies = {shell}, scene.environment = {ground};
  return scene;
}

/// The largest speed, over that of a fall from the highest point to the ground, and the largest strain, of `meshes`
/// irregular meshes.
Json worst_impact(const ConstraintSpec& bending, int meshes, const Cells& cells) {
  double speed = 0, strain = 0;
  for (int seed = 0; seed < meshes; ++seed) {
    const IrregularMesh mesh(seed, 2);
    const bench::ScratchFolder folder;
    const std::string file = (folder.path() / "shell.off").string();
    std::ofstream(file) << mesh.off();
    Simulation simulation(falling_shell(file, mesh.lowest(), bending), {.threads = 1});
    double top = 0;
    for (const Vec3& x : simulation.positions()) top = std::max(top, x[1]);
    for (int frame = 0; frame < kImpactFrames; ++frame) {
      simulation.step(), cells.check_interrupt();
      const Measures now = simulation.measure();
      speed = std::max(speed, now.speed_max / std::sqrt(2 * kGravity * top));
      strain = std::max(strain, now.strain_max);
    }
  }
  return {{"speed", speed}, {"strain", strain}};
}

}  // namespace

Section impact_failure(Cells& cells, Json& rows) {
  const int meshes = cells.quick() ? 4 : 20;
  Section section{
      formatted("Stiff shells on impact: %d irregular closed meshes dropped by %g m, 10 substeps", meshes, kDrop)};
  section.table.columns = {"bending", "largest speed / speed of a free fall", "largest strain"};
  std::vector<ConstraintSpec> bendings;
  for (const double k : cells.quick() ? std::vector<double>{1, 1e-4} : std::vector<double>{1, 1e-2, 1e-4, 1e-6}) {
    ConstraintSpec& one = bendings.emplace_back();
    one.type = "bending", one.stiffness = k;
  }
  for (const double a : cells.quick() ? std::vector<double>{1e-2, 1e2} : std::vector<double>{1e-4, 1e-2, 1, 1e2}) {
    ConstraintSpec& one = bendings.emplace_back();
    one.type = "bending", one.compliance = a;
  }
  double speed = 0, strain = 0;
  const auto title_of = [](const ConstraintSpec& bending) {
    return bending.compliance ? formatted("compliance %g rad/(N m)", *bending.compliance)
                              : formatted("stiffness %g", bending.stiffness);
  };
  const std::vector<Json> kept = cells.measure_all(
      bendings,
      [&](const ConstraintSpec& bending) { return formatted("impact: %d, %s", meshes, title_of(bending).c_str()); },
      [&](const ConstraintSpec& bending) -> Json {
        try {
          return worst_impact(bending, meshes, cells);
        } catch (const Diverged&) {
          return {{"speed", nullptr}, {"strain", nullptr}};
        }
      });
  if (cells.is_partial()) return section;
  for (std::size_t k = 0; k < bendings.size(); ++k) {
    const std::string title = title_of(bendings[k]);
    const Json& cell = kept[k];
    const bool ended = cell["speed"].is_null();
    section.table.rows.push_back({title, ended ? "diverged" : formatted("%.2g", cell["speed"].get<double>()),
                                  ended ? "diverged" : formatted("%.2g", cell["strain"].get<double>())});
    rows.push_back({{"map", "impact"},
                    {"panel", title},
                    {"speed", cell["speed"]},
                    {"strain", cell["strain"]},
                    {"verdict", ended ? "diverged" : "stable"}});
    copy_machine(rows.back(), cell);
    speed = ended ? INFINITY : std::max(speed, cell["speed"].get<double>());
    strain = ended ? INFINITY : std::max(strain, cell["strain"].get<double>());
  }
  section.sentences = {
      formatted("No particle is faster than %.2g times the speed of a free fall, and no edge is strained by more than "
                "%.2g.",
                speed, strain),
      formatted("Remedy: one projection of bending moves no particle farther than %.2g of the smaller height of "
                "its hinge at rest, because the angle is only linear for small displacements; the remaining error is "
                "corrected by later projections. Distances are linear along their own direction and need no bound.",
                kMaxStep)};
  return section;
}

}  // namespace malha::study
