// SPDX-License-Identifier: Apache-2.0
// Amplification of a substep: the factor by which it multiplies small motions of a body about its rest state. Only the
// body's own constraints act then, so a motion that grows gains energy from the solver.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Growth of small motions of one body, simulated alone: without gravity, wind, damping, contacts and moving pins.
struct Amplification {
  double growth = 0;   // 1/s, of the motion that grows fastest, or else decays slowest; a negative rate is decay
  double damping = 0;  // 1/s, of the scene: the body's `damping`, and the wind's `drag`
  double seconds = 0;  // simulated time; a longer one tells slower growth apart
  /// Returns the factor by which a substep multiplies that motion: the spectral radius of its linearisation.
  double of_a_substep(const SolverSpec& solver) const;
  /// Returns whether the motion grows faster than the scene damps it, by more than the uncertainty that the simulated
  /// time leaves.
  bool grows() const;
};

/// Measures a body's amplification by power iteration in double precision: a small motion is advanced by `steps` steps
/// and scaled down again after each. Zero modes, such as rigid motions and deformations that no constraint resists,
/// neither grow nor decay and are left out. Returns none where the body comes to no rest, such as a sheet that is
/// compressed in its plane, or cannot be simulated alone.
std::optional<Amplification> measure_amplification(const Scene& scene, std::size_t body, int steps, int threads = 1,
                                                   const PatchBounds& bounds = {});

/// Measures the amplification of every body of a scene, with the same result on every machine. It takes at most about
/// as long as `steps` steps of the scene, and leaves out bodies for which that is too little.
std::vector<std::optional<Amplification>> measure_amplifications(const Model& model, double steps, int threads = 1);

/// One warning for each body whose small motions grow.
std::vector<std::string> growth_warnings(const Model& model, const std::vector<std::optional<Amplification>>& all);

/// The time that measuring amplifications may take, in steps of the scene: in `malha plan`, and in a run of `steps`
/// steps, where it is a hundredth of the run.
double amplification_steps_of_plan(const Model& model);
inline double amplification_steps_of_run(std::int64_t steps) { return 0.01 * static_cast<double>(steps); }

}  // namespace malha
