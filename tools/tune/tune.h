// SPDX-License-Identifier: Apache-2.0
// Search of malha tune for the cheapest method and settings that reach an error on this machine.
#pragma once
#include <functional>
#include <limits>
#include <optional>

#include "tools/tune/methods.h"
#include "tools/tune/run.h"

namespace malha::tuning {

struct TuneOptions {
  double error = 0;  // m, > 0: RMS distance of particles to the reference at the worst of four moments
  std::optional<double> seconds = {};  // simulated time; none: the scene's duration, at most 1 s
  int threads = 1;
};

/// Cost and error of one method with one number of substeps.
struct TuneTrial {
  std::string method;
  Scene scene;
  double ms = 0;      // a simulated second
  double sweeps = 0;  // a simulated second
  double error = 0;   // m; infinite if it diverged
  std::string found;  // "reaches", "misses", "diverged", or "dearer": abandoned when it had cost more than the best
  bool reaches() const { return found == "reaches"; }
};

/// The reference solution: the same scene in double at ever more substeps, extrapolated to a step of zero.
struct Reference {
  TuneRun run;  // extrapolated
  int substeps = 0;
  double last_change = std::numeric_limits<double>::infinity();  // m, change of positions by the last doubling
  double remaining_change =
      std::numeric_limits<double>::infinity();  // m, bound of the change of extrapolated positions by further doublings
  double hidden_motion = 0;  // m, bound of the amplitude of oscillations that all of these steps have damped
  double error_bound =
      std::numeric_limits<double>::infinity();  // m, bound of the error of the reference: the sum of both
  bool converged = false;
};

struct TuneResult {
  double seconds = 0;
  Reference reference;
  std::vector<TuneTrial> trials;      // in the order in which they ran; the first one is the unchanged scene
  std::vector<std::string> left_out;  // methods that the scene excludes, with the reason
  std::optional<std::size_t> best;    // index of the best trial; none if none reaches the error
};

/// Called with the present activity and the completed share, 0 to 1.
using TuneProgress = std::function<void(const std::string& what, double part)>;

/// Throws InputError for scenes that tear (because their particles change) or have a time budget (because results
/// depend on the clock).
void check_tunable(const Scene& scene);

/// The reference uses the scene's own method with one iteration, extrapolated from two numbers of substeps to
/// infinitely many (Richardson, first order). They are doubled until the bound of its error is an eighth of the
/// requested error. The bound follows from the last change and the rate at which changes decrease, and is at least a
/// quarter of the change of the runs; the previous bound must have held. Oscillations that are too fast for all of
/// these steps are damped at once and change nothing, but where a scene conserves energy their energy E is missing.
/// Steps of h seconds hide oscillations faster than 1 / sqrt(h T) in T seconds (they are damped by h omega^2 / 2), with
/// amplitudes up to sqrt(2 E / m h T), where m is the scene's mass if all of it were its lightest body's; these count
/// in the bound. If doubling no longer reduces the change, or too little up to 16,384 substeps, the reference has not
/// converged (chaotic or too fast motion) and nothing is tried. A trial whose distance to the reference is below the
/// error minus the bound reaches the error, because it is then within the error of the exact solution. Each method gets
/// the fewest substeps that reach the error, to an eighth: they are doubled, then bisected, and abandoned once they are
/// certain to cost 1.3 times as much as the best so far. It is tried in double only if float misses the error. (Float
/// loses accuracy again with many substeps; if it is accurate only between two doublings, that is not found.) Trials
/// below 1.5 times the best are repeated in turns, Desbrun's with either filter, and the cheapest wins. Throws
/// InputError, as check_tunable and simulations do, and Interrupted if the user stops it.
TuneResult tune(const Scene& scene, const TuneOptions& options, const TuneProgress& progress,
                const std::atomic<bool>& stop);

}  // namespace malha::tuning
