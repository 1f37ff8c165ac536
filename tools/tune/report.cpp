// SPDX-License-Identifier: Apache-2.0
#include "tools/tune/report.h"

#include <algorithm>
#include <cmath>

#include "malha/text.h"
#include "tools/bench/output.h"

namespace malha::tuning {

namespace {

using Json = nlohmann::ordered_json;
using bench::formatted;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

/// Returns one trial of each method, in the order in which they ran: the one with the fewest substeps that reaches the
/// error, or the most accurate complete one.
std::vector<std::size_t> lines_of(const TuneResult& tuned) {
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < tuned.trials.size(); ++k) {
    const TuneTrial& trial = tuned.trials[k];
    const auto same = std::find_if(chosen.begin(), chosen.end(),
                                   [&](std::size_t other) { return tuned.trials[other].method == trial.method; });
    if (same == chosen.end()) {
      chosen.push_back(k);
      continue;
    }
    const TuneTrial& other = tuned.trials[*same];
    const bool fewer = trial.scene.solver.substeps < other.scene.solver.substeps;
    if (trial.reaches() ? (!other.reaches() || fewer) : (!other.reaches() && trial.error < other.error)) *same = k;
  }
  return chosen;
}

/// Returns how the search of a trial's method ended.
std::string ending(const TuneResult& tuned, const TuneTrial& of) {
  if (of.reaches()) return of.found;
  for (const TuneTrial& trial : tuned.trials)
    if (trial.method == of.method && trial.found == "dearer") return "more is dearer than the best";
  return of.found;
}

std::string line(const TuneResult& tuned, std::size_t k) {
  const TuneTrial& trial = tuned.trials[k];
  return formatted("%s %-42s %8d %12.4g %12.4g ", tuned.best == k ? "*" : " ", trial.method.c_str(),
                   trial.scene.solver.substeps, trial.ms, trial.sweeps) +
         (std::isfinite(trial.error) ? formatted("%10.3g", trial.error) : std::string(10, ' ')) + "  " +
         ending(tuned, trial) + "\n";
}

}  // namespace

std::string tune_table(const TuneResult& tuned, const TuneOptions& options) {
  const Reference& reference = tuned.reference;
  std::string text = formatted("error       %g m RMS, at the worst of four moments in %g s, on %d thread%s\n",
                               options.error, tuned.seconds, options.threads, options.threads == 1 ? "" : "s") +
                     formatted("reference   %d substeps in double, extrapolated; at most %.2g m off\n",
                               reference.substeps, reference.error_bound);
  if (!reference.converged) return text;
  text += formatted("tried       %zu runs; of each method the best, times and sweeps of a simulated second\n\n",
                    tuned.trials.size()) +
          formatted("  %-42s %8s %12s %12s %10s\n", "method", "substeps", "ms", "sweeps", "error, m");
  for (const std::size_t k : lines_of(tuned)) text += line(tuned, k);
  for (const std::string& left : tuned.left_out) text += "left out: " + left + "\n";
  if (!tuned.best) return text;
  const TuneTrial &best = tuned.trials[*tuned.best], &first = tuned.trials.front();
  return text + "\nbest        " + best.method + ", " + counted(best.scene.solver.substeps, "substep") +
         formatted(": %.3g m at %.3g ms a simulated second; as the scene was: ", best.error, best.ms) +
         (std::isfinite(first.error) ? formatted("%.3g m at %.3g ms\n", first.error, first.ms) : "it diverged\n");
}

std::string why_not_tuned(const TuneResult& tuned, const TuneOptions& options) {
  const Reference& reference = tuned.reference;
  if (!reference.converged) {
    const std::string fast =
        formatted(", or too fast: %.3g J are missed that nothing took, out of oscillations that may hide %.2g m",
                  std::abs(reference.run.energy_loss.value_or(0)), reference.hidden_motion);
    const bool hides = reference.hidden_motion > options.error / 8;
    return formatted(
               "the reference did not converge: from %d to %d substeps its particles move by %.3g m, and where that "
               "leads is not known to an eighth of %g m; the motion may be chaotic",
               reference.substeps / 2, reference.substeps, reference.last_change, options.error) +
           (hides ? fast : "") + "; ask for a larger --error or fewer --seconds" +
           (hides ? ", or give what oscillates \"damping\" or a larger \"compliance\"" : "");
  }
  const auto best = std::min_element(tuned.trials.begin(), tuned.trials.end(),
                                     [](const TuneTrial& a, const TuneTrial& b) { return a.error < b.error; });
  return formatted("no method reaches %g m; the best found: ", options.error) + best->method + ", " +
         counted(best->scene.solver.substeps, "substep") + formatted(", %.3g m", best->error);
}

Json tune_json(const TuneResult& tuned, const TuneOptions& options) {
  const Reference& reference = tuned.reference;
  Json json{{"error_m", options.error}, {"seconds", tuned.seconds}, {"threads", options.threads}};
  json["reference"] = {{"substeps", reference.substeps},
                       {"moved_by_last_doubling_m", number(reference.last_change)},
                       {"hidden_at_most_m", number(reference.hidden_motion)},
                       {"off_at_most_m", number(reference.error_bound)},
                       {"converged", reference.converged}};
  json["trials"] = Json::array();
  for (const TuneTrial& trial : tuned.trials)
    json["trials"].push_back({{"method", trial.method},
                              {"substeps", trial.scene.solver.substeps},
                              {"iterations", trial.scene.solver.iterations},
                              {"ms_per_s", trial.ms},
                              {"sweeps_per_s", trial.sweeps},
                              {"error_m", number(trial.error)},
                              {"found", trial.found}});
  json["best"] = tuned.best ? Json(*tuned.best) : Json();
  json["left_out"] = tuned.left_out;
  return json;
}

}  // namespace malha::tuning
