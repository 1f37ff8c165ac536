// SPDX-License-Identifier: Apache-2.0
#include "tools/study/scaling/cell.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "host/base/memory_size.h"
#include "host/base/stopwatch.h"
#include "host/solver/solver.h"
#include "kernels/parallel/compute.h"
#include "malha/simulation.h"
#include "malha/text.h"
#include "tools/bench/machine.h"
#include "tools/bench/medians.h"

namespace malha::study {

namespace {

constexpr int kWarmUp = 3;  // steps, after which the states are compared
constexpr std::size_t kLeastTriad = std::size_t(1) << 16;

/// Bytes per particle and substep of PBD: x, w and v read, x and v written, in float.
constexpr double kPbdBytes = 52;

struct Runner {
  ScalingRun line;
  std::unique_ptr<Simulation> simulation;
  double setup = 0;
  std::string hash;
  std::vector<double> steps;                                  // mean of each turn, s
  double least = 1e300;                                       // shortest single step, s
  std::array<std::vector<double>, kPassNames.size()> passes;  // s per step, one value a turn

  void run_turn(double min_seconds) {
    simulation->step();  // OpenMP ends and starts threads if the last team had another number of them
    const auto before = simulation->solver().pass_seconds();
    const std::int64_t first = simulation->steps();
    const auto step = [&] { least = std::min(least, seconds([&] { simulation->step(); })); };
    steps.push_back(bench::mean_seconds(step, min_seconds));
    const auto& after = simulation->solver().pass_seconds();
    for (std::size_t k = 0; k < passes.size(); ++k)
      passes[k].push_back((after[k] - before[k]) / static_cast<double>(simulation->steps() - first));
  }
};

double required_bytes(const ClothMethod& method, const Simulation& simulation) {
  const auto& filter = simulation.solver().facts().filter;
  if (!filter) return kPbdBytes * method.substeps * simulation.model().count();
  return static_cast<double>(filter->numbers) * sizeof(float) * (filter->kind == "sparse" ? 2 : 1);
}

Json result(const ClothMethod& method, const Runner& runner, double min_seconds,
            const std::optional<DeviceStats>& device) {
  const PatchStats& patches = runner.simulation->solver().facts().patches;
  Json passes = Json::object();
  for (std::size_t k = 0; k < kPassNames.size(); ++k)
    if (const double seconds = bench::median(runner.passes[k]); seconds > 0) passes[kPassNames[k]] = seconds;
  const double bytes = required_bytes(method, *runner.simulation);
  // The triad over as many bytes as one substep or one product reads and writes: beyond the caches it is that of
  // memory.
  const auto set = static_cast<std::size_t>(method.desbrun ? bytes : bytes / method.substeps);
  const std::size_t triad = std::clamp(set, kLeastTriad, min_seconds > 0.05 ? bench::kMemoryBytes : kLeastTriad);
  const double memory = device ? device->bytes_per_second * 1e-9 : bench::triad_gb_per_s(triad, runner.line.threads);
  return {{"threads", runner.line.threads},
          {"particles", runner.simulation->model().count()},
          {"setup_s", runner.setup},
          {"hash", runner.hash},
          {"step_s", runner.steps},
          {"least_step_s", runner.least},
          {"passes_s", passes},
          {"patches", patches.patches},
          {"patch_colors", patches.colours},
          {"must_move_bytes", bytes},
          {"triad_gb_per_s", memory}};
}

/// Seconds per call of work(), one value for each of several windows.
std::vector<double> window_times(const std::function<void()>& work, bool quick) {
  std::vector<double> all;
  for (int run_turn = 0; run_turn < (quick ? 5 : 25); ++run_turn)
    all.push_back(bench::mean_seconds(work, quick ? 0.002 : 0.02));
  return all;
}

double least(const std::vector<double>& all) { return *std::min_element(all.begin(), all.end()); }

}  // namespace

std::vector<int> scaling_threads(int cores) {
  std::vector<int> all{1};
  for (int t = 2; t < cores; t *= 2) all.push_back(t);
  all.push_back(std::max(2, cores));
  return all;
}

Json scaling_cell(const ClothMethod& method, const std::vector<ScalingRun>& lines, const Cells& cells) {
  double total = 0, largest = 0;
  for (const ScalingRun& line : lines) {
    const double particles = static_cast<double>(line.side) * line.side;
    total += method.memory_bytes(particles), largest = std::max(largest, method.setup_peak_bytes(particles));
  }
  if (const auto has = static_cast<double>(available_memory()); total + largest > 0.8 * has)
    return {{"left_out", "all together take " + in_gib(total + largest) + ", and " + in_gib(has) + " are free"}};

  double load = 0;
  if (getloadavg(&load, 1) != 1) load = 0;
  std::vector<Runner> runners;
  for (const ScalingRun& line : lines) {
    Runner& runner = runners.emplace_back();
    runner.line = line;
    runner.setup = seconds([&] {
      runner.simulation =
          std::make_unique<Simulation>(method.scene(line.side), cells.runs_on().simulation_options(line.threads, true));
    });
    for (int k = 0; k < kWarmUp; ++k) runner.simulation->step();
    runner.hash = hex(runner.simulation->state_hash());
    cells.check_interrupt();
  }
  const double min_seconds = cells.quick() ? 0.005 : 0.2;
  for (int run_turn = 0; run_turn < (cells.quick() ? 3 : 7); ++run_turn)
    for (Runner& runner : runners) runner.run_turn(min_seconds), cells.check_interrupt();
  Json cell{{"load_average", load}, {"lines", Json::array()}};
  std::optional<DeviceStats> device;
  if (cells.runs_on().is_device()) device = cuda_device(), cell["device"] = device->name;
  for (const Runner& runner : runners) cell["lines"].push_back(result(method, runner, min_seconds, device));
  return cell;
}

Json launch_costs(int threads, bool quick) {
  const OpenMP executor{threads};
  constexpr int launches = 100;
  const auto nothing = [](const auto& group) { static_cast<void>(group); };
  const auto region = [&](int count) {
    parallel_region(executor, threads, [&](const auto& team) {
      for (int k = 0; k < count; ++k) parallel_groups(team, 0, threads, {}, nothing);
    });
  };
  const std::vector<double> alone = window_times([&] { region(0); }, quick),
                            with = window_times([&] { region(launches); }, quick);
  return {{"threads", threads},
          {"fork_join_us", least(alone) * 1e6},
          {"fork_join_median_us", bench::median(alone) * 1e6},
          {"barrier_us", std::max(0.0, least(with) - least(alone)) / launches * 1e6}};
}

std::optional<double> serial_fraction(const std::vector<int>& threads, const std::vector<double>& seconds) {
  double above = 0, below = 0;
  for (std::size_t k = 1; k < threads.size(); ++k) {
    const double part = 1.0 / threads[k];
    above += (seconds[k] / seconds[0] - part) * (1 - part), below += (1 - part) * (1 - part);
  }
  const double share = above / below;
  constexpr double rounding = 1e-12;
  if (!(share >= -rounding && share <= 1 + rounding)) return std::nullopt;
  return std::clamp(share, 0.0, 1.0);
}

double imbalance(int patches, int colours, int threads) {
  if (patches == 0 || colours == 0) return 1;
  const double each = static_cast<double>(patches) / colours / threads;
  return std::ceil(each - 1e-9) / each;
}

}  // namespace malha::study
