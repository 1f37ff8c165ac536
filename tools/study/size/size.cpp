// SPDX-License-Identifier: Apache-2.0
#include "tools/study/size/size.h"

#include <algorithm>

#include "host/base/memory_size.h"
#include "host/base/stopwatch.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tools/bench/medians.h"
#include "tools/bench/output.h"
#include "tools/study/cloth_methods.h"
#include "tools/study/resident.h"
#include "tools/study/size/errors.h"
#include "tools/study/size/sections.h"

namespace malha::study {

namespace {

constexpr int kTurns = 5;

std::vector<int> sides(const ClothMethod& method, bool quick) {
  if (quick) return method.filter == FilterKind::Dense ? std::vector{17, 34} : std::vector{17, 46, 100, 142};
  std::vector<int> all{17, 46, 100, 141, 316, 562, 1000, 2000};
  const int most = method.filter == FilterKind::Dense ? 141 : 2000;
  all.erase(std::upper_bound(all.begin(), all.end(), most), all.end());
  return all;
}

Json parts(const NamedNumbers& all) {
  Json json;
  for (const auto& [name, number] : all)
    if (number > 0) json[name] = number;
  return json;
}

double sum(const NamedNumbers& all) {
  double sum = 0;
  for (const auto& [name, number] : all) sum += number;
  return sum;
}

Json run(const ClothMethod& method, int side, const Cells& cells) {
  const double particles = static_cast<double>(side) * side, needs = method.setup_peak_bytes(particles);
  const auto has = static_cast<double>(available_memory());
  if (needs > 0.8 * has) return {{"left_out", "it takes " + in_gib(needs) + ", and " + in_gib(has) + " are free"}};
  const auto before = resident_bytes();
  reset_peak();
  std::unique_ptr<Simulation> simulation;
  std::vector<double> setups;  // short set-ups are repeated
  do {
    simulation.reset();
    setups.push_back(seconds(
        [&] { simulation = std::make_unique<Simulation>(method.scene(side), SimulationOptions{.threads = 1}); }));
  } while (setups[0] < 0.3 && static_cast<int>(setups.size()) < kTurns);
  cells.check_interrupt();
  simulation->step();
  const auto peak = peak_bytes(), resident = resident_bytes();
  // All sizes are measured for as long, so that a single interrupt does not distort a small body's time.
  std::vector<double> steps;
  for (int turn = 0; turn < kTurns; ++turn) {
    steps.push_back(bench::mean_seconds([&] { simulation->step(); }, cells.quick() ? 0.005 : 0.2));
    cells.check_interrupt();
  }
  const SolverStats& facts = simulation->solver().facts();
  const NamedNumbers memory = memory_parts(simulation->model(), facts);
  Json cell{{"particles", simulation->model().count()},
            {"projections_per_step", facts.projections_per_step},
            {"step_s", bench::median(steps)},
            {"step_least_s", *std::min_element(steps.begin(), steps.end())},
            {"step_most_s", *std::max_element(steps.begin(), steps.end())},
            {"setup_s", bench::median(setups)},
            {"setup_parts_s", parts(setup_parts(simulation->model(), facts))},
            {"bytes", sum(memory)},
            {"bytes_by_owner", parts(memory)},
            {"held_bytes", nullptr},
            {"peak_bytes", nullptr}};
  if (before && resident) cell["held_bytes"] = *resident - *before;
  if (before && peak) cell["peak_bytes"] = *peak - *before;
  return cell;
}

/// A flat row: nested values get names such as bytes_by_owner_particles.
Json row(const ClothMethod& method, int side, const Json& cell) {
  Json row{{"method", method.name}, {"side", side}, {"particles", side * side}, {"left_out", nullptr}};
  for (const auto& [name, value] : cell.items()) {
    if (!value.is_object()) row[name] = value;
    if (value.is_object())
      for (const auto& [part, number] : value.items()) row[name + "_" + part] = number;
  }
  return row;
}

}  // namespace

Findings run_size(Cells& cells) {
  Findings findings;
  int planned = 0;
  for (const ClothMethod& method : cloth_methods()) planned += static_cast<int>(sides(method, cells.quick()).size());
  cells.plan(planned + size_error_cells(cells.quick()));
  for (const ClothMethod& method : cloth_methods())
    for (const int side : sides(method, cells.quick()))
      findings.rows.push_back(row(method, side,
                                  cells(method.name + ", " + with_commas(side * side) + " particles",
                                        [&] { return run(method, side, cells); })));
  const Json errors = size_errors(cells);
  if (cells.is_partial()) return findings;
  findings.sections = size_sections(findings.rows);
  add_size_errors(errors, findings);
  return findings;
}

}  // namespace malha::study
