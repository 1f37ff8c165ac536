// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/replays.h"

#include "malha/text.h"

namespace malha::study {

namespace {

constexpr int kTruth = 1024;  // substeps a frame

Scene named(const std::string& name, const AccuracyCase& of, const SolverSpec& solver) {
  Scene scene = with_solver(of, solver, true);
  scene.name = name, scene.duration = of.times[0] + 1;
  return scene;
}

Scene by_substeps(const AccuracyCase& of, int substeps) {
  SolverSpec solver;
  solver.substeps = substeps, solver.iterations = 1, solver.precision = Precision::Double;
  return named(counted(substeps, "substep"), of, solver);
}

Scene by_corrector(const AccuracyCase& of, const std::string& name, Corrector corrector) {
  SolverSpec solver;
  solver.type = "desbrun", solver.substeps = 1, solver.desbrun.corrector = corrector;
  return named(name, of, solver);
}

}  // namespace

std::vector<Replay> accuracy_replays(const AccuracyCase& of) {
  if (of.name == "shell")
    return {{"shell_correctors", of.title + ": Desbrun's method with the paper's corrector, beside that by inertia",
             by_corrector(of, "the paper's corrector", Corrector::Paper),
             by_corrector(of, "by inertia", Corrector::Inertia)}};
  if (of.name != "sheet7" && of.name != "sheet17") return {};
  std::vector<Replay> all;
  for (const int substeps : {1, 100})
    all.push_back({of.name + "_" + std::to_string(substeps),
                   of.title + ": " + counted(substeps, "substep") + " a frame beside " + counted(kTruth, "substep") +
                       ", close to the true motion",
                   by_substeps(of, substeps), by_substeps(of, kTruth)});
  return all;
}

}  // namespace malha::study
