// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/self/self.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "host/base/stopwatch.h"
#include "host/report/report.h"
#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "malha/text.h"
#include "tools/bench/facts.h"
#include "tools/bench/medians.h"
#include "tools/bench/output.h"
#include "tools/bench/self/cases.h"
#include "tools/bench/self/chart.h"

namespace malha::bench {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kWarmUp = 2;                 // steps
constexpr double kLongMotion = 30;         // s on all numbers of threads; longer motions are not repeated
constexpr int kMostTakingTurns = 500'000;  // particles; two larger simulations need more memory than many machines have

/// A simulation of a case on a number of threads, and its times.
struct TimedRun {
  Simulation simulation;
  int threads;
  std::string hash = {};                           // of the state after the same steps on all numbers of threads
  std::vector<double> collision = {}, whole = {};  // ns per particle and substep, one value a turn
  double largest_s = 0;                            // of the steps of a motion in the last turn

  TimedRun(const Scene& scene, const RunsOn& on, int count)
      : simulation(scene, on.simulation_options(count, true)), threads(count) {}

  /// Adds the times of a step: `whole_s` seconds, `collision_s` of them in self-collision.
  void add_times(double whole_s, double collision_s) {
    const double per = 1e9 / (static_cast<double>(simulation.model().scene.solver.substeps) *
                              simulation.model().count());  // of a step
    whole.push_back(whole_s * per), collision.push_back(collision_s * per);
  }
  double collision_seconds() const { return simulation.solver().pass_seconds()[static_cast<int>(Pass::SelfCollision)]; }
};

/// Runs steps for at least `min_seconds` and adds their times.
void run_turn(TimedRun& line, double min_seconds) {
  const double before = line.collision_seconds();
  const std::int64_t first = line.simulation.steps();
  const double step = mean_seconds([&] { line.simulation.step(); }, min_seconds);
  const auto steps = static_cast<double>(line.simulation.steps() - first);
  line.add_times(step, (line.collision_seconds() - before) / steps);
}

/// Runs a motion from start to end and counts intersections after each step. Returns the seconds of its steps.
double run_motion(TimedRun& line, int steps, const std::function<void(double)>& progress) {
  double elapsed = 0;
  for (int step = 0; step < steps; ++step) {
    const double step_s = seconds([&] { line.simulation.step(); });
    elapsed += step_s, line.largest_s = std::max(line.largest_s, step_s);
    line.simulation.count_crossings();
    progress(double(step + 1) / steps);
  }
  line.add_times(elapsed / steps, line.collision_seconds() / steps);
  line.hash = hex(line.simulation.state_hash());
  return elapsed;
}

Json row_of(const SelfCase& of, const TimedRun& line) {
  const Measures m = line.simulation.measure();
  const SolverStats& facts = line.simulation.solver().facts();
  const SolverSpec& solver = line.simulation.model().scene.solver;
  const double particles = line.simulation.model().count();
  const double substeps = static_cast<double>(line.simulation.steps()) * solver.substeps;
  const double step_ms = median(line.whole) * 1e-6 * solver.substeps * particles;
  return {{"case", of.name},
          {"particles", line.simulation.model().count()},
          {"threads", line.threads},
          {"step_ms", step_ms},
          {"step_ms_largest", of.steps > 0 ? Json(1000 * line.largest_s) : Json()},
          {"self_collision_ns_per_particle_and_substep", median(line.collision)},
          {"step_ns_per_particle_and_substep", median(line.whole)},
          {"self_contacts_per_particle", m.self_contacts / particles},
          {"candidates_per_particle", static_cast<double>(facts.self->candidates) / particles},
          {"pairs_per_particle", static_cast<double>(facts.self->pairs) / particles},
          {"patch_colors", facts.self->colours},
          {"bytes_per_particle", static_cast<double>(facts.collision_bytes) / particles},
          {"searches_per_substep", static_cast<double>(facts.self->searches) / substeps},
          {"substeps", substeps},
          {"substeps_truncated", facts.self->substeps_truncated},
          {"strain_rms", m.strain_rms},
          {"max_intersections", std::max(line.simulation.times().most_crossings, m.crossings)},
          {"state_hash", line.hash}};
}

std::string printed(const Json& row) {
  const auto number = [&](const char* key) { return row[key].get<double>(); };
  return formatted("%-8s %9d %7d %9.2f %9.0f %9.0f %8.2f %8.0f %8.2f %9.0f/%-8.0f %13.0f\n",
                   row["case"].get<std::string>().c_str(), row["particles"].get<int>(), row["threads"].get<int>(),
                   number("step_ms"), number("self_collision_ns_per_particle_and_substep"),
                   number("step_ns_per_particle_and_substep"), number("self_contacts_per_particle"),
                   number("bytes_per_particle"), number("searches_per_substep"), number("substeps_truncated"),
                   number("substeps"), number("max_intersections"));
}

constexpr const char* kHead =
    "case     particles threads   step ms   self ns   step ns contacts    bytes searches truncated/substeps "
    "intersections\n";

std::vector<const SelfCase*> selected_cases(const SelfOptions& options) {
  std::vector<const SelfCase*> all;
  for (const SelfCase& of : self_cases())
    if (options.cases.empty() ? options.n.empty() || all.empty()
                              : std::find(options.cases.begin(), options.cases.end(), of.name) != options.cases.end())
      all.push_back(&of);
  return all;
}

/// The simulations of a case with `n` particles, one per number of threads. All end after the same steps.
class CaseRuns {
 public:
  CaseRuns(const SelfCase& of, int n, const SelfOptions& options, Output& out)
      : of_(of), scene_(of.scene(n)), n_(n), options_(options), out_(out) {}

  std::vector<Json> rows(const std::vector<int>& threads) const {
    std::vector<TimedRun> lines = of_.steps > 0 ? motion_runs(threads) : steady_runs(threads);
    std::vector<Json> rows;
    for (const TimedRun& line : lines) rows.push_back(row_of(of_, line));
    return rows;
  }

 private:
  std::string title() const { return std::string(of_.name) + ", " + std::to_string(n_) + " particles"; }

  std::vector<TimedRun> steady_runs(const std::vector<int>& threads) const {
    std::vector<TimedRun> lines;
    for (const int count : threads) {
      TimedRun& line = lines.emplace_back(scene_, options_.on, count);
      for (int step = 0; step < kWarmUp; ++step) line.simulation.step();
      line.hash = hex(line.simulation.state_hash());
    }
    for (int turn = 0; turn < options_.repeats; ++turn) {
      out_.show_progress(title(), double(turn) / options_.repeats);
      for (TimedRun& line : lines) run_turn(line, options_.seconds);
    }
    return lines;
  }

  std::vector<TimedRun> motion_runs(const std::vector<int>& threads) const {
    std::vector<TimedRun> lines;
    for (int turn = 0; turn < options_.repeats; ++turn) {
      double elapsed = 0;
      for (std::size_t k = 0; k < threads.size(); ++k) {
        TimedRun line(scene_, options_.on, threads[k]);
        elapsed += run_motion(line, of_.steps, [&](double part) {
          out_.show_progress(title(), (turn + (double(k) + part) / double(threads.size())) / options_.repeats);
        });
        if (turn > 0) {
          line.whole.insert(line.whole.end(), lines[k].whole.begin(), lines[k].whole.end());
          line.collision.insert(line.collision.end(), lines[k].collision.begin(), lines[k].collision.end());
          lines[k] = std::move(line);
        } else {
          lines.push_back(std::move(line));
        }
      }
      if (elapsed > kLongMotion) break;
    }
    return lines;
  }

  const SelfCase& of_;
  Scene scene_;
  int n_;
  const SelfOptions& options_;
  Output& out_;
};

}  // namespace

const std::vector<std::string>& self_case_names() {
  static const std::vector<std::string> names = case_names(self_cases());
  return names;
}

void run_self(const SelfOptions& options) {
  const std::vector<int> threads = thread_counts(options);
  Output out("self", options);
  out.facts = machine_facts(threads, options.on);
  std::string legend;
  for (const SelfCase* of : selected_cases(options)) legend += formatted("%-8s ", of->name) + of->what + "\n";
  out.print(
      legend +
      formatted(
          "float; 10 substeps (crumple: 20) of 1 iteration. stack: %d steps of warm-up, then %d x %g s a line, in "
          "turns\n(over 500,000 particles: one after the other). Others: the whole motion %d times, once if it takes "
          "over "
          "%g s.\nMedians; ns per particle and substep; bytes and contacts per particle; the most intersections after "
          "any "
          "step.\n",
          kWarmUp, options.repeats, options.seconds, options.repeats, kLongMotion) +
      machine_lines(out.facts, "") + kHead);
  Json all = Json::array();
  const auto measure = [&](const SelfCase& of, int n, const std::vector<int>& counts) {
    for (const Json& row : CaseRuns(of, n, options, out).rows(counts)) {
      all.push_back(row);
      out.print(printed(row));
    }
    out.write(all);
  };
  for (const SelfCase* of : selected_cases(options))
    for (const int n : options.n.empty() ? of->n : sorted(options.n))
      if (n <= kMostTakingTurns)
        measure(*of, n, threads);
      else
        for (const int count : threads) measure(*of, n, {count});
  const bool has_chart = has_layers_chart(all);
  const std::string no_chart = has_chart ? draw_layers_chart(all, out.folder()) : "";
  out.list();
  if (has_chart) out.list_chart(no_chart);
}

}  // namespace malha::bench
