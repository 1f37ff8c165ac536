// SPDX-License-Identifier: Apache-2.0
// Frame rates in a thesis of 2008 on Desbrun's method and PBD, measured on a Core 2 Duo at 2.2 GHz with rendering.
#include "host/base/stopwatch.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tools/bench/medians.h"
#include "tools/bench/output.h"
#include "tools/study/published/parts.h"
#include "tools/study/rows.h"

namespace malha::study {

namespace {

using bench::formatted;

struct Sheet {
  std::string title;
  std::array<int, 2> cells;
  bool desbrun;
  FilterKind filter;
  std::string printed;
};

const std::vector<Sheet>& sheets() {
  static const std::vector<Sheet> all{
      {"Desbrun, 289 particles, dense", {16, 16}, true, FilterKind::Dense, "50 frames/s"},
      {"Desbrun, 506 particles, dense", {21, 22}, true, FilterKind::Dense, "precomputation very slow beyond 500"},
      {"Desbrun, 506 particles, sparse", {21, 22}, true, FilterKind::Sparse, ""},
      {"Desbrun, 2025 particles, dense", {44, 44}, true, FilterKind::Dense, ""},
      {"PBD, 2025 particles", {44, 44}, false, FilterKind::Auto, "50 frames/s (over 2000)"}};
  return all;
}

/// A sheet of 1 m and 0.2 kg hangs by two corners; a step is a frame of 1/50 s.
Scene scene_of(const Sheet& sheet) {
  BodySpec body;
  body.name = "sheet", body.shape = GridShape{{1, 1}, sheet.cells}, body.mass = 0.2;
  body.pins = {ListPin{{0, sheet.cells[0]}}};
  ConstraintSpec springs;
  springs.type = "distance", springs.elements = {"edges", "shear"};
  body.constraints = {springs};
  Scene scene = published_scene(body, 1.0 / 50, 10, 1);
  scene.solver.precision = Precision::Float;
  if (sheet.desbrun) {
    scene.solver.type = "desbrun", scene.solver.substeps = 1, scene.solver.iterations = 10;
    scene.solver.desbrun.filter = sheet.filter, scene.solver.desbrun.spring_constant = 1000;
  }
  return scene;
}

Json time_sheet(const Sheet& sheet, bool quick, const Cells& cells) {
  std::vector<double> setups, frames;
  std::unique_ptr<Simulation> simulation;
  for (int turn = 0; turn < (quick ? 1 : 5); ++turn)
    setups.push_back(
        seconds([&] { simulation = std::make_unique<Simulation>(scene_of(sheet), SimulationOptions{.threads = 1}); }));
  for (int frame = 0; frame < (quick ? 20 : 500); ++frame) {
    frames.push_back(seconds([&] { simulation->step(); }));
    cells.check_interrupt();
  }
  Json cell{{"particles", simulation->positions().size()},
            {"setup_s", bench::median(setups)},
            {"frame_s", bench::median(frames)},
            {"filter_setup_s", nullptr},
            {"strain_max", simulation->measure().strain_max}};
  if (const auto& filter = simulation->solver().facts().filter)
    cell["filter_setup_s"] = filter->order_seconds + filter->factor_seconds + filter->column_seconds;
  return cell;
}

void add_sheets(Cells& cells, Findings& findings) {
  Section section{"A thesis of 2008: both methods side by side"};
  section.table.columns = {"case", "printed", "malha, frames/s", "ms a frame", "set-up, ms"};
  std::string summary;
  const std::vector<Sheet> all = sheets();
  const std::vector<Json> kept = cells.measure_all(
      all, [](const Sheet& sheet) { return "sheet: " + sheet.title; },
      [&](const Sheet& sheet) { return time_sheet(sheet, cells.quick(), cells); });
  if (cells.is_partial()) return;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Sheet& sheet = all[k];
    const Json& cell = kept[k];
    const double frame = cell["frame_s"].get<double>(), setup = cell["setup_s"].get<double>();
    findings.rows.push_back({{"case", "sheets of 2008"},
                             {"what", sheet.title},
                             {"particles", cell["particles"]},
                             {"printed", sheet.printed},
                             {"frames_per_s", 1 / frame},
                             {"frame_ms", frame * 1e3},
                             {"setup_s", setup},
                             {"strain_max", cell["strain_max"]}});
    copy_machine(findings.rows.back(), cell);
    section.table.rows.push_back({sheet.title, sheet.printed, formatted("%.4g", 1 / frame),
                                  formatted("%.3g", frame * 1e3), formatted("%.3g", setup * 1e3)});
    if (!sheet.printed.empty())
      append(summary, formatted("%.3g frames/s after %.2g ms of set-up (", 1 / frame, setup * 1e3) + sheet.title + ")",
             "; ");
  }
  section.sentences = {
      "Printed, on a Core 2 Duo at 2.2 GHz and with a rendering engine: 289 particles by Desbrun's method and over "
      "2000 by PBD at 50 frames/s each, and a precomputation that is too slow beyond 500 particles.",
      "malha on one thread and without rendering, a frame of 1/50 s each: " + summary + "."};
  findings.sections.push_back(section);
}

int count_sheets(bool) { return static_cast<int>(sheets().size()); }

}  // namespace

const PublishedPart kSheetsOf2008{count_sheets, add_sheets};

}  // namespace malha::study
