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

/// Lines in one box: its scale on the left, names above, times below. Nothing where there is nothing to show.
void graph(const std::string& title, const std::string& unit, const std::vector<Series>& series);

}  // namespace malha::view
