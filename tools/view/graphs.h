// SPDX-License-Identifier: Apache-2.0
// Graphs over simulated time.
#pragma once
#include <string>
#include <vector>

namespace malha::view {

struct Series {
  std::string name;
  std::vector<double> times, values;  // s
};

/// Draws the series as lines in one box, with the scale on the left, names above and times below; nothing for a single
/// time.
void graph(const std::string& title, const std::string& unit, const std::vector<Series>& series);

}  // namespace malha::view
