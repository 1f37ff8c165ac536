// SPDX-License-Identifier: Apache-2.0
#include "tools/tune/tune.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/model/model.h"
#include "malha/error.h"
#include "malha/text.h"
#include "tools/bench/medians.h"

namespace malha::tuning {

namespace {

constexpr int kMostSubsteps = 1 << 14;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Returns the mass (kg) of all particles if each had the mean mass of the body with the lightest movable particles. An
/// energy in any body moves particles by no more (RMS of all) than it would with this mass.
double least_mass(const Model& model) {
  std::vector<double> mass(model.scene.bodies.size()), count(mass.size());
  const std::vector<int> body = bodies_of(model);
  for (std::size_t i = 0; i < body.size(); ++i)
    if (model.w[i] > 0) mass[body[i]] += 1 / model.w[i], ++count[body[i]];
  double least = kNoLimit;
  for (std::size_t b = 0; b < mass.size(); ++b)
    if (count[b] > 0) least = std::min(least, mass[b] / count[b]);
  return least * static_cast<double>(model.w.size());
}

class Tuner {
 public:
  Tuner(const Scene& scene, const TuneOptions& options, const TuneProgress& progress, const std::atomic<bool>& stop)
      : scene_(scene), options_(options), progress_(progress), stop_(stop) {
    tuned_.seconds = options.seconds.value_or(std::min(scene.duration, 1.0));
    moments_ = moments(scene, tuned_.seconds);
    mass_ = least_mass(build_model(scene));
  }

  TuneResult run() {
    find_reference();
    if (!tuned_.reference.converged) return tuned_;
    try_once(scene_, "as it is: " + method_name(scene_), kNoLimit);
    const std::vector<Scene> methods = tune_methods(scene_, tuned_.left_out);
    for (std::size_t k = 0; k < methods.size(); ++k) {
      part_ = static_cast<double>(k) / static_cast<double>(methods.size());
      Scene scene = methods[k];
      try {
        if (search(scene) != "misses") continue;
        scene.solver.precision = Precision::Double;
        search(scene);
      } catch (const InputError& error) {  // for example because its filter does not fit in memory
        tuned_.left_out.push_back(method_name(scene) + ": " + error.what());
      }
    }
    choose_best();
    return tuned_;
  }

 private:
  void find_reference() {
    Scene scene = scene_;
    SolverSpec& solver = scene.solver;
    solver.precision = Precision::Double;
    if (solver.type == "pbd")
      solver.iterations = 1, solver.levels = 0;  // the limit of many substeps is independent of both
    solver.desbrun.storage.reset(), solver.desbrun.tolerance.reset();
    Reference& reference = tuned_.reference;
    std::vector<double> last_change;
    TuneRun before;
    for (solver.substeps = 8; solver.substeps <= kMostSubsteps; solver.substeps *= 2) {
      report_progress(
          "reference, " + counted(solver.substeps, "substep") +
          (last_change.empty() ? "" : ": the last doubling moved it by " + shown(last_change.back()) + " m"));
      TuneRun run = tune_run(scene, moments_, options_.threads, kNoLimit, stop_);
      const Reference last = std::move(reference);
      reference = {run, solver.substeps};
      if (solver.substeps > 8)
        last_change.push_back(distance_between(run, before)), reference.last_change = last_change.back();
      if (std::isfinite(reference.last_change)) bound(last, before, reference);
      before = std::move(run);
      if (reference.converged) return;
      // Three doublings reduce the change of a method of first order to an eighth.
      if (last_change.size() > 6 && !(last_change.back() < last_change[last_change.size() - 4] / 2)) return;
    }
  }

  /// Extrapolates a run with its predecessor `half` of half the substeps, and bounds the error of the result. With
  /// errors that decrease by r a doubling, the bound is r / (1 - r) times the last change of the extrapolation. Where
  /// steps are too long for some oscillations, these changes may be small by chance, so extrapolation is trusted to
  /// remove at most three quarters of the error.
  void bound(const Reference& last, const TuneRun& half, Reference& now) const {
    now.run = extrapolated(now.run, half);
    const double h = scene_.solver.dt / now.substeps;
    now.hidden_motion = std::sqrt(2 * std::abs(now.run.energy_loss.value_or(0)) / mass_ * h * tuned_.seconds);
    if (!std::isfinite(last.last_change)) return;
    const double nothing = options_.error / 1000, by = distance_between(now.run, last.run);
    const double ratio = now.last_change < nothing ? 0.5 : std::max(0.5, now.last_change / last.last_change);
    if (ratio < 1) now.remaining_change = std::max(by * ratio / (1 - ratio), now.last_change / 4);
    now.error_bound = now.remaining_change + now.hidden_motion;
    // The bound of the last reference must have held.
    now.converged = now.error_bound < options_.error / 8 && by < last.remaining_change + nothing;
  }

  /// Runs a scene once and stores the trial; returns its index.
  std::size_t try_once(const Scene& scene, const std::string& method, double most_ms) {
    report_progress(method + ", " + counted(scene.solver.substeps, "substep"));
    const TuneRun run = tune_run(scene, moments_, options_.threads, most_ms, stop_);
    TuneTrial trial{method, scene, run.ms, run.sweeps, distance_between(run, tuned_.reference.run), "misses"};
    if (run.diverged)
      trial.found = "diverged";
    else if (run.abandoned)
      trial.found = "dearer";
    else if (trial.error + tuned_.reference.error_bound <= options_.error)
      trial.found = "reaches", best_ms_ = std::min(best_ms_, run.ms);
    tuned_.trials.push_back(std::move(trial));
    return tuned_.trials.size() - 1;
  }

  /// The limit is above the best cost, so that noise of the machine excludes no method.
  double cost_limit() const { return 1.3 * best_ms_; }

  /// Searches the fewest substeps that reach the error; returns "reaches", or why there are none: "dearer", "misses".
  std::string search(Scene scene) {
    const std::string method = method_name(scene);
    const auto found = [&](int substeps) {
      scene.solver.substeps = substeps;
      return tuned_.trials[try_once(scene, method, cost_limit())].found;
    };
    const int most = most_substeps();
    int low = 0, high = 1;
    std::string how = found(high);
    for (; how != "reaches" && how != "dearer" && high < most; how = found(high)) low = high, high *= 2;
    if (how == "dearer") return how;
    if (how != "reaches") return "misses";
    while (high - low > std::max(1, low / 8)) {
      const int middle = (low + high) / 2;
      (found(middle) == "reaches" ? high : low) = middle;
    }
    return how;
  }

  /// The reference's own method, of first order, needs about last_change / error times its substeps; others may need
  /// more.
  int most_substeps() const {
    const Reference& reference = tuned_.reference;
    const double more = std::max(1.0, 8 * reference.last_change / options_.error);
    return static_cast<int>(std::min<double>(kMostSubsteps, more * reference.substeps));
  }

  /// Repeats the cheapest trials that reach the error in turns and chooses the best.
  void choose_best() {
    std::vector<std::size_t> close;
    for (std::size_t k = 0; k < tuned_.trials.size(); ++k)
      if (tuned_.trials[k].reaches() && tuned_.trials[k].ms < 1.5 * best_ms_ && has_fewest_substeps(k))
        close.push_back(k);
    std::sort(close.begin(), close.end(), [&](auto a, auto b) { return tuned_.trials[a].ms < tuned_.trials[b].ms; });
    constexpr std::size_t most = 6;
    if (close.size() > most) close.resize(most);
    part_ = 0.9;
    add_filters(close);
    constexpr int turns = 3;
    std::vector<std::vector<double>> ms(close.size());
    for (int turn = 0; turn < turns; ++turn)
      for (std::size_t k = 0; k < close.size(); ++k) {
        report_progress("the best in turns, " + std::to_string(turn + 1) + " of " + std::to_string(turns));
        ms[k].push_back(tune_run(tuned_.trials[close[k]].scene, moments_, options_.threads, kNoLimit, stop_).ms);
      }
    for (std::size_t k = 0; k < close.size(); ++k) {
      TuneTrial& trial = tuned_.trials[close[k]];
      trial.ms = bench::median(ms[k]);
      if (!tuned_.best || trial.ms < tuned_.trials[*tuned_.best].ms) tuned_.best = close[k];
    }
  }

  /// Returns whether no other trial of the method reaches the error with fewer substeps.
  bool has_fewest_substeps(std::size_t k) const {
    const TuneTrial& trial = tuned_.trials[k];
    return std::none_of(tuned_.trials.begin(), tuned_.trials.end(), [&](const TuneTrial& other) {
      return other.reaches() && other.method == trial.method &&
             other.scene.solver.substeps < trial.scene.solver.substeps;
    });
  }

  /// Adds trials of Desbrun's method with either filter, which have the same accelerations to rounding at other costs.
  void add_filters(std::vector<std::size_t>& close) {
    for (const std::size_t k : std::vector<std::size_t>(close)) {
      if (tuned_.trials[k].scene.solver.type != "desbrun") continue;
      for (const FilterKind kind : {FilterKind::Dense, FilterKind::Sparse}) {
        Scene scene = tuned_.trials[k].scene;
        scene.solver.desbrun.filter = kind;
        try {
          if (const std::size_t at = try_once(scene, method_name(scene), cost_limit()); tuned_.trials[at].reaches())
            close.push_back(at);
        } catch (const InputError&) {  // a dense filter does not fit in memory
        }
      }
    }
  }

  void report_progress(const std::string& what) const {
    if (progress_) progress_(what, part_);
  }

  const Scene& scene_;
  const TuneOptions& options_;
  const TuneProgress& progress_;
  const std::atomic<bool>& stop_;
  std::vector<int> moments_;
  double best_ms_ = kNoLimit, part_ = 0;
  double mass_ = 0;  // kg, see least_mass
  TuneResult tuned_;
};

}  // namespace

void check_tunable(const Scene& scene) {
  for (const BodySpec& body : scene.bodies)
    if (body.tear)
      refuse(scene.file, "", "'" + body.name + "', which tears", "bodies that keep their particles (no \"tear\")");
  if (scene.solver.desbrun.time_budget)
    refuse(scene.file, "/solver/time_budget", "a time budget, with which results depend on the clock", "none");
}

TuneResult tune(const Scene& scene, const TuneOptions& options, const TuneProgress& progress,
                const std::atomic<bool>& stop) {
  check_tunable(scene);
  return Tuner(scene, options, progress, stop).run();
}

}  // namespace malha::tuning
