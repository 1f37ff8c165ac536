// SPDX-License-Identifier: Apache-2.0
#include "tools/study/published/hanging.h"

#include <fstream>

#include "malha/simulation.h"
#include "tools/bench/cloth.h"
#include "tools/bench/output.h"
#include "tools/study/published/parts.h"
#include "tools/study/reference/steps.h"
#include "tools/study/reference/xpbd.h"
#include "tools/study/rows.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr int kFrames = 900;

/// Masses follow the lengths of lines, so that the weight is a last particle and one more far below it, on a rod
/// between them that is as heavy as it is long.
Scene scene_of(const Hanging& of, const std::filesystem::path& folder) {
  const std::string file = (folder / "chain.obj").string();
  const double rod = (of.weight - 0.5) * of.spacing;
  std::ofstream mesh(file);
  mesh.precision(17);
  for (int i = 0; i < kParticles; ++i) mesh << "v 0 " << -i * of.spacing << " 0\n";
  mesh << "v 0 " << -kLinks * of.spacing - rod << " 0\nl";
  for (int i = 1; i <= kParticles + 1; ++i) mesh << " " << i;
  mesh << "\n";
  BodySpec body;
  body.name = "chain", body.shape = MeshFile{file}, body.density = 1 / of.spacing, body.pins = {ListPin{{0}}};
  ConstraintSpec links;
  links.type = "distance", links.elements = {"edges"};
  if (of.stiffness < kInfinite) links.compliance = 1 / of.stiffness;
  body.constraints = {links};
  if (of.long_range) {
    ConstraintSpec reach;
    reach.type = "long_range", reach.parameter = 0.02;
    body.constraints.push_back(reach);
  }
  return published_scene(body, of.dt, of.substeps, of.iterations, of.gravity);
}

SpringSystem system_of(const Hanging& of) {
  std::vector<double> mass(kParticles, 1.0);
  mass.back() = of.weight;
  return chain_system(mass, of.spacing, of.stiffness, {0, -1, 0}, {0, -of.gravity, 0});
}

/// `down`: how far the weight is below its place after each frame, m.
Json stretches(const std::vector<double>& down) {
  std::size_t lowest = 0;
  while (lowest + 1 < down.size() && down[lowest + 1] >= down[lowest]) ++lowest;
  double sum = 0;
  const std::size_t end = std::min(2 * lowest + 1, down.size());
  for (std::size_t k = 0; k < end; ++k) sum += down[k];
  return {{"most_m", down[lowest]}, {"still_m", sum / static_cast<double>(end)}, {"frame", lowest + 1}};
}

template <class Step>
Json swing(const Hanging& of, const Step& step) {
  std::vector<double> down;
  for (int frame = 0; frame < kFrames; ++frame) down.push_back(-step() - kLinks * of.spacing);
  return stretches(down);
}

Json in_order(const Hanging& of) {
  const SpringSystem system = system_of(of);
  State state = system.start;
  return swing(of, [&] {
    for (int k = 0; k < of.substeps; ++k) sweep_in_order(system, of.dt / of.substeps, of.iterations, state);
    return state.x[3 * kLinks + 1];
  });
}

}  // namespace

std::string key(const Hanging& of) {
  return formatted("%g kg, k = %g, step %.9g s, g = %g, %dx%d%s", of.weight, of.stiffness, of.dt, of.gravity,
                   of.substeps, of.iterations, of.long_range ? ", long range" : "");
}

Json by_malha(const Hanging& of) {
  const bench::ScratchFolder folder;
  Simulation simulation(scene_of(of, folder.path()), {.threads = 1});
  return swing(of, [&] { return simulation.step(), simulation.positions()[kParticles - 1][1]; });
}

Json by_newton(const Hanging& of) {
  const SpringSystem system = system_of(of);
  BackwardEuler newton(system);
  State state = system.start;
  return swing(of, [&] { return newton.step(of.dt, state), state.x[3 * kLinks + 1]; });
}

Runs runs(Cells& cells, const std::string& name, const Hanging& of) {
  const Json cell = cells(name + ": " + key(of), [&] {
    return Json{{"malha", by_malha(of)}, {"plain", in_order(of)}};
  });
  Runs runs{cell["malha"], cell["plain"]};
  keep_machine(runs.malha, cell), keep_machine(runs.plain, cell);
  return runs;
}

Json row(const char* name, const Hanging& of, const char* method, const Json& run) {
  Json row{{"case", name},
           {"what", "how far the weight gets below its place"},
           {"method", method},
           {"dt_s", of.dt},
           {"gravity_m_per_s2", of.gravity},
           {"substeps", of.substeps},
           {"iterations", of.iterations},
           {"most_m", run["most_m"]},
           {"still_m", run["still_m"]},
           {"frame", run["frame"]}};
  keep_machine(row, run);
  return row;
}

}  // namespace malha::study
