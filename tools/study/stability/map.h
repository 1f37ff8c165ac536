// SPDX-License-Identifier: Apache-2.0
// Maps of the study "stability": columns of trials from the safest setting to the least safe one, with the boundary of
// failure.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tools/study/stability/trial.h"
#include "tools/study/study.h"

namespace malha::study {

struct Axis {
  std::string name;
  std::vector<double> values;  // > 0, drawn at equal distances; interpolated by their logarithms
};

/// A line of theory that is drawn over a panel: points (x, y).
struct TheoryLine {
  std::string title;
  std::vector<std::pair<double, double>> points;
};

struct Panel {
  std::string title;
  Axis x, y;                       // y: from the safest value to the least safe; drawn with the smallest at the bottom
  std::vector<Json> columns = {};  // from run_columns(), one for each value of x
  std::vector<TheoryLine> theory = {};
  bool is_malha = true;
};

/// Runs the trials of a panel's columns: trial(k, y) for the x value of index k and all values of y. Between a stable
/// value and a failing neighbour the boundary is found by bisection, in whole numbers if `whole`. Each column is a cell
/// `key` VALUE `unit`: {verdicts: [0 stable, 1 wrong, 2 diverged], strains, rms, gains, warned, edges: [[y, y], ...]};
/// stable_to, fails_from and fails_as of the last boundary from stable to failing, and stable_from of the last boundary
/// from failing to stable.
void run_columns(Panel& panel, Cells& cells, const std::string& key, const std::string& unit, bool whole,
                 const std::function<Outcome(std::size_t k, double y)>& trial);

/// Completes the section of a map: a sentence about how many of malha's failing and stable settings `malha run` warns
/// of, a chart of all panels, `across` in a row, and a table with a row per column. Adds a row for each setting.
void complete_map_section(Section& section, const std::string& name, const std::string& title,
                          const std::vector<Panel>& panels, int across, Json& rows);

/// A number without trailing zeros, and with exponents such as 1e6 instead of 1e+06.
std::string short_number(double value);

}  // namespace malha::study
