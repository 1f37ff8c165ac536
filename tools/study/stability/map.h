// SPDX-License-Identifier: Apache-2.0
// Maps of the study "stability": columns of trials from the safest setting to the least safe one, and where they start
// to fail.
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
  std::vector<double> values;  // > 0, drawn at equal distances; between them by their logarithms
};

/// A line to be drawn over a panel: pairs of an x and a y.
struct TheoryLine {
  std::string title;
  std::vector<std::pair<double, double>> points;
};

struct Panel {
  std::string title;
  Axis x, y;                       // y: from the safest to the least safe; drawn from the smallest upwards
  std::vector<Json> columns = {};  // of fill(), one a value of x
  std::vector<TheoryLine> theory = {};
  bool is_malha = true;  // malha's method
};

/// Fills the panel's columns: trial(k, y) at the value of x number k and at all values of y, and wherever what holds
/// and what does not are neighbours, the edge between them by bisection, of whole numbers where `whole`. Each is kept
/// in a cell `key` VALUE `unit`: {verdicts: [0 stable, 1 wrong, 2 diverged], strains, rms, gains, warned, edges: [[y,
/// y],
/// ...]}; and stable_to, fails_from and fails_as of the last edge beyond which it fails, stable_from of one before
/// which it does.
void run_columns(Panel& panel, Cells& cells, const std::string& key, const std::string& unit, bool whole,
                 const std::function<Outcome(std::size_t k, double y)>& trial);

/// Adds to the section how many of malha's cells fail with a warning of `malha run` and how many hold with one, a chart
/// of all panels beside each other, `across` in a row, and a table with a row a column; to the rows one a cell.
void complete_map_section(Section& section, const std::string& name, const std::string& title,
                          const std::vector<Panel>& panels, int across, Json& rows);

/// "1e+06" as 1e6, without trailing zeros.
std::string short_number(double value);

}  // namespace malha::study
