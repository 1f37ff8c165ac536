// SPDX-License-Identifier: Apache-2.0
// Study "stability": where each method fails, how, and what guards the user.
#pragma once
#include <string>
#include <vector>

#include "tools/study/study.h"

namespace malha::study {

/// A map, or a known failure.
struct StabilityPart {
  std::string name;                // of its rows: "map"
  int cells = 0, quick_cells = 0;  // that it makes, in full and in quick
  std::vector<Section> (*run)(Cells& cells, Json& rows) = nullptr;
};

const std::vector<StabilityPart>& stability_parts();

Findings run_stability(Cells& cells);

}  // namespace malha::study
