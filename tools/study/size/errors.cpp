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
#include "tools/study/cloth_methods.h"
#include "tools/study/reference/chain.h"
#include "tools/study/size/error_sections.h"
#include "tools/study/step_length.h"

namespace malha::study {

namespace {

constexpr double kClothSide = 2, kClothGravity = 9.81;  // m; m/s^2, of tools/bench/cloth.h
constexpr int kHangingFrames = 60;                      // 1 s
constexpr double kHangingCompliance = 1e-6;             // m/N: a row stretches by at most 5e-6 of its length
constexpr double kHangingSpring = 1e4;                  // N/m, of Desbrun's method
constexpr int kMostHangingSubsteps = 1024;

/// A method, and the limits of what is run with it.
struct HangingMethodRun : HangingMethod {
  std::function<void(Scene&)> change;
  int fixed;           // substeps, or refinements, in the charts of errors
  int most_particles;  // in the full study
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

struct HangingResult {
  double ms = 0, strain_rms = 0, strain_max = 0, error_half = 0, error = 0;
  int levels = 0;
  bool diverged = false;
};

HangingResult run_hanging(const Scene& scene, const Cells& cells) {
  Simulation simulation(scene, {.threads = 1});
  const std::vector<Vec3> rest = simulation.positions();
  HangingResult result;
  result.levels = static_cast<int>(simulation.solver().facts().levels.size());
  std::vector<double> frame_seconds;
  try {
    for (int frame = 1; frame <= kHangingFrames; ++frame) {
      frame_seconds.push_back(seconds([&] { simulation.step(); }));
      cells.check_interrupt();
      if (frame == kHangingFrames / 2)
        result.error_half = hanging_error(rest, simulation.positions(), hanging_truth()[frame - 1]);
    }
    simulation.check_divergence();
    const Measures measures = simulation.measure();
    result.strain_rms = measures.strain_rms, result.strain_max = measures.strain_max;
    result.error = hanging_error(rest, simulation.positions(), hanging_truth().back());
  } catch (const Diverged&) {
    result.diverged = true;
  }
  result.ms = bench::median(frame_seconds) * 1e3;
  return result;
}

Json error_cell(const bench::Case& which, const HangingMethodRun& method, const Cells& cells) {
  const HangingResult result = run_hanging(hanging_scene(which, method, method.fixed), cells);
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

template <class Visit>
void for_each_cell(bool quick, const Visit& visit) {
  for (const bool work : {false, true})
    for (const HangingMethodRun& method : hanging_methods())
      for (const char* mesh : {"grid", "irregular"})
        for (const int side : hanging_sides(method, work, quick)) visit(work, method, std::string(mesh), side);
}

}  // namespace

int size_error_cells(bool quick) {
  int count = 0;
  for_each_cell(quick, [&](bool, const HangingMethodRun&, const std::string&, int) { ++count; });
  return count;
}

Json size_errors(Cells& cells) {
  Json rows = Json::array();
  for_each_cell(cells.quick(), [&](bool work, const HangingMethodRun& method, const std::string& mesh, int side) {
    const std::string key = (work ? "work for 1 %, " : "error, ") + method.title() + ", " + mesh + " of " +
                            with_commas(static_cast<long long>(side) * side);
    const Json cell = cells(key, [&] {
      const bench::Case which = mesh == "grid" ? bench::grid_case(side) : bench::irregular_case(side * side);
      return work ? work_cell(which, method, cells) : error_cell(which, method, cells);
    });
    Json row{{"measures", work ? "work" : "error"},
             {"method", method.name},
             {"mesh", mesh},
             {"side", side},
             {"particles", side * side},
             {"left_out", nullptr}};
    for (const auto& [name, value] : cell.items()) row[name] = value;
    rows.push_back(row);
  });
  return rows;
}

void add_size_errors(const Json& rows, Findings& findings) {
  std::vector<HangingMethod> named(hanging_methods().begin(), hanging_methods().end());
  for (Section& section : size_error_sections(named, rows)) findings.sections.push_back(std::move(section));
  for (const Json& row : rows) findings.rows.push_back(row);
}

}  // namespace malha::study
