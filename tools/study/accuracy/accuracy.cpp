// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/accuracy.h"

#include "tools/study/accuracy/order.h"
#include "tools/study/accuracy/replays.h"
#include "tools/study/accuracy/sections.h"

namespace malha::study {

namespace {

/// "10x1", "1x10", "1, r = 4": substeps, iterations, refine.
std::string settings(const Method& method) {
  const SolverSpec& solver = method.solver;
  const std::string n = std::to_string(solver.substeps);
  if (method.integrator != Integrator::Malha) return n + " a frame";
  return solver.type == "pbd" ? n + "x" + std::to_string(solver.iterations)
                              : n + ", r = " + std::to_string(solver.desbrun.refinement_iterations);
}

/// A row a time up to the method's last, where the run had got so far; otherwise one without errors.
void add_rows(const AccuracyCase& of, const Method& method, const Truth& truth, const Json& cell, Json& rows) {
  for (std::size_t k = 0; k < of.times.size() && of.times[k] <= method.release_time; ++k) {
    Json row{{"case", of.name},
             {"series", method.series},
             {"settings", settings(method)},
             {"variant", method.variant},
             {"ours", method.integrator == Integrator::Malha},
             {"precision", method.solver.precision == Precision::Float ? "float" : "double"},
             {"substeps", method.solver.substeps},
             {"iterations", method.solver.iterations},
             {"refinement_iterations", method.solver.desbrun.refinement_iterations},
             {"key", method.key()},
             {"status", cell["status"]},
             {"time_s", of.times[k]},
             {"truth_known_to_m", truth.known[k]},
             {"rms_error_m", nullptr}};
    for (const auto& [name, value] : cell.items())
      if (name != "at" && name != "status") row[name] = value;
    if (k < cell["at"].size())
      for (const auto& [name, value] : cell["at"][k].items()) row[name] = value;
    rows.push_back(row);
  }
}

}  // namespace

Findings run_accuracy(Cells& cells) {
  Findings findings;
  const std::vector<AccuracyCase> cases = accuracy_cases(cells.quick());
  int planned = order_cells(cells.quick());
  for (const AccuracyCase& of : cases)
    planned += static_cast<int>(accuracy_methods(of, cells.quick()).size()) + (of.exact ? 0 : 3);
  cells.plan(planned);
  const auto add = [&](const AccuracyCase& of) {
    const std::unique_ptr<System> system = system_of(of);
    const Truth truth = truth_of(of, *system, cells);
    for (const Method& method : accuracy_methods(of, cells.quick()))
      add_rows(of, method, truth,
               cells(of.name + ": " + method.key(), [&] { return accuracy_cell(of, *system, method, truth, cells); }),
               findings.rows);
    std::vector<Section> sections = accuracy_sections(of, truth, findings.rows);
    sections[0].replays = accuracy_replays(of);
    findings.sections.insert(findings.sections.end(), sections.begin(), sections.end());
  };
  for (const AccuracyCase& of : cases) cells.together([&] { add(of); });  // its errors need its truth
  findings.sections.push_back(order_of_convergence(cells, findings.rows));
  return findings;
}

}  // namespace malha::study
