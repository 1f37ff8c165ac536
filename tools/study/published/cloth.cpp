// SPDX-License-Identifier: Apache-2.0
// The self-colliding cloth of Müller et al. 2006, figure 6: 1,364 vertices and 2,562 triangles at 30 frames/s on a
// Pentium 4 at 3 GHz, with detection, handling and rendering.
#include <algorithm>

#include "host/base/stopwatch.h"
#include "malha/simulation.h"
#include "malha/text.h"
#include "tools/bench/counts.h"
#include "tools/bench/output.h"
#include "tools/bench/self/cases.h"
#include "tools/study/published/parts.h"
#include "tools/study/rows.h"

namespace malha::study {

namespace {

using bench::formatted;

struct Motion {
  bool drapes;  // true: over a ball; false: falls on edge onto the ground and folds to a heap
  int substeps;
  std::string name() const {
    return formatted(drapes ? "drapes over a ball, %d substeps" : "folds on the ground, %d substeps", substeps);
  }
};

Scene falling_cloth(const Motion& motion) {
  Scene scene = bench::cloth_of_2006(1364, motion.drapes, motion.substeps);
  scene.file = "malha study", scene.solver.levels = 0;  // the papers have none
  return scene;
}

Json time_cloth(const Motion& motion, int threads, bool quick, const Cells& cells) {
  Simulation simulation(falling_cloth(motion), {.threads = threads});
  std::vector<double> frames;
  int contacts = 0;
  std::int64_t crossings = 0;
  double strain = 0;
  for (int frame = 0; frame < (quick ? 8 : 60); ++frame) {
    frames.push_back(seconds([&] { simulation.step(); }));
    const Measures now = simulation.measure();
    contacts = std::max(contacts, now.self_contacts), crossings = std::max(crossings, now.crossings);
    strain = std::max(strain, now.strain_rms);
    cells.check_interrupt();
  }
  double sum = 0;
  for (const double frame : frames) sum += frame;
  return {{"particles", simulation.positions().size()},
          {"mean_frame_s", sum / static_cast<double>(frames.size())},
          {"slowest_frame_s", *std::max_element(frames.begin(), frames.end())},
          {"most_contacts", contacts},
          {"strain_rms", strain},
          {"crossings", crossings}};
}

std::vector<Motion> motions(bool quick) {
  if (quick) return {{false, 2}};
  return {{true, 20}, {false, 10}, {false, 20}};
}

std::vector<int> cloth_threads(bool quick, int cores = bench::cores()) {
  return quick ? std::vector{1} : bench::sorted({1, cores});
}

struct TimedCloth {
  Motion motion;
  int threads;
};

std::vector<TimedCloth> timed_cloths(const Cells& cells) {
  std::vector<TimedCloth> all;
  for (const Motion& motion : motions(cells.quick()))
    for (const int t : cloth_threads(cells.quick(), cells.cores())) all.push_back({motion, t});
  return all;
}

void add_cloth(Cells& cells, Findings& findings) {
  Section section{"PBD 2006, figure 6: a self-colliding cloth of 1,364 vertices"};
  section.table.columns = {"motion",        "threads",       "printed, frames/s", "malha, mean",
                           "slowest frame", "most contacts", "RMS strain, most",  "crossings, most"};
  std::string summary;
  double best = 0;
  int most_crossings = 0;
  const std::vector<TimedCloth> all = timed_cloths(cells);
  const std::vector<Json> kept = cells.measure_all(
      all,
      [](const TimedCloth& timed) { return "cloth: " + timed.motion.name() + ", " + counted(timed.threads, "thread"); },
      [&](const TimedCloth& timed) { return time_cloth(timed.motion, timed.threads, cells.quick(), cells); });
  if (cells.is_partial()) return;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto& [motion, threads] = all[k];
    const Json& cell = kept[k];
    const double mean = 1 / cell["mean_frame_s"].get<double>(), least = 1 / cell["slowest_frame_s"].get<double>();
    findings.rows.push_back({{"case", "cloth of 2006"},
                             {"what", motion.name()},
                             {"particles", cell["particles"]},
                             {"threads", threads},
                             {"printed", 30},
                             {"frames_per_s", mean},
                             {"slowest_frames_per_s", least},
                             {"most_contacts", cell["most_contacts"]},
                             {"strain_rms", cell["strain_rms"]},
                             {"crossings", cell["crossings"]}});
    copy_machine(findings.rows.back(), cell);
    section.table.rows.push_back({motion.name(), std::to_string(threads), "30", formatted("%.3g", mean),
                                  formatted("%.3g", least), cell["most_contacts"].dump(),
                                  percent(cell["strain_rms"].get<double>()), cell["crossings"].dump()});
    best = std::max(best, mean);
    most_crossings = std::max(most_crossings, cell["crossings"].get<int>());
    append(summary,
           formatted("%.3g, the slowest frame %.3g (", mean, least) + motion.name() + ", " +
               counted(threads, "thread") + ")",
           "; ");
  }
  section.sentences = {
      "Printed: 30 frames/s on average on a Pentium 4 at 3 GHz, with detection, handling and rendering, of a cloth "
      "that ends up folded; the motion is not described. Here a cloth of as many vertices falls, and nothing is drawn.",
      "malha, frames of 1/30 s a second: " + summary + ".",
      formatted(
          "At best that is %.2g times the printed rate: malha %s the frame rate of 2006. Intersections after every "
          "frame: %d at most; every pair of primitives that could intersect is tested, and its displacements are "
          "truncated.",
          best / 30, best < 30 ? "does not reach" : "reaches", most_crossings)};
  findings.sections.push_back(section);
}

int count_cloth(bool quick) { return static_cast<int>(motions(quick).size() * cloth_threads(quick).size()); }

}  // namespace

const PublishedPart kClothOf2006{count_cloth, add_cloth};

}  // namespace malha::study
