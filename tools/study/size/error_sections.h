// SPDX-License-Identifier: Apache-2.0
// Sections of the study "size" about errors: over the number of particles, and the cost of a given error.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// A method for the hanging cloth or a clamped strip, with its names in charts and tables.
struct HangingMethod {
  std::string name;      // "levels", "PBD"
  std::string settings;  // of about the same cost as levels with 10 substeps
  const char* line;      // gnuplot's line style; PBD's is wide, because XPBD's coincides with it
  std::string title() const { return name + ", " + settings; }
};

/// The RMS strain that the rows of "work" reach.
constexpr double kTargetStrain = 0.01;

/// `bending`: methods of the rows of "bending". `rows`: {measures: "error", "work" or "bending", method, mesh, side,
/// left_out, ...}, with the measured values if they were run.
std::vector<Section> size_error_sections(const std::vector<HangingMethod>& methods,
                                         const std::vector<HangingMethod>& bending, const Json& rows);

}  // namespace malha::study
