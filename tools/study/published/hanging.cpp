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

/// Masses follow the lengths of segments. The weight is therefore the last particle together with one more far below
/// it, connected by a segment that is as long as its mass requires.
Scene scene_of(const HangingWeight& hanging, const std::filesystem::path& folder) {
  const std::string file = (folder / "chain.obj").string();
  const double rod = (hanging.weight - 0.5) * hanging.spacing;
  std::ofstream mesh(file);
  mesh.precision(17);
  for (int i = 0; i < kParticles; ++i) mesh << "v 0 " << -i * hanging.spacing << " 0\n";
  mesh << "v 0 " << -kLinks * hanging.spacing - rod << " 0\nl";
  for (int i = 1; i <= kParticles + 1; ++i) mesh << " " << i;
  mesh << "\n";
  BodySpec body;
  body.name = "chain", body.shape = MeshFile{file}, body.density = 1 / hanging.spacing, body.pins = {ListPin{{0}}};
  ConstraintSpec links;
  links.type = "distance", links.elements = {"edges"};
  if (hanging.stiffness < kInfinite) links.compliance = 1 / hanging.stiffness;
  body.constraints = {links};
  if (hanging.long_range) {
    ConstraintSpec reach;
    reach.type = "long_range", reach.parameter = 0.02;
    body.constraints.push_back(reach);
  }
  return published_scene(body, hanging.dt, hanging.substeps, hanging.iterations, hanging.gravity);
}

SpringSystem system_of(const HangingWeight& hanging) {
  std::vector<double> mass(kParticles, 1.0);
  mass.back() = hanging.weight;
  return chain_system(mass, hanging.spacing, hanging.stiffness, {0, -1, 0}, {0, -hanging.gravity, 0});
}

/// `down`: distance of the weight below its initial position after each frame, m.
Json stretches(const std::vector<double>& down) {
  std::size_t lowest = 0;
  while (lowest + 1 < down.size() && down[lowest + 1] >= down[lowest]) ++lowest;
  double sum = 0;
  const std::size_t end = std::min(2 * lowest + 1, down.size());
  for (std::size_t k = 0; k < end; ++k) sum += down[k];
  return {{"most_m", down[lowest]}, {"still_m", sum / static_cast<double>(end)}, {"frame", lowest + 1}};
}

template <class Step>
Json swing(const HangingWeight& hanging, const Step& step) {
  std::vector<double> down;
  for (int frame = 0; frame < kFrames; ++frame) down.push_back(-step() - kLinks * hanging.spacing);
  return stretches(down);
}

Json ordered_sweep_swing(const HangingWeight& hanging) {
  const SpringSystem system = system_of(hanging);
  State state = system.start;
  return swing(hanging, [&] {
    for (int k = 0; k < hanging.substeps; ++k)
      xpbd_step(system, hanging.dt / hanging.substeps, hanging.iterations, state);
    return state.x[3 * kLinks + 1];
  });
}

}  // namespace

std::string key_of(const HangingWeight& hanging) {
  return formatted("%g kg, k = %g, step %.9g s, g = %g, %dx%d%s", hanging.weight, hanging.stiffness, hanging.dt,
                   hanging.gravity, hanging.substeps, hanging.iterations, hanging.long_range ? ", long range" : "");
}

Json malha_swing(const HangingWeight& hanging) {
  const bench::ScratchFolder folder;
  Simulation simulation(scene_of(hanging, folder.path()), {.threads = 1});
  return swing(hanging, [&] { return simulation.step(), simulation.positions()[kParticles - 1][1]; });
}

Json newton_swing(const HangingWeight& hanging) {
  const SpringSystem system = system_of(hanging);
  BackwardEuler newton(system);
  State state = system.start;
  return swing(hanging, [&] { return newton.step(hanging.dt, state), state.x[3 * kLinks + 1]; });
}

SwingResults measure_swings(Cells& cells, const std::string& name, const HangingWeight& hanging) {
  const Json cell = cells(name + ": " + key_of(hanging), [&] {
    return Json{{"malha", malha_swing(hanging)}, {"plain", ordered_sweep_swing(hanging)}};
  });
  SwingResults measure_swings{cell["malha"], cell["plain"]};
  copy_machine(measure_swings.malha, cell), copy_machine(measure_swings.plain, cell);
  return measure_swings;
}

Json row(const char* name, const HangingWeight& hanging, const char* method, const Json& run) {
  Json row{{"case", name},
           {"what", "how far the weight gets below its place"},
           {"method", method},
           {"dt_s", hanging.dt},
           {"gravity_m_per_s2", hanging.gravity},
           {"substeps", hanging.substeps},
           {"iterations", hanging.iterations},
           {"most_m", run["most_m"]},
           {"still_m", run["still_m"]},
           {"frame", run["frame"]}};
  copy_machine(row, run);
  return row;
}

}  // namespace malha::study
