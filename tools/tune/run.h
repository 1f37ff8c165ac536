// SPDX-License-Identifier: Apache-2.0
// Runs of a scene for malha tune: where its particles are at some moments, and what getting there takes.
#pragma once
#include <atomic>
#include <optional>
#include <vector>

#include "malha/scene.h"

namespace malha::study {

/// Four moments of the simulated time, in steps: at its quarters (fewer where it has fewer steps). The last is its end.
std::vector<int> moments(const Scene& scene, double seconds);

struct TuneRun {
  std::vector<std::vector<Vec3>> at;  // positions at the moments, m; fewer where the run diverged or was given up
  double ms = 0;                      // a simulated second, by its steps without the slowest tenth of them
  double sweeps = 0;                  // a simulated second: projections of every constraint, or solves
  bool diverged = false, given_up = false;
  std::optional<double> lost;  // J, of a scene that keeps its energy: what it has less at the last moment
};

/// Whether nothing in the scene takes energy or gives any: no damping, wind, contact, sleep, tears, limits of length,
/// and nothing that moves by keyframes.
bool keeps_energy(const Scene& scene);

/// Runs until the last moment, or until it is sure to take more than `most_ms` a simulated second. Throws
/// InputError for what cannot be simulated, Interrupted where the user stops it.
TuneRun tune_run(const Scene& scene, const std::vector<int>& moments, int threads, double most_ms,
                 const std::atomic<bool>& stop);

/// 2 fine - coarse, of what was lost too: where two runs, one with twice the other's substeps, lead to if their errors
/// are of first order.
TuneRun extrapolated(const TuneRun& fine, const TuneRun& coarse);

/// The largest of the RMS distances between particles at the same moments, m; infinite where a moment is missing.
double distance_between(const TuneRun& a, const TuneRun& b);

}  // namespace malha::study
