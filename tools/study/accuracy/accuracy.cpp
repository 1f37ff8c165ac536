// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/accuracy.h"

#include "tools/study/accuracy/order.h"
#include "tools/study/accuracy/replays.h"
#include "tools/study/accuracy/sections.h"

namespace malha::study {

namespace {

/// Substeps and iterations as "10x1" or "1x10", or of Desbrun's method substeps and refinements as "1, r = 4".
std::string settings(const Method& method) {
  const SolverSpec& solver = method.solver;
  const std::string n = std::to_string(solver.substeps);
  if (method.integrator != Integrator::Malha) return n + " a frame";
  return solver.type == "pbd" ? n + "x" + std::to_string(solver.iterations)
                              : n + ", r = " + std::to_string(solver.desbrun.refinement_iterations);
}

/// Adds a row for each time up to the method's last. It has no errors where the run ended before.
void add_rows(const AccuracyCase& test_case, const Method& method, const Truth& truth, const Json& cell, Json& rows) {
  for (std::size_t k = 0; k < test_case.times.size() && test_case.times[k] <= method.end_time; ++k) {
    Json row{{"case", test_case.name},
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
             {"time_s", test_case.times[k]},
             {"truth_known_to_m", truth.uncertainty[k]},
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
  for (const AccuracyCase& test_case : cases)
    planned += static_cast<int>(accuracy_methods(test_case, cells.quick()).size()) + (test_case.exact ? 0 : 3);
  cells.plan(planned);
  const auto add = [&](const AccuracyCase& test_case) {
    const std::unique_ptr<System> system = system_of(test_case);
    const Truth truth = truth_of(test_case, *system, cells);
    for (const Method& method : accuracy_methods(test_case, cells.quick()))
      add_rows(test_case, method, truth,
               cells(test_case.name + ": " + method.key(),
                     [&] { return accuracy_cell(test_case, *system, method, truth, cells); }),
               findings.rows);
    std::vector<Section> sections = accuracy_sections(test_case, truth, findings.rows);
    sections[0].replays = accuracy_replays(test_case);
    findings.sections.insert(findings.sections.end(), sections.begin(), sections.end());
  };
  for (const AccuracyCase& test_case : cases)
    cells.measure_together([&] { add(test_case); });  // its errors need its reference solution
  findings.sections.push_back(order_of_convergence(cells, findings.rows));
  return findings;
}

}  // namespace malha::study
