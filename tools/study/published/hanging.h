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
struct Hanging {
  double weight, spacing, stiffness;  // kg, m, N/m
  double dt, gravity;                 // s, m/s^2
  int substeps, iterations;
  bool long_range = false;
};

/// All of it in words.
std::string key(const Hanging& of);

/// {most_m, still_m, frame}: how far the weight gets below its place in the first swing, how far it is when it hangs
/// still, which is the mean over that swing, and the frame in which it is lowest.
Json by_malha(const Hanging& of);
Json by_newton(const Hanging& of);  // backward Euler in steps of dt

/// By malha, and by a plain sweep from the support on; one cell.
struct Runs {
  Json malha, plain;
};
Runs runs(Cells& cells, const std::string& name, const Hanging& of);

inline double most(const Json& run) { return run["most_m"].get<double>(); }

/// A row of the study's.
Json row(const char* name, const Hanging& of, const char* method, const Json& run);

}  // namespace malha::study
