// SPDX-License-Identifier: Apache-2.0
#include "tools/study/size/errors.h"

#include <cmath>
#include <map>

#include "host/base/stopwatch.h"
#include "host/solver/solver.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "tools/bench/cloth.h"
#include "tools/bench/medians.h"
#include "tools/study/accuracy/cases.h"
#include "tools/study/cloth_methods.h"
#include "tools/study/reference/chain.h"
#include "tools/study/size/error_sections.h"
#include "tools/study/step_length.h"

namespace malha::study {

namespace {

constexpr double kClothSide = 2, kClothGravity = 9.81;  // m; m/s^2, of tools/bench/cloth.h
constexpr int kHangingFrames = 60, kStripFrames = 300;  // 1 s, and 5 s until a strip is at rest
constexpr double kHangingCompliance = 1e-6;             // m/N: a row stretches by at most 5e-6 of its length
constexpr double kHangingSpring = 1e4;                  // N/m, of Desbrun's method
constexpr int kMostHangingSubsteps = 1024;

/// A method, and the limits of what is run with it.
struct HangingMethodRun : HangingMethod {
  std::function<void(Scene&)> change;
  int fixed;           // substeps, or refinements, in the charts of errors
  int most_particles;  // in the full study, of cloths
  bool refines = false;
};

void by_xpbd(Scene& scene) { scene.bodies[0].constraints[0].compliance = kHangingCompliance; }
void with_levels(Scene& scene) { scene.solver.levels = kAutoLevels; }
void with_long_range(Scene& scene) {
  ConstraintSpec spec;
  spec.type = "long_range", spec.parameter = 0;
  scene.bodies[0].constraints.push_back(spec);
}
void by_desbrun(Scene& scene) {
  scene.solver.type = "desbrun", scene.solver.desbrun.spring_constant = kHangingSpring;
  scene.solver.desbrun.filter = FilterKind::Sparse;
}

/// All methods, with settings of about the same cost: a step with levels takes about twice as long as without, and so
/// does one with a refinement or long_range.
const std::vector<HangingMethodRun>& hanging_methods() {
  static const std::vector<HangingMethodRun> all{
      {{"PBD", "20 substeps", "lw 5 lc rgb '#0072b2'"}, [](Scene&) {}, 20, 1'000'000},
      {{"XPBD", "20 substeps", "lw 2 lc rgb '#56b4e9'"}, by_xpbd, 20, 1'000'000},
      {{"levels", "10 substeps", "lw 2 lc rgb '#cc79a7'"}, with_levels, 10, 1'000'000},
      {{"long_range", "7 substeps", "lw 2 lc rgb '#d55e00'"}, with_long_range, 7, 100'000},
      {{"Desbrun", "refine 1", "lw 2 lc rgb '#009e73'"}, by_desbrun, 1, 100'000, true},
  };
  return all;
}

template <BendingMethod bending>
void with_bending(Scene& scene) {
  scene.solver.bending = bending;
}

/// Methods for the bending of a clamped strip.
const std::vector<HangingMethodRun>& bending_methods() {
  static const std::vector<HangingMethodRun> all{
      {{"projected", "10 substeps", "lw 2 lc rgb '#0072b2'"}, with_bending<BendingMethod::Projected>, 10, 0},
      {{"filtered", "10 substeps", "lw 2 lc rgb '#e69f00'"}, with_bending<BendingMethod::Filtered>, 10, 0},
      {{"Desbrun", "1 substep", "lw 2 lc rgb '#009e73'"}, by_desbrun, 1, 0},
  };
  return all;
}

std::vector<int> hanging_sides(const HangingMethodRun& method, bool work, bool quick) {
  if (quick) return work ? std::vector{17, 33} : std::vector{17, 46, 80};
  std::vector<int> all{17, 46, 100, 316};
  // Without levels the substeps needed are some 0.3 of the particles a side: hours for a million particles.
  if (method.most_particles >= 1'000'000 && (!work || method.name == "levels")) all.push_back(1000);
  return all;
}

Scene hanging_scene(const bench::Case& which, const HangingMethodRun& method, int count) {
  Scene scene = bench::hanging_cloth(which, {method.refines ? 1 : count, 1});
  scene.file = "malha study";
  method.change(scene);
  if (method.refines) scene.solver.desbrun.refinement_iterations = count;
  return scene;
}

/// The reference chain after each frame. Its 100 steps a frame resolve waves over its links of 4 mm.
const std::vector<ReferenceChain>& hanging_truth() {
  static const std::vector<ReferenceChain> frames = [] {
    std::vector<ReferenceChain> all;
    ReferenceChain chain(500, kClothSide, kClothGravity);
    for (int frame = 0; frame < kHangingFrames; ++frame) {
      for (int k = 0; k < 100; ++k) chain.step(kFrame / 100);
      all.push_back(chain);
    }
    return all;
  }();
  return frames;
}

/// RMS distance from the reference, m. `rest`: initial positions.
double hanging_error(const std::vector<Vec3>& rest, const std::vector<Vec3>& x, const ReferenceChain& chain) {
  double squares = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto [up, away] = chain.at(rest[i][2]);
    squares += std::pow(x[i][0] - rest[i][0], 2) + std::pow(x[i][1] - up, 2) + std::pow(x[i][2] - away, 2);
  }
  return std::sqrt(squares / static_cast<double>(x.size()));
}

/// RMS distance from the truth after a frame, m.
using ErrorAfter = std::function<double(const std::vector<Vec3>& rest, const std::vector<Vec3>& x, int frame)>;

double cloth_error(const std::vector<Vec3>& rest, const std::vector<Vec3>& x, int frame) {
  return hanging_error(rest, x, hanging_truth()[frame - 1]);
}

struct HangingResult {
  double ms = 0, strain_rms = 0, strain_max = 0, error_half = 0, error = 0;
  int levels = 0;
  bool diverged = false;
};

HangingResult run_hanging(const Scene& scene, const Cells& cells, int frames = kHangingFrames,
                          const ErrorAfter& error = cloth_error) {
  Simulation simulation(scene, {.threads = 1});
  const std::vector<Vec3> rest = simulation.positions();
  HangingResult result;
  result.levels = static_cast<int>(simulation.solver().facts().levels.size());
  std::vector<double> frame_seconds;
  try {
    for (int frame = 1; frame <= frames; ++frame) {
      frame_seconds.push_back(seconds([&] { simulation.step(); }));
      cells.check_interrupt();
      if (frame == frames / 2) result.error_half = error(rest, simulation.positions(), frame);
    }
    simulation.check_divergence();
    const Measures measures = simulation.measure();
    result.strain_rms = measures.strain_rms, result.strain_max = measures.strain_max;
    result.error = error(rest, simulation.positions(), frames);
  } catch (const Diverged&) {
    result.diverged = true;
  }
  result.ms = bench::median(frame_seconds) * 1e3;
  return result;
}

/// `along`: edges of the strip.
HangingResult run_strip(int along, const HangingMethodRun& method, const Cells& cells) {
  const AccuracyCase strip = cantilever(along);
  Scene scene = strip.scene;
  scene.solver.substeps = method.fixed;
  method.change(scene);
  const Vector truth = strip.exact(0).x;
  return run_hanging(scene, cells, kStripFrames, [&](const std::vector<Vec3>&, const std::vector<Vec3>& x, int) {
    return rms_distance(flat(x), truth);
  });
}

Json error_cell(const HangingResult& result) {
  if (result.diverged) return {{"left_out", "it diverges"}};
  return {{"step_ms", result.ms},
          {"levels", result.levels},
          {"strain_rms", result.strain_rms},
          {"strain_max", result.strain_max},
          {"error_half_m", result.error_half},
          {"error_m", result.error}};
}

/// The fewest substeps (or refinements), doubled and then halved in between, that leave an RMS strain of 1 % after 1 s.
Json work_cell(const bench::Case& which, const HangingMethodRun& method, const Cells& cells) {
  std::map<int, HangingResult> results;
  const auto reaches_target = [&](int count) {
    const HangingResult& result = results[count] = run_hanging(hanging_scene(which, method, count), cells);
    return !result.diverged && result.strain_rms <= kTargetStrain;
  };
  const int first = method.refines ? 0 : 1;
  int low = first - 1, high = first;
  while (high <= kMostHangingSubsteps && !reaches_target(high)) low = high, high = std::max(1, 2 * high);
  if (high > kMostHangingSubsteps)
    return {{"left_out", "more than " + std::to_string(kMostHangingSubsteps) + " substeps"}};
  while (high - low > std::max(1, low / 8)) {
    const int middle = (low + high) / 2;
    (reaches_target(middle) ? high : low) = middle;
  }
  const HangingResult& result = results.at(high);
  return {{"count", high},
          {"step_ms", result.ms},
          {"levels", result.levels},
          {"strain_rms", result.strain_rms},
          {"strain_max", result.strain_max},
          {"error_m", result.error}};
}

/// Visits the cloths by their particles a side, and the strips by their edges along.
template <class Visit>
void for_each_cell(bool quick, const Visit& visit) {
  for (const std::string measures : {"error", "work"})
    for (const HangingMethodRun& method : hanging_methods())
      for (const std::string mesh : {"grid", "irregular"})
        for (const int side : hanging_sides(method, measures == "work", quick)) visit(measures, method, mesh, side);
  for (const HangingMethodRun& method : bending_methods())
    for (const int along : quick ? std::vector{12, 36} : std::vector{24, 48, 96, 192})
      visit(std::string("bending"), method, std::string("grid"), along);
}

}  // namespace

int size_error_cells(bool quick) {
  int count = 0;
  for_each_cell(quick, [&](const std::string&, const HangingMethodRun&, const std::string&, int) { ++count; });
  return count;
}

Json size_errors(Cells& cells) {
  Json rows = Json::array();
  for_each_cell(cells.quick(), [&](const std::string& measures, const HangingMethodRun& method, const std::string& mesh,
                                   int side) {
    const bool bends = measures == "bending";
    const int particles = bends ? (side + 1) * (side / 4 + 1) : side * side;
    const std::string key = (measures == "work" ? "work for 1 %" : measures) + ", " + method.title() + ", " + mesh +
                            " of " + with_commas(particles);
    const Json cell = cells(key, [&] {
      if (bends) return error_cell(run_strip(side, method, cells));
      const bench::Case which = mesh == "grid" ? bench::grid_case(side) : bench::irregular_case(particles);
      if (measures == "work") return work_cell(which, method, cells);
      return error_cell(run_hanging(hanging_scene(which, method, method.fixed), cells));
    });
    Json row{{"measures", measures}, {"method", method.name},  {"mesh", mesh},
             {"side", side},         {"particles", particles}, {"left_out", nullptr}};
    for (const auto& [name, value] : cell.items()) row[name] = value;
    rows.push_back(row);
  });
  return rows;
}

void add_size_errors(const Json& rows, Findings& findings) {
  const auto named = [](const std::vector<HangingMethodRun>& all) {
    return std::vector<HangingMethod>(all.begin(), all.end());
  };
  for (Section& section : size_error_sections(named(hanging_methods()), named(bending_methods()), rows))
    findings.sections.push_back(std::move(section));
  for (const Json& row : rows) findings.rows.push_back(row);
}

}  // namespace malha::study
