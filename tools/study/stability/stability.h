// SPDX-License-Identifier: Apache-2.0
// Study "stability": the settings with which each method fails, how it fails, and remedies.
#pragma once
#include <string>
#include <vector>

#include "tools/study/study.h"

namespace malha::study {

/// A part of the study: a map or a known failure.
struct StabilityPart {
  std::string name;                // value of "map" in its rows
  int cells = 0, quick_cells = 0;  // number of cells, in the full and the quick version
  std::vector<Section> (*run)(Cells& cells, Json& rows) = nullptr;
};

const std::vector<StabilityPart>& stability_parts();

Findings run_stability(Cells& cells);

}  // namespace malha::study
