// SPDX-License-Identifier: Apache-2.0
// One cell of the study "accuracy": a method runs a case.
#pragma once
#include "tools/study/accuracy/methods.h"
#include "tools/study/cells.h"

namespace malha::study {

/// What rounding of places of some metres adds up to, about.
constexpr double kPerturbation = 1e-14;  // m

/// The true motion of a case at its times.
struct Truth {
  std::vector<State> at;  // one a time
  // m, RMS distances, 0 in closed form: of the same with twice the step to it, and to one that starts kShake off.
  std::vector<double> step_difference, perturbed_difference;
  std::vector<double> uncertainty;  // m: how well the true motion is known, the larger of both
  double energy = 0;                // J in motion: the most of kinetic and elastic energy on the way
  double omega = 0;                 // rad/s: largest_frequency() at the start
};

/// In closed form, or by RK4 in three cells.
Truth truth_of(const AccuracyCase& test_case, const System& system, Cells& cells);

/// {status, ms_per_s, sweeps_per_s, ..., at: [{time_s, rms_error_m, ...}]}. Costs are those of a simulated second on
/// one thread: the median frame's processor time, of a device its time by the clock, and counts that do not depend on
/// the machine. A run that is no longer finite has the status "diverged", and no errors from there on.
Json accuracy_cell(const AccuracyCase& test_case, const System& system, const Method& method, const Truth& truth,
                   const Cells& cells);

}  // namespace malha::study
