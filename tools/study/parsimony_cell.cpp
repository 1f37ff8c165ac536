#include "tools/study/parsimony_cell.h"

#include <algorithm>

#include "host/base/stopwatch.h"
#include "host/results/launches.h"
#include "host/results/report.h"
#include "host/simulation.h"
#include "host/solver/solver.h"
#include "tools/bench/turns.h"

namespace malha::study {

namespace {

class Side {
 public:
  explicit Side(const Scene& scene) : simulation_(scene, {.threads = 1}) {}

  double step_ms() {
    return 1000 * seconds([&] { simulation_.step(); });
  }
  int particles() const { return static_cast<int>(simulation_.positions().size()); }

  /// From here on passes are counted.
  void start() { before_ = simulation_.solver().pass_seconds(); }

  /// After so many steps since then, of these times; takes one more, to see what it launches.
  Json facts(const std::vector<double>& ms) {
    Json passes = Json::object();
    for (std::size_t k = 0; k < kPassNames.size(); ++k)
      if (const double spent = simulation_.solver().pass_seconds()[k] - before_[k]; spent > 0)
        passes[kPassNames[k]] = 1000 * spent / static_cast<double>(ms.size());
    Json bytes = Json::object(), launches = Json::array();
    for (const auto& [owner, count] : memory_parts(simulation_.model(), simulation_.solver().facts()))
      bytes[owner] = count;
    const LaunchTrace trace;
    simulation_.step();
    for (const Launches& of : trace.list())
      launches.push_back({{"kernel", of.kernel}, {"launches", of.launches}, {"items", of.items}});
    return {{"ms_a_step", bench::median(ms)}, {"passes_ms", passes}, {"bytes", bytes}, {"launches", launches}};
  }

 private:
  Simulation simulation_;
  std::array<double, kPassNames.size()> before_{};
};

}  // namespace

Json parsimony_cell(const Demand& of, const Cells& cells) {
  Side without(of.without), with(of.with);
  const auto turn = [&](std::vector<double>& a, std::vector<double>& b) {
    cells.go_on();
    a.push_back(without.step_ms()), b.push_back(with.step_ms());
  };
  std::vector<double> warm_a, warm_b, a, b, added;
  for (int step = 0; step < of.steps_before; ++step) turn(warm_a, warm_b);
  without.start(), with.start();
  const double enough = cells.quick() ? 0.05 : 1.5;  // s
  const std::size_t least = cells.quick() ? 5 : 15;
  double spent = 0;
  while (a.size() < least || spent < enough) {
    turn(a, b);
    spent += (a.back() + b.back()) / 1000;
    added.push_back(b.back() - a.back());
  }
  const double added_ms = bench::median(added), whole = bench::median(a);
  return {{"particles", with.particles()},
          {"without", without.facts(a)},
          {"with", with.facts(b)},
          {"added_ms", added_ms},
          {"added_percent", 100 * added_ms / whole}};
}

}  // namespace malha::study
