// SPDX-License-Identifier: Apache-2.0
// Trials of the study "stability": a body is simulated for some time, and the result is judged.
#pragma once
#include <functional>

#include "host/model/model.h"
#include "tools/study/cells.h"
#include "tools/study/reference/system.h"
#include "tools/study/step_length.h"

namespace malha::study {

enum class Verdict { Stable, Wrong, Diverged };

struct Sample {
  double strain = 0;  // the largest |l / l0 - 1|
  double rms = 0;     // their RMS
  double energy = 0;  // J, kinetic and gravitational; if a body starts at its rest lengths, it must not grow
};

struct Trial {
  std::function<void()> step;
  std::function<Sample()> sample;
  int steps = 1;
  double scale = 1;     // J: the potential energy that the body can lose
  bool warned = false;  // true if `malha run` warns of the settings
};

struct Outcome {
  Verdict verdict = Verdict::Stable;
  double strain = 0, rms = 0;  // maxima of all samples
  double gain = 0;             // largest gain of energy since the start, over `scale`
  bool warned = false;
};

inline constexpr double kWrongStrain = 0.5, kWrongGain = 0.05, kDivergedGain = 10;

/// Runs a trial and judges it by at most about 200 samples. Diverged: no longer finite, or a gain above kDivergedGain.
/// Wrong: a strain above kWrongStrain, or a gain above kWrongGain.
Outcome judge(const Trial& trial, const Cells& cells);

/// The number of steps for at least `seconds`, but at least 200 and at most `most`.
int steps_of(double seconds, double step, int most);

/// Trials by malha on one thread. `model`: of a scene, possibly with changed masses.
Trial malha_trial(const Scene& scene, int steps, double scale);
Trial malha_trial(const Model& model, int steps, double scale);

/// The sample of a state of springs.
Sample sample_of(const SpringSystem& system, const State& state);

/// A trial by an integrator. `advance`: advances a state by a step.
Trial reference_trial(const SpringSystem& system, std::function<void(State&)> advance, int steps, double scale);

inline constexpr double kGravity = 9.81;  // m/s^2

/// A sheet of n x n particles, horizontal at the start and pinned at one row, with edges and diagonals of this
/// compliance (m/N), or of stiffness 1 by PBD if it is 0.
Scene hanging_sheet(int n, double side, double mass, double compliance);

/// The same sheet, pinned at the two corners of that row.
Scene corner_pinned_sheet(int n, double side, double mass, double compliance);

/// A straight chain from the origin, where it is pinned, to `end`; `compliance` as above.
Scene pinned_chain(const Vec3& end, int links, double mass, double compliance);

}  // namespace malha::study
