// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/replays.h"

#include "malha/text.h"

namespace malha::study {

namespace {

constexpr int kTruth = 1024;  // substeps a frame

Scene named(const std::string& name, const AccuracyCase& test_case, const SolverSpec& solver) {
  Scene scene = with_solver(test_case, solver, true);
  scene.name = name, scene.duration = test_case.times[0] + 1;
  return scene;
}

Scene by_substeps(const AccuracyCase& test_case, int substeps) {
  SolverSpec solver;
  solver.substeps = substeps, solver.iterations = 1, solver.precision = Precision::Double;
  return named(counted(substeps, "substep"), test_case, solver);
}

Scene by_corrector(const AccuracyCase& test_case, const std::string& name, Corrector corrector) {
  SolverSpec solver;
  solver.type = "desbrun", solver.substeps = 1, solver.desbrun.corrector = corrector;
  return named(name, test_case, solver);
}

}  // namespace

std::vector<Replay> accuracy_replays(const AccuracyCase& test_case) {
  if (test_case.name == "shell")
    return {{"shell_correctors",
             test_case.title + ": Desbrun's method with the paper's corrector, beside that by inertia",
             by_corrector(test_case, "the paper's corrector", Corrector::Paper),
             by_corrector(test_case, "by inertia", Corrector::Inertia)}};
  if (test_case.name != "sheet7" && test_case.name != "sheet17") return {};
  std::vector<Replay> all;
  for (const int substeps : {1, 100})
    all.push_back({test_case.name + "_" + std::to_string(substeps),
                   test_case.title + ": " + counted(substeps, "substep") + " a frame beside " +
                       counted(kTruth, "substep") + ", close to the true motion",
                   by_substeps(test_case, substeps), by_substeps(test_case, kTruth)});
  return all;
}

}  // namespace malha::study
