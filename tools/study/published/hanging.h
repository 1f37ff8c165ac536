// SPDX-License-Identifier: Apache-2.0
// A weight at the end of a chain of light particles, that hangs straight down at rest length and is let go.
#pragma once
#include <limits>
#include <string>

#include "tools/study/cells.h"

namespace malha::study {

inline constexpr int kParticles = 20, kLinks = kParticles - 1;
inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Particles of 1 kg, the last one heavier.
struct HangingWeight {
  double weight, spacing, stiffness;  // kg, m, N/m
  double dt, gravity;                 // s, m/s^2
  int substeps, iterations;
  bool long_range = false;
};

/// All of it in words.
std::string key_of(const HangingWeight& hanging);

/// {most_m, still_m, frame}: how far the weight gets below its place in the first swing, how far it is when it hangs
/// still, which is the mean over that swing, and the frame in which it is lowest.
Json malha_swing(const HangingWeight& hanging);
Json newton_swing(const HangingWeight& hanging);  // backward Euler in steps of dt

/// By malha, and by a plain sweep from the support on; one cell.
struct SwingResults {
  Json malha, plain;
};
SwingResults measure_swings(Cells& cells, const std::string& name, const HangingWeight& hanging);

inline double largest_drop(const Json& run) { return run["most_m"].get<double>(); }

/// A row of the study's.
Json row(const char* name, const HangingWeight& hanging, const char* method, const Json& run);

}  // namespace malha::study
