// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/filter/step.h"

#include <algorithm>
#include <cmath>

#include "host/base/stopwatch.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "tools/bench/filter/filter_case.h"
#include "tools/bench/pinned.h"

namespace malha::bench {

namespace {

constexpr int kLeastSide = 3, kWarmUp = 5, kSteps = 15;
constexpr double kExact = 1.02;

/// Sets the cloth up and measures its steps.
FilterRow step_row(const StepSearch& search, int side) {
  Scene scene = spring_cloth(side);
  scene.solver.desbrun.filter = search.filter;
  Simulation simulation(scene, search.on.simulation_options(search.threads, false));
  const Pinned pinned(search.threads);
  FilterRow row;
  double all = 0;
  for (int k = 0; k < kWarmUp; ++k) simulation.step();
  while (static_cast<int>(row.seconds.size()) < kSteps || all < search.seconds) {
    row.seconds.push_back(seconds([&] { simulation.step(); }));
    all += row.seconds.back();
  }
  const FilterStats& facts = *simulation.solver().facts().filter;
  row.side = side, row.particles = simulation.model().count(), row.n = facts.unknowns, row.threads = search.threads;
  row.kernel = facts.kind + " step", row.storage = facts.storage;
  row.bytes = double(facts.numbers) * sizeof(float) * (facts.kind == "sparse" ? 2 : 1);
  row.memory_bytes = double(facts.bytes);
  row.setup_seconds = simulation.times().model_seconds + simulation.times().solver_seconds;
  const FilterErrors errors = simulation.solver().filter_errors().value_or(FilterErrors{});
  row.noise_error = errors.noise, row.elastic_error = errors.elastic;
  return row;
}

}  // namespace

int largest_side(int least, int guess, int cap, double exponent, const std::function<double(int)>& ms) {
  int good = least - 1, bad = cap + 1, side = std::clamp(guess, least, cap);
  while (bad - good > 1 && (good < least || bad > cap || bad > kExact * good)) {
    const double time = ms(side);
    (time <= kFrameMs ? good : bad) = side;
    double next = std::sqrt(double(good) * bad);
    if (good < least || bad > cap) {  // no bracket yet: extrapolate by the power, by at least two of the final steps
      const double by = std::pow(kFrameMs / time, 1 / exponent);
      next = side * (time <= kFrameMs ? std::max(by, kExact * kExact) : std::min(by, 1 / (kExact * kExact)));
    }
    side = static_cast<int>(std::lround(std::clamp(next, good + 1.0, std::max(good + 1.0, bad - 1.0))));
  }
  return good < least ? 0 : good;
}

std::optional<FilterRow> find_real_time_limit(const StepSearch& search,
                                              const std::function<void(const std::string&)>& show_progress) {
  const bool dense = search.filter == FilterKind::Dense;
  std::optional<FilterRow> best;
  const int side = largest_side(kLeastSide, dense ? 100 : 500, search.cap, dense ? 4 : 2.3, [&](int next) {
    show_progress(std::string(dense ? "dense" : "sparse") + " steps at 60 Hz, N = " + std::to_string(next));
    try {
      FilterRow row = step_row(search, next);
      const double ms = row.ms();
      if (ms <= kFrameMs && (!best || best->side < next)) best = std::move(row);
      return ms;
    } catch (const InputError&) {
      return 2 * kFrameMs;  // too little memory
    }
  });
  if (best) best->at_cap = side == search.cap;
  return best;
}

}  // namespace malha::bench
