// SPDX-License-Identifier: Apache-2.0
// malha tune: the cheapest method and settings that reach an error on this machine.
#pragma once
#include <functional>
#include <limits>
#include <optional>

#include "tools/tune/methods.h"
#include "tools/tune/run.h"

namespace malha::study {

struct TuneOptions {
  double error = 0;  // m, > 0: RMS distance of particles to the reference, at the worst of four moments
  std::optional<double> seconds = {};  // simulated; none: the scene's duration, at most 1 s
  int threads = 1;
};

/// How one solver did.
struct Tried {
  std::string method;
  Scene scene;
  double ms = 0;      // a simulated second
  double sweeps = 0;  // a simulated second
  double error = 0;   // m; infinite: it diverged
  std::string found;  // "reaches", "misses", "diverged", "dearer": given up when it had cost more than the best
  bool reaches() const { return found == "reaches"; }
};

/// The same scene at ever more substeps, in double, and from there to no step at all.
struct Reference {
  TuneRun run;  // extrapolated
  int substeps = 0;
  double moved = std::numeric_limits<double>::infinity();    // m: what the last doubling moved the particles by
  double settled = std::numeric_limits<double>::infinity();  // m: how much farther doublings move the extrapolated ones
  double hidden = 0;  // m: what oscillations that all of these steps have damped away may amount to
  double off = std::numeric_limits<double>::infinity();  // m: how far from the truth they are at most, both together
  bool converged = false;
};

struct Tuned {
  double seconds = 0;
  Reference reference;
  std::vector<Tried> trials;          // in the order in which they ran; the first is the scene as it is
  std::vector<std::string> left_out;  // methods that the scene rules out, and why
  std::optional<std::size_t> best;    // of the trials; none: none reaches the error
};

/// What is done now, and how much of everything is done: 0 to 1.
using TuneProgress = std::function<void(const std::string& what, double part)>;

/// Throws InputError for scenes that tear (their particles are others then) or that have a time budget (results depend
/// on the clock).
void check_tunable(const Scene& scene);

/// The reference is of the scene's own method with one iteration, extrapolated from two numbers of substeps to none
/// (Richardson, first order). They are doubled until its own error is bounded by an eighth of the error asked for: by
/// what the last doubling moved it and by how fast such moves fall, and by a quarter of what it moved the runs. The
/// bound before must have held. Oscillations that are too fast for all of these steps die out at once and move nothing,
/// but their energy E is missed where a scene keeps its energy: steps of h seconds hide those faster than 1 / sqrt(h T)
/// in T seconds (they are damped by h omega^2 / 2), of amplitudes up to sqrt(2 E / m h T), m the
/// scene's mass if all of it were its lightest body's, which count too.
/// If doubling no longer helps, or helps too little up to 16,384 substeps, it has not converged (chaotic or too fast
/// motion) and nothing is tried.
/// What is within the error less that bound reaches it, and so is within the error of the truth.
/// Each method gets the fewest substeps that reach the error, to an eighth: doubled, then bisected, and given up as
/// soon as it is sure to cost 1.3 times as much as the best so far; in double only where float misses it so. (Float is
/// worse again with many substeps; where it is right only between two doublings, that is not seen.) Those below 1.5
/// times the best run again in turns, Desbrun's with either filter, and the cheapest wins. Throws InputError, as
/// check_tunable and simulations do, and Interrupted where the user stops it.
Tuned tune(const Scene& scene, const TuneOptions& options, const TuneProgress& progress, const std::atomic<bool>& stop);

}  // namespace malha::study
