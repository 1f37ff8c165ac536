// SPDX-License-Identifier: Apache-2.0
// Trial runs of a scene for malha tune: positions at some moments, and the cost.
#pragma once
#include <atomic>
#include <optional>
#include <vector>

#include "malha/scene.h"

namespace malha::tuning {

/// Returns four moments in steps, at the quarters of the simulated time (fewer if it has fewer steps). The last one is
/// its end.
std::vector<int> moments(const Scene& scene, double seconds);

struct TuneRun {
  std::vector<std::vector<Vec3>> at;  // positions at the moments, m; fewer if the run diverged or was abandoned
  double ms = 0;                      // ms a simulated second, without the slowest tenth of the steps
  double sweeps = 0;                  // per simulated second: projections of every constraint, or solves
  bool diverged = false, abandoned = false;
  std::optional<double> energy_loss;  // J, at the last moment, of a scene that conserves energy
};

/// Returns whether the scene conserves energy: it has no damping, wind, contact, sleep, tears, limits of length, and no
/// motion by keyframes.
bool keeps_energy(const Scene& scene);

/// Runs until the last moment, or until it is certain to take more than `most_ms` a simulated second. Throws InputError
/// for a scene that cannot be simulated, Interrupted if the user stops it.
TuneRun tune_run(const Scene& scene, const std::vector<int>& moments, int threads, double most_ms,
                 const std::atomic<bool>& stop);

/// Returns Richardson's extrapolation 2 fine - coarse of positions and energy losses, for two runs with errors of first
/// order, of which `fine` has twice the substeps.
TuneRun extrapolated(const TuneRun& fine, const TuneRun& coarse);

/// Returns the largest of the RMS distances between particles at the same moments, m; infinite if a moment is missing.
double distance_between(const TuneRun& a, const TuneRun& b);

}  // namespace malha::tuning
