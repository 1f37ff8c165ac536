// SPDX-License-Identifier: Apache-2.0
#include "host/run/summary.h"

#include <algorithm>
#include <cstdio>

#include "host/model/model.h"
#include "host/report/report.h"
#include "host/report/resolution.h"
#include "host/solver/solver.h"
#include "malha/text.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// Formats a number with three digits.
std::string brief(double value) { return shown(value, 3); }

std::string speed(double median_ms, double dt) {
  if (median_ms <= 0) return "no step";
  const double factor = dt * 1000 / median_ms;
  char times[32];
  std::snprintf(times, sizeof times, factor < 10 ? "%.2g" : "%.0f", factor);
  return brief(median_ms) + " ms a step (median), " + times + " times real time";
}

}  // namespace

std::string summary(const Simulation& simulation) {
  const Model& model = simulation.model();
  const Measures m = simulation.measure();
  std::string text = "simulated   " + shown(simulation.time()) + " s, " + counted(simulation.steps(), "step") + " of " +
                     counted(model.count(), "particle") + " on " + counted(simulation.threads(), "thread") + "\n";
  text += "speed       " + speed(median_step_ms(simulation.times()), model.scene.solver.dt) + "\n";
  if (const auto& levels = simulation.solver().facts().levels; !levels.empty())
    text += "levels      " + std::to_string(levels.size()) + ", of " + counted(levels.front().particles, "particle") +
            " and fewer, every " + counted(simulation.solver().facts().levels_interval, "substep") + "\n";
  if (const auto& filter = simulation.solver().facts().filter)
    text +=
        "filter      " + filter->kind + ", " + filter->storage + ", " + counted(filter->unknowns, "particle") + "\n";
  const LargestStrains& strains = simulation.times().strains;
  if (m.has_strain) {
    text += "strain      " + brief(m.strain_rms) + " rms, " + brief(m.strain_max) + " max";
    if (strains.largest > 1.01 * m.strain_max)
      text += "; in the run up to " + brief(strains.largest) + ", at " +
              brief(static_cast<double>(strains.step) * model.scene.solver.dt) + " s (sampled every " +
              counted(strains.every, "step") + ")";
    text += "\n";
  }
  if (strains.beyond > 0.01)
    text += "long range  exceeded by up to " + brief(100 * strains.beyond) + " % of its length, at " +
            brief(static_cast<double>(strains.step_beyond) * model.scene.solver.dt) +
            " s, because contacts take precedence\n";
  if (!m.volume_ratios.empty()) {
    text += "volume      ";
    for (const double ratio : m.volume_ratios) text += brief(ratio) + " ";
    text += "of that at rest\n";
  }
  if (m.has_seams) text += "seams       " + brief(m.max_seam_gap) + " m apart at most\n";
  if (const auto sleep = simulation.solver().sleep())
    text += "asleep      " + (sleep->particles > 0 ? "since " + shown(sleep->since) + " s" : std::string("no")) + "\n";
  if (!model.environment.empty())
    text += "contacts    " + std::to_string(m.contacts) + ", penetration " + brief(m.penetration_max) + " m max\n";
  if (m.max_pinched > 0)
    text += "pinched     up to " + counted(m.max_pinched, "particle") +
            " at a time found no place between moving surfaces, and moved with the nearest one\n";
  const bool edges = simulation.solver().facts().edges.has_value(), self = model.scene.self_collision.has_value();
  if (edges || self)
    text += "crossings   " + std::to_string(m.crossings) + ", at most " +
            std::to_string(std::max(m.crossings, simulation.times().most_crossings)) + " counted";
  if (self) text += ", " + counted(m.self_contacts, "contact") + " between bodies or layers";
  if (edges) text += ", " + counted(m.edge_contacts, "contact") + " with edges and corners";
  if (edges || self) text += "\n";
  if (const std::string coarse = resolution_warning(model, simulation.positions()); !coarse.empty())
    text += "resolution  " + coarse + "\n";
  if (model.zero_area_faces > 0) text += "left out    " + counted(model.zero_area_faces, "face") + " without area\n";
  if (m.degenerate > 0) text += "skipped     " + counted(m.degenerate, "constraint") + " without a gradient\n";
  return text;
}

std::string list_results(const Results& results) {
  std::string text;
  const auto line = [&text](const char* what, const fs::path& path, const char* how) {
    if (fs::exists(path)) text += what + printable(path.string()) + how + "\n";
  };
  line("report      ", results.report, "");
  line("picture     ", results.picture, "");
  line("storyboard  ", results.storyboard, "");
  line("pictures    ", results.pictures, "/");
  line("frames      ", results.frames / "frames.pvd", " (ParaView)");
  if (fs::exists(results.frames / "rest.obj")) {
    std::vector<fs::path> caches;
    for (const auto& entry : fs::directory_iterator(results.frames))
      if (entry.path().extension() == ".pc2") caches.push_back(entry.path());
    std::ranges::sort(caches);
    for (const fs::path& cache : caches) line("frames      ", cache, " with rest.obj (Blender, Maya)");
  }
  line("frames      ", results.frames / "run.glb", " (browsers, Blender)");
  line("frames      ", results.frames / "run.usda", " (Houdini, Blender, Omniverse)");
  for (const char* series : {"frame_000000.ply", "frame_000000.obj"})
    line("frames      ", results.frames / series, " ...");
  line("replay      ", results.page, " (open it in a browser)");
  return text;
}

}  // namespace malha
