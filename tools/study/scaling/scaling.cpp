// SPDX-License-Identifier: Apache-2.0
#include "tools/study/scaling/scaling.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "malha/text.h"
#include "tools/bench/medians.h"
#include "tools/study/rows.h"
#include "tools/study/scaling/cell.h"
#include "tools/study/scaling/sections.h"

namespace malha::study {

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return std::string(name) + (value ? "=" + std::string(value) : " not set");
}

std::vector<int> strong_sides(const ClothMethod& method, bool quick) {
  if (quick) return method.filter == FilterKind::Dense ? std::vector{17} : std::vector{17, 100};
  if (method.filter == FilterKind::Dense) return {17, 46, 100};
  return {17, 46, 100, 316, 1000};
}

/// Sides of the body of one thread; bodies of more threads have as many particles per thread.
std::vector<int> weak_sides(const ClothMethod& method, bool quick) {
  if (method.filter == FilterKind::Dense) return {};  // work grows with the square of the particles
  return quick ? std::vector{50} : std::vector{100, 316};
}

/// A body and a method, measured on all numbers of threads.
struct ScalingCase {
  const char* kind;
  const ClothMethod& method;
  int side;
};

/// All cases; without weak scaling on a device, whose number of threads is fixed.
std::vector<ScalingCase> scaling_cases(bool quick, bool on_device) {
  std::vector<ScalingCase> all;
  for (const bool weak : on_device ? std::vector{false} : std::vector{false, true})
    for (const ClothMethod& method : cloth_methods())
      for (const int side : weak ? weak_sides(method, quick) : strong_sides(method, quick))
        all.push_back({weak ? "weak" : "strong", method, side});
  return all;
}

std::vector<ScalingRun> scaling_runs(int side, bool weak, const std::vector<int>& threads) {
  std::vector<ScalingRun> all;
  for (const int t : threads) all.push_back({t, weak ? static_cast<int>(std::lround(side * std::sqrt(t))) : side});
  return all;
}

std::vector<double> numbers(const Json& json) { return json.get<std::vector<double>>(); }

/// Smallest and largest speed-up of the turns.
std::pair<double, double> least_and_most(const std::vector<double>& one, const std::vector<double>& all) {
  std::pair ends{1e300, 0.0};
  for (std::size_t run_turn = 0; run_turn < one.size(); ++run_turn)
    ends = {std::min(ends.first, one[run_turn] / all[run_turn]), std::max(ends.second, one[run_turn] / all[run_turn])};
  return ends;
}

Json row_of(const Json& base, const ClothMethod& method, const Json& line, const Json& one) {
  const int t = line["threads"].get<int>();
  const double step = bench::median(numbers(line["step_s"]));
  const double faster = bench::median_ratio(numbers(one["step_s"]), numbers(line["step_s"]));
  Json row = base;
  row["threads"] = t, row["particles"] = line["particles"], row["step_ms"] = step * 1e3;
  row["times_as_fast"] = faster, row["efficiency"] = base["kind"] == "weak" ? faster : faster / t;
  const auto [least, most] = least_and_most(numbers(one["step_s"]), numbers(line["step_s"]));
  row["least_times_as_fast"] = least, row["most_times_as_fast"] = most;
  row["undisturbed_step_s"] = line["least_step_s"];
  row["undisturbed_times_as_fast"] = one["least_step_s"].get<double>() / line["least_step_s"].get<double>();
  row["setup_s"] = line["setup_s"], row["hash"] = line["hash"];
  const int patches = line["patches"].get<int>();  // Desbrun's method has none
  row["imbalance_by_patches"] = patches > 0 ? Json(imbalance(patches, line["patch_colors"].get<int>(), t)) : Json();
  const char* largest = method.desbrun ? "filter" : "fused_solve";
  const double pass = line["passes_s"].value(largest, step);
  row["gb_per_s"] = line["must_move_bytes"].get<double>() / pass / 1e9, row["triad_gb_per_s"] = line["triad_gb_per_s"];
  row["patch_colors"] = line["patch_colors"];
  for (const auto& [name, seconds] : line["passes_s"].items()) {
    row[name + "_ms"] = seconds.get<double>() * 1e3;
    if (one["passes_s"].contains(name))
      row[name + "_times_as_fast"] = one["passes_s"][name].get<double>() / seconds.get<double>();
  }
  return row;
}

}  // namespace

Json scaling_rows(const std::string& kind, const ClothMethod& method, int side, const Json& cell) {
  Json base{{"kind", kind}, {"method", method.name}, {"side", side}, {"left_out", nullptr}};
  if (cell.contains("left_out")) {
    base["left_out"] = cell["left_out"];
    return Json::array({base});
  }
  base["load_average"] = cell["load_average"];
  if (cell.contains("device")) base["device"] = cell["device"];
  copy_machine(base, cell);
  Json rows = Json::array();
  std::vector<int> threads;
  std::vector<double> medians;
  for (const Json& line : cell["lines"]) {
    rows.push_back(row_of(base, method, line, cell["lines"][0]));
    threads.push_back(line["threads"].get<int>()), medians.push_back(bench::median(numbers(line["step_s"])));
  }
  if (kind == "weak") return rows;
  const std::optional<double> share = serial_fraction(threads, medians);
  for (Json& row : rows) row["serial_share"] = share ? Json(*share) : Json(nullptr);
  return rows;
}

Findings run_scaling(Cells& cells) {
  const bool quick = cells.quick(), on_device = cells.runs_on().is_device();
  Findings findings;
  const std::vector<int> threads = on_device ? std::vector{1} : scaling_threads(cells.cores());
  const std::vector<ScalingCase> cases = scaling_cases(quick, on_device);
  cells.plan(static_cast<int>((on_device ? 0 : threads.size()) + cases.size()));
  std::vector<Json> launches;
  if (!on_device)
    launches = cells.measure_all(
        threads, [](int t) { return "launches on " + counted(t, "thread"); },
        [&](int t) { return launch_costs(t, quick); });
  const std::vector<Json> bodies = cells.measure_all(
      cases,
      [](const ScalingCase& of) {
        return std::string(of.kind) + ": " + of.method.name + ", " + with_commas(of.side * of.side) + " particles";
      },
      [&](const ScalingCase& of) {
        return scaling_cell(of.method, scaling_runs(of.side, of.kind == std::string("weak"), threads), cells);
      });
  if (cells.is_partial()) return findings;
  for (const Json& cell : launches) {
    Json row{{"kind", "launch"}};
    row.update(cell);
    findings.rows.push_back(row);
  }
  for (std::size_t k = 0; k < cases.size(); ++k)
    for (const Json& row : scaling_rows(cases[k].kind, cases[k].method, cases[k].side, bodies[k]))
      findings.rows.push_back(row);
  if (on_device)
    findings.sections = {scaling_on_device(findings.rows)};
  else
    findings.sections = scaling_sections(findings.rows, variable("OMP_PROC_BIND") + ", " + variable("OMP_PLACES"));
  return findings;
}

}  // namespace malha::study
