// SPDX-License-Identifier: Apache-2.0
// What the study "size" says of errors: against the number of particles, and what little error costs.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// A way to have the cloth hang, as charts and tables name it.
struct HangingMethod {
  std::string name;      // "levels", "PBD"
  std::string settings;  // at about the cost of levels with 10 substeps
  const char* line;      // of gnuplot: PBD's is wide, because XPBD's lies on it
  std::string title() const { return name + ", " + settings; }
};

/// The strain that "1 %" means.
constexpr double kTargetStrain = 0.01;

/// `rows`: "measures": "error" or "work", "method", "mesh", "side", and where they were run the numbers.
std::vector<Section> size_error_sections(const std::vector<HangingMethod>& methods, const Json& rows);

}  // namespace malha::study
