#include "tools/study/parsimony_cell.h"

#include <array>
#include <numeric>
#include <optional>

#include "host/base/stopwatch.h"
#include "host/results/launches.h"
#include "host/results/report.h"
#include "host/simulation.h"
#include "host/solver/solver.h"
#include "tools/bench/turns.h"

namespace malha::study {

namespace {

constexpr int kBefore = 30, kMeasured = 20;  // steps

/// One of the two scenes, run through the measured time again and again.
class Side {
 public:
  explicit Side(const Scene& scene) : scene_(scene) {}

  void start() {
    simulation_.emplace(scene_, SimulationOptions{.threads = 1});
    for (int step = 0; step < kBefore; ++step) simulation_->step();
    before_ = simulation_->solver().pass_seconds();
  }
  void step() {
    ms_.push_back(1000 * seconds([&] { simulation_->step(); }));
  }
  void stop() {
    for (std::size_t k = 0; k < kPassNames.size(); ++k)
      passes_[k] += 1000 * (simulation_->solver().pass_seconds()[k] - before_[k]);
  }

  int particles() const { return static_cast<int>(simulation_->positions().size()); }
  const std::vector<double>& ms() const { return ms_; }

  /// Takes one step more, to see what it launches.
  Json facts() {
    Json passes = Json::object(), bytes = Json::object(), launches = Json::array();
    const double median = bench::median(ms_), all = std::accumulate(ms_.begin(), ms_.end(), 0.0);
    for (std::size_t k = 0; k < kPassNames.size(); ++k)
      if (passes_[k] > 0) passes[kPassNames[k]] = passes_[k] / all * median;
    const LaunchTrace trace;
    simulation_->step();
    for (const auto& [kernel, times, items] : trace.list())
      launches.push_back({{"kernel", kernel}, {"launches", times}, {"items", items}});
    for (const auto& [owner, count] : memory_parts(simulation_->model(), simulation_->solver().facts()))
      bytes[owner] = count;
    return {{"ms_a_step", median}, {"passes_ms", passes}, {"bytes", bytes}, {"launches", launches}};
  }

 private:
  Scene scene_;
  std::optional<Simulation> simulation_;
  std::vector<double> ms_;  // of the measured steps
  std::array<double, kPassNames.size()> before_{}, passes_{};
};

}  // namespace

Json parsimony_cell(const Demand& of, const Cells& cells) {
  Side without(of.without), with(of.with);
  const int rounds = cells.quick() ? 1 : 12;
  constexpr double enough = 0.5;  // s
  double spent = 0;
  std::vector<double> added;
  for (int round = 0; round < rounds && spent < enough; ++round) {
    without.start(), with.start();
    for (int step = 0; step < kMeasured; ++step) {
      cells.go_on();
      without.step(), with.step();
      spent += (without.ms().back() + with.ms().back()) / 1000;
      added.push_back(with.ms().back() - without.ms().back());
    }
    without.stop(), with.stop();
  }
  const double added_ms = bench::median(added), whole = bench::median(without.ms());
  return {{"particles", with.particles()},
          {"without", without.facts()},
          {"with", with.facts()},
          {"added_ms", added_ms},
          {"added_percent", 100 * added_ms / whole}};
}

}  // namespace malha::study
