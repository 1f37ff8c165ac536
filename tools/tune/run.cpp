// SPDX-License-Identifier: Apache-2.0
#include "tools/tune/run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host/base/stopwatch.h"
#include "host/run/run.h"
#include "malha/error.h"
#include "malha/text.h"
#include "tools/tune/interrupted.h"

namespace malha::tuning {

namespace {

/// Returns the mean of all but the slowest tenth, which other programs may have slowed down, ms.
double trimmed_mean_ms(std::vector<double> steps) {
  if (steps.empty()) return 0;
  std::sort(steps.begin(), steps.end());
  steps.resize(steps.size() - std::min((steps.size() + 9) / 10, steps.size() - 1));
  return std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(steps.size());
}

}  // namespace

std::vector<int> moments(const Scene& scene, double seconds) {
  const double step_count = std::max(1.0, std::round(seconds / scene.solver.dt));
  if (step_count > kMostSteps)
    refuse("malha tune", "--seconds",
           shown(seconds) + " s, which are " + shown(step_count) + " steps of " + shown(scene.solver.dt) + " s",
           "at most " + shown(kMostSteps) + " steps");
  const int steps = static_cast<int>(step_count);
  std::vector<int> at;
  for (int quarter = 1; quarter <= 4; ++quarter)
    if (const int step = static_cast<int>(std::llround(steps * quarter / 4.0)); step > (at.empty() ? 0 : at.back()))
      at.push_back(step);
  return at;
}

bool keeps_energy(const Scene& scene) {
  if (scene.wind || scene.sleep || scene.self_collision || !scene.environment.empty()) return false;
  return std::none_of(scene.bodies.begin(), scene.bodies.end(), [](const BodySpec& body) {
    return body.damping > 0 || body.tear ||
           std::any_of(
               body.constraints.begin(), body.constraints.end(),
               [](const ConstraintSpec& spec) { return spec.type == "distance_limit" || spec.type == "long_range"; }) ||
           std::any_of(body.pins.begin(), body.pins.end(), [](const Pin& pin) { return !pin.motion.empty(); }) ||
           !body.attachments.empty();
  });
}

TuneRun tune_run(const Scene& scene, const std::vector<int>& moments, int threads, double most_ms,
                 const std::atomic<bool>& stop) {
  Simulation simulation(scene, {.threads = threads});
  const SolverSpec& solver = scene.solver;
  TuneRun run;
  std::vector<double> ms;  // durations of the steps
  run.sweeps = solver.substeps *
               (solver.type == "desbrun" ? 1 + solver.desbrun.refinement_iterations : solver.iterations) / solver.dt;
  const bool keeps = keeps_energy(scene);
  const double start = keeps ? simulation.measure().energy() : 0;
  try {
    for (int step = 1; step <= moments.back(); ++step) {
      if (stop) throw Interrupted();
      ms.push_back(1000 * seconds([&] { simulation.step(); }));
      if (std::binary_search(moments.begin(), moments.end(), step)) run.at.push_back(simulation.positions());
      // A lower bound of the cost, as if the remaining steps cost nothing.
      run.abandoned = step < moments.back() && trimmed_mean_ms(ms) * step / moments.back() > most_ms * solver.dt;
      if (run.abandoned) break;
    }
    if (keeps && !run.abandoned) run.energy_loss = start - simulation.measure().energy();
  } catch (const Diverged&) {
    run.diverged = true;
  }
  run.ms = trimmed_mean_ms(ms) / solver.dt;
  return run;
}

TuneRun extrapolated(const TuneRun& fine, const TuneRun& coarse) {
  TuneRun limit = fine;
  for (std::size_t k = 0; k < limit.at.size(); ++k)
    for (std::size_t i = 0; i < limit.at[k].size(); ++i)
      for (int c = 0; c < 3; ++c) limit.at[k][i][c] += fine.at[k][i][c] - coarse.at[k][i][c];
  if (fine.energy_loss && coarse.energy_loss) limit.energy_loss = 2 * *fine.energy_loss - *coarse.energy_loss;
  return limit;
}

double distance_between(const TuneRun& a, const TuneRun& b) {
  if (a.at.size() != b.at.size() || a.at.empty()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (std::size_t k = 0; k < a.at.size(); ++k) {
    double sum = 0;
    for (std::size_t i = 0; i < a.at[k].size(); ++i)
      for (int c = 0; c < 3; ++c) sum += (a.at[k][i][c] - b.at[k][i][c]) * (a.at[k][i][c] - b.at[k][i][c]);
    largest = std::max(largest, std::sqrt(sum / static_cast<double>(a.at[k].size())));
  }
  return largest;
}

}  // namespace malha::tuning
