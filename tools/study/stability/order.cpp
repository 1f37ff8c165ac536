// SPDX-License-Identifier: Apache-2.0
// Map of the study "stability" over the order in which constraints are projected.
#include <algorithm>
#include <cmath>

#include "malha/error.h"
#include "tools/bench/output.h"
#include "tools/study/reference/sweep.h"
#include "tools/study/rows.h"
#include "tools/study/stability/maps.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kSheetSide = 2, kSheetMass = 1;  // m, kg

constexpr double kCompliance = 1e-4;  // m/N, of soft constraints

Scene sheet(int n, int substeps, Precision precision, bool soft) {
  Scene scene = corner_pinned_sheet(n, kSheetSide, kSheetMass, soft ? kCompliance : 0);
  scene.solver.substeps = substeps, scene.solver.precision = precision;
  return scene;
}

/// The same sheet for plain sweeps, which do not use the stiffness of its springs.
std::unique_ptr<SpringSystem> constraints_of(int n) {
  auto system = spring_system(corner_pinned_sheet(n, kSheetSide, kSheetMass, 1));
  for (Spring& s : system->springs) s.stiffness = 0;  // no elastic energy
  return system;
}

struct Sweep {
  std::string title;
  bool is_malha, from_pins;
  Precision precision;
  bool soft = false;
};

template <class R>
Trial plain(const SpringSystem& system, const std::vector<int>& order, double compliance, int substeps, int frames) {
  const auto sweep = std::make_shared<PlainSweep<R>>(system, order, compliance);
  return {[=] {
            for (int s = 0; s < substeps; ++s) sweep->substep(kFrame / substeps);
          },
          [=, &system] { return sample_of(system, sweep->state()); }, frames, kSheetMass * kGravity * kSheetSide};
}

Trial trial_of(const Sweep& sweep, const SpringSystem& system, int n, int substeps, int frames) {
  if (sweep.is_malha)
    return malha_trial(sheet(n, substeps, sweep.precision, sweep.soft), frames, kSheetMass * kGravity * kSheetSide);
  const std::vector<int> order = sweep.from_pins ? order_from_pins(system) : order_by_colour(system);
  const double compliance = sweep.soft ? kCompliance : 0;
  return sweep.precision == Precision::Float ? plain<float>(system, order, compliance, substeps, frames)
                                             : plain<double>(system, order, compliance, substeps, frames);
}

/// RMS strain after each frame, as long as it is finite.
Json strains(const Trial& trial, const Cells& cells) {
  Json all = Json::array();
  try {
    for (int frame = 0; frame < trial.steps; ++frame) {
      trial.step();
      cells.check_interrupt();
      const double strain = trial.sample().rms;
      if (!std::isfinite(strain)) break;
      all.push_back(strain);
    }
  } catch (const Diverged&) {
  }
  return {{"rms", all}};
}

Section history(const std::vector<Sweep>& sweeps, Cells& cells, Json& rows) {
  const int n = cells.quick() ? 33 : 100, substeps = cells.quick() ? 10 : 40, frames = 60;
  const auto system = constraints_of(n);
  Section section{formatted("Order of the sweep: %d x %d particles, %d substeps of 1 iteration", n, n, substeps)};
  Chart chart{"order_time",
              formatted("set title '%d x %d particles, %d substeps of 1 iteration'\nset logscale y\nset format y "
                        "'10^{%%T}'\nset xlabel 'time (s)'\nset ylabel 'RMS strain'\nset yrange [1e-4:1e15]\n",
                        n, n, substeps)};
  section.table.columns = {"sweep", "RMS strain at the end", "frames until it was no longer finite"};
  const char* styles[] = {"lc rgb '#d55e00'", "lc rgb '#e69f00'",      "lc rgb '#000000'", "lc rgb '#661100'",
                          "lc rgb '#0072b2'", "lc rgb '#56b4e9' dt 2", "lc rgb '#cc79a7'", "lc rgb '#009e73'"};
  const std::vector<Json> kept = cells.measure_all(
      sweeps,
      [&](const Sweep& sweep) { return formatted("order over time: %s, %d, %d", sweep.title.c_str(), n, substeps); },
      [&](const Sweep& sweep) { return strains(trial_of(sweep, *system, n, substeps, frames), cells); });
  if (cells.is_partial()) return section;
  for (std::size_t k = 0; k < sweeps.size(); ++k) {
    const Sweep& sweep = sweeps[k];
    const Json& all = kept[k]["rms"];
    // Later lines are drawn over earlier ones, and thinner, so that all are visible where they coincide.
    const double width = 2.5 + 1.3 * double(sweeps.size() - k);
    bench::Series series{"", formatted("with lines lw %g ", width) + styles[k % 8], sweep.title};
    for (std::size_t frame = 0; frame < all.size(); ++frame)
      series.data += formatted("%.6g %.6g\n", double(frame + 1) * kFrame, all[frame].get<double>());
    chart.series.push_back(series);
    const double last = all.empty() ? 0 : all.back().get<double>();
    const bool finite = int(all.size()) == frames;
    section.table.rows.push_back({sweep.title, formatted("%.2g", last), finite ? "" : std::to_string(all.size())});
    rows.push_back({{"map", "order_time"},
                    {"panel", sweep.title},
                    {"x", n},
                    {"y", substeps},
                    {"rms_strain", last},
                    {"frames", all.size()}});
    copy_machine(rows.back(), kept[k]);
    section.sentences.push_back(
        sweep.title +
        (finite ? formatted(": RMS strain %.2g after %g s.", last, frames * kFrame)
                : formatted(": no longer finite after %zu frames, RMS strain %.2g before.", all.size(), last)));
  }
  section.chart = chart;
  return section;
}

}  // namespace

std::vector<Section> order_map(Cells& cells, Json& rows) {
  const bool quick = cells.quick();
  const std::vector<Sweep> sweeps{{"plain, from the pins, double", false, true, Precision::Double},
                                  {"plain, from the pins, float", false, true, Precision::Float},
                                  {"plain, colours, double", false, false, Precision::Double},
                                  {"plain, colours, float", false, false, Precision::Float},
                                  {"malha, double", true, false, Precision::Double},
                                  {"malha, float", true, false, Precision::Float},
                                  {"plain, from the pins, 10 kN/m", false, true, Precision::Float, true},
                                  {"malha, 10 kN/m", true, false, Precision::Float, true}};
  const Axis x{"particles a side", quick ? std::vector<double>{9, 33} : std::vector<double>{9, 17, 33, 65, 100}};
  const Axis y{"substeps", quick ? std::vector<double>{40, 10} : std::vector<double>{160, 80, 40, 20, 10}};
  std::vector<std::unique_ptr<SpringSystem>> systems;
  for (const double n : x.values) systems.push_back(constraints_of(int(n)));
  std::vector<Panel> panels;
  for (const Sweep& sweep : sweeps) {
    Panel panel{sweep.title, x, y, {}, {}, sweep.is_malha};
    run_columns(panel, cells, "order: " + sweep.title + ", ", "", true, [&](std::size_t k, double substeps) {
      return judge(trial_of(sweep, *systems[k], int(x.values[k]), int(substeps), 60), cells);
    });
    panels.push_back(panel);
  }
  Section map{"Order of the sweep, by resolution and substeps"};
  Json over_time = Json::array();
  const Section after = history(sweeps, cells, over_time);
  if (cells.is_partial()) return {};
  map.sentences = {
      "A sheet of 2 m and 1 kg, pinned at two corners, is released from the horizontal for 1 s; hard constraints, or "
      "springs of 10 kN/m, one sweep per substep. Plain: one constraint after the other, in order of the graph "
      "distance "
      "from the pins, or by colours."};
  for (const Panel& panel : panels) {
    int count[3]{};
    double gain = 0, strain = 0;
    for (const Json& column : panel.columns) {
      for (const auto& verdict : column["verdicts"]) ++count[verdict.get<int>()];
      for (const auto& one : column["gains"]) gain = std::max(gain, one.get<double>());
      for (const auto& one : column["rms"]) strain = std::max(strain, one.get<double>());
    }
    map.sentences.push_back(
        panel.title + formatted(": %d of %d stable, %d bounded but wrong, %d diverged; what did not diverge gained at "
                                "most %.2g times the energy of the fall, at an RMS strain of at most %.2g.",
                                count[0], count[0] + count[1] + count[2], count[1], count[2], gain, strain));
  }
  complete_map_section(map, "order", "Order of the sweep: one iteration a substep", panels, 4, rows);
  rows.insert(rows.end(), over_time.begin(), over_time.end());
  return {map, after};
}

}  // namespace malha::study
