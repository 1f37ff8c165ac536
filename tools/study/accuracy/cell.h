// SPDX-License-Identifier: Apache-2.0
// A cell of the study "accuracy": a method runs a case, and its errors are measured.
#pragma once
#include "tools/study/accuracy/methods.h"
#include "tools/study/cells.h"

namespace malha::study {

/// About the accumulated rounding error of positions of some metres.
constexpr double kPerturbation = 1e-14;  // m

/// The true motion of a case at its times.
struct Truth {
  std::vector<State> at;  // at each of the times
  // RMS distances, m; empty in closed form: to the run with twice the step, and between that run and one whose start
  // is perturbed by kPerturbation.
  std::vector<double> step_difference, perturbed_difference;
  std::vector<double> uncertainty;  // m, of the true motion: the larger of both
  double energy = 0;                // J: the largest kinetic plus elastic energy during the motion
  double omega = 0;                 // rad/s: largest_frequency() at the start
};

/// The true motion in closed form, or by RK4 in three cells.
Truth truth_of(const AccuracyCase& test_case, const System& system, Cells& cells);

/// {status, ms_per_s, sweeps_per_s, ..., at: [{time_s, rms_error_m, ...}]}. Costs are per simulated second on one
/// thread: the median processor time of a frame (wall time on a device), and counts that do not depend on the machine.
/// A run that is no longer finite has the status "diverged", and no errors from then on.
Json accuracy_cell(const AccuracyCase& test_case, const System& system, const Method& method, const Truth& truth,
                   const Cells& cells);

}  // namespace malha::study
