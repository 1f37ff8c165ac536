// SPDX-License-Identifier: Apache-2.0
// The amplification of a substep: by how much it multiplies the motion of a body that stands at rest. Nothing but the
// body's own constraints acts then, so that motion that grows is energy that the solver adds.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Of a body alone, without gravity, wind, damping, contacts and whatever moves its pins.
struct Amplification {
  double growth = 0;   // 1/s, of the motion that grows fastest, or else fades slowest; below 0 it fades
  double damping = 0;  // 1/s, that the scene takes of any motion: the body's `damping`, and the wind's `drag`
  double seconds = 0;  // simulated: the longer, the slower is what can be told apart
  /// By which a substep multiplies that motion: the spectral radius of its linearisation.
  double of_a_substep(const SolverSpec& solver) const;
  /// Whether it grows faster than the scene damps it, by more than what the time leaves uncertain.
  bool grows() const;
};

/// The body's, by power iteration in double: a small motion is taken through `steps` of them and made small again after
/// each. Zero modes, such as rigid motions and what no constraint resists, neither grow nor fade and are left out.
/// None: the body comes to no rest, such as a sheet that is pressed in its plane, or cannot be simulated alone.
std::optional<Amplification> measure_amplification(const Scene& scene, std::size_t body, int steps, int threads = 1,
                                                   const PatchBounds& bounds = {});

/// Of each body of a scene, where there is any; the same on every machine. It takes at most as long as `steps` steps of
/// the scene do, about, and leaves bodies out for which that is too little.
std::vector<std::optional<Amplification>> measure_amplifications(const Model& model, double steps, int threads = 1);

/// What `malha plan` says of them.
std::string list_amplifications(const Model& model, const std::vector<std::optional<Amplification>>& all);

/// Warnings of bodies whose motion grows.
std::vector<std::string> growth_warnings(const Model& model, const std::vector<std::optional<Amplification>>& all);

/// So many steps may `malha plan` take for it, and a run of `steps` steps: a hundredth.
double amplification_steps_of_plan(const Model& model);
inline double amplification_steps_of_run(std::int64_t steps) { return 0.01 * static_cast<double>(steps); }

}  // namespace malha
