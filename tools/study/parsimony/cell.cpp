// SPDX-License-Identifier: Apache-2.0
#include "tools/study/parsimony/cell.h"

#include <array>
#include <numeric>
#include <optional>

#include "host/base/stopwatch.h"
#include "host/report/launches.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tools/bench/medians.h"

namespace malha::study {

namespace {

constexpr int kBefore = 30, kMeasured = 20;  // steps

/// One of the scenes, which is run through the measured period repeatedly.
class SceneRun {
 public:
  SceneRun(const Scene& scene) : scene_(scene) {}

  void start() {
    simulation_.emplace(scene_, SimulationOptions{.threads = 1});
    for (int step = 0; step < kBefore; ++step) simulation_->step();
    before_ = simulation_->solver().pass_seconds();
  }
  void step() {
    ms_.push_back(1e3 * thread_seconds([&] { simulation_->step(); }));
  }
  void stop() {
    for (std::size_t k = 0; k < kPassNames.size(); ++k)
      passes_[k] += 1000 * (simulation_->solver().pass_seconds()[k] - before_[k]);
  }

  const std::vector<double>& ms() const { return ms_; }

  /// Times, bytes and launches of the scene. Runs one more step to record its launches.
  Json facts() {
    Json passes = Json::object(), bytes = Json::object(), launches = Json::array();
    const double median = bench::median(ms_), all = std::accumulate(passes_.begin(), passes_.end(), 0.0);
    for (std::size_t k = 0; k < kPassNames.size(); ++k)
      if (passes_[k] > 0) passes[kPassNames[k]] = passes_[k] / all * median;
    const LaunchTrace trace;
    simulation_->step();
    for (const auto& [kernel, times, items] : trace.list())
      launches.push_back({{"kernel", kernel}, {"launches", times}, {"items", items}});
    for (const auto& [owner, count] : memory_parts(simulation_->model(), simulation_->solver().facts()))
      bytes[owner] = count;
    bytes.emplace("levels", 0.0);  // if there are none
    return {{"particles", simulation_->positions().size()},
            {"ms_a_step", median},
            {"passes_ms", passes},
            {"bytes", bytes},
            {"launches", launches}};
  }

 private:
  Scene scene_;
  std::optional<Simulation> simulation_;
  std::vector<double> ms_;  // of the measured steps
  std::array<double, kPassNames.size()> before_{}, passes_{};
};

}  // namespace

Json parsimony_cell(const std::vector<Scene>& scenes, const Cells& cells) {
  std::vector<SceneRun> runs(scenes.begin(), scenes.end());
  const int rounds = cells.quick() ? 1 : 12;
  constexpr double enough = 0.5;  // s per scene
  double spent = 0;
  for (int round = 0; round < rounds && spent < enough * static_cast<double>(runs.size()); ++round) {
    for (SceneRun& run : runs) run.start();
    for (int step = 0; step < kMeasured; ++step)
      for (SceneRun& run : runs) {
        cells.check_interrupt();
        run.step();
        spent += run.ms().back() / 1000;
      }
    for (SceneRun& run : runs) run.stop();
  }
  Json all = Json::array();
  for (std::size_t k = 0; k < runs.size(); ++k) {
    std::vector<double> added = runs[k].ms();
    for (std::size_t step = 0; step < added.size(); ++step) added[step] -= runs[k > 0 ? k - 1 : 0].ms()[step];
    all.push_back(runs[k].facts());
    all.back()["added_ms"] = bench::median(added);
  }
  return all;
}

}  // namespace malha::study
