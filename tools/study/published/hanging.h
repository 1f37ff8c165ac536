// SPDX-License-Identifier: Apache-2.0
// Scene of several papers: a weight at the end of a chain of light particles, which hangs straight down at its rest
// length and is released.
#pragma once
#include <limits>
#include <string>

#include "tools/study/cells.h"

namespace malha::study {

inline constexpr int kParticles = 20, kLinks = kParticles - 1;
inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A chain of particles of 1 kg with a heavier last one.
struct HangingWeight {
  double weight, spacing, stiffness;  // kg, m, N/m
  double dt, gravity;                 // s, m/s^2
  int substeps, iterations;
  bool long_range = false;
};

/// The whole setting in words, for cells.
std::string key_of(const HangingWeight& hanging);

/// {most_m, still_m, frame}: the largest distance of the weight below its initial position in the first swing, its
/// distance at rest (the mean over that swing), and the frame in which it is lowest.
Json malha_swing(const HangingWeight& hanging);
Json newton_swing(const HangingWeight& hanging);  // backward Euler in steps of dt

/// Results by malha, and by a plain sweep from the support on; together they are one cell.
struct SwingResults {
  Json malha, plain;
};
SwingResults measure_swings(Cells& cells, const std::string& name, const HangingWeight& hanging);

inline double largest_drop(const Json& run) { return run["most_m"].get<double>(); }

/// A row of the study.
Json row(const char* name, const HangingWeight& hanging, const char* method, const Json& run);

}  // namespace malha::study
