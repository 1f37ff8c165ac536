// SPDX-License-Identifier: Apache-2.0
// Trials of the study "stability": a body runs for a while, and what became of it is judged.
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
  double energy = 0;  // J, of motion and height: bodies at rest length at the start never have more than then
};

struct Trial {
  std::function<void()> step;
  std::function<Sample()> sample;
  int steps = 1;
  double scale = 1;     // J: what the body can fall by
  bool warned = false;  // `malha run` warns of its settings
};

struct Outcome {
  Verdict verdict = Verdict::Stable;
  double strain = 0, rms = 0;  // the most of all samples
  double gain = 0;             // the most energy above the start's, over `scale`
  bool warned = false;
};

inline constexpr double kWrongStrain = 0.5, kWrongGain = 0.05, kDivergedGain = 10;

/// Diverged: no longer finite, or the energy has grown by more than kDivergedGain. Wrong: some strain is above
/// kWrongStrain, or the energy has grown by more than kWrongGain. At most 200 samples.
Outcome judge(const Trial& trial, const Cells& cells);

/// Steps that take at least `seconds`, at least 200; but at most `most`.
int steps_of(double seconds, double step, int most);

/// The same bodies, by malha on one thread. `model`: of a scene, perhaps with other masses.
Trial malha_trial(const Scene& scene, int steps, double scale);
Trial malha_trial(const Model& model, int steps, double scale);

/// Of a state of springs; strains against lengths at rest.
Sample sample_of(const SpringSystem& system, const State& state);

/// By an integrator that takes a state one step further.
Trial reference_trial(const SpringSystem& system, std::function<void(State&)> advance, int steps, double scale);

inline constexpr double kGravity = 9.81;  // m/s^2

/// A sheet of n x n particles, horizontal at the start, held at one row; edges and diagonals of this compliance (m/N),
/// or of PBD's stiffness where it is 0.
Scene hanging_sheet(int n, double side, double mass, double compliance);

/// The same, held at the two corners of that row.
Scene corner_pinned_sheet(int n, double side, double mass, double compliance);

/// A straight chain from the origin, where it is held; compliance likewise.
Scene pinned_chain(const Vec3& end, int links, double mass, double compliance);

}  // namespace malha::study
