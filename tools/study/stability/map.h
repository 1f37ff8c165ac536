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
  Axis x, y;                  // y: from the safest to the least safe; drawn from the smallest upwards
  std::vector<Json> columns;  // of column(), one a value of x
  std::vector<TheoryLine> theory = {};
  bool ours = true;  // malha's method
};

/// Trials at all values of y, and wherever what holds and what does not are neighbours, the edge between them by
/// bisection, of whole numbers where `whole`: {verdicts: [0 stable, 1 wrong, 2 diverged], strains, rms, gains, warned,
/// edges: [[y, y], ...]}; and stable_to, fails_from and fails_as of the last edge beyond which it fails, stable_from of
/// one before which it does.
Json column(const Axis& y, bool whole, const std::function<Outcome(double y)>& trial);

/// All panels beside each other, `across` in a row.
Chart map_chart(const std::string& name, const std::string& title, const std::vector<Panel>& panels, int across);

/// A row a column, with the boundary.
Table map_table(const std::vector<Panel>& panels);

/// How many of malha's cells fail with a warning of `malha run`, and how many hold with one.
std::string warned_sentence(const std::vector<Panel>& panels);

/// Rows for NAME.csv, one a cell.
void add_rows(const std::string& map, const std::vector<Panel>& panels, Json& rows);

/// "1e+06" as 1e6, without trailing zeros.
std::string short_number(double value);

}  // namespace malha::study
