// SPDX-License-Identifier: Apache-2.0
// Line charts of the study "stability" about known failures: a value over a setting, with a line per method.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "tools/study/stability/trial.h"
#include "tools/study/study.h"

namespace malha::study {

struct Line {
  std::string title;
  std::vector<std::pair<double, double>> points;  // y is NaN if the run was no longer finite
  std::vector<Json> cells = {};                   // the cell of each point
  double at(double x) const;                      // y at x; throws std::out_of_range
  /// Adds the point at x, whose y is the result of run() in a cell; NaN (null in JSON) if it diverged.
  void add(double x, Cells& from, const std::string& key, const std::function<double()>& run);
};

struct LineChart {
  std::string name, title, x, y;  // axes, both logarithmic
  std::vector<Line> lines;
};

/// The line of run(setting) at x = scale * setting, one cell per setting.
Line line_over(Cells& cells, const LineChart& line_chart, const std::string& title, const std::vector<double>& settings,
               double scale, const std::function<double(double)>& run);

/// A section with chart and table of the lines, without sentences; adds a row for each point.
Section lines_section(const LineChart& lines, Json& rows);

/// PBD's stiffness depends on the step; float with many substeps; float far from the origin.
Section stiffness_failure(Cells& cells, Json& rows);
Section substeps_failure(Cells& cells, Json& rows);
Section distance_failure(Cells& cells, Json& rows);

/// Collapsed and random initial states; thickness smaller than the displacement of a particle in a substep.
Section start_failure(Cells& cells, Json& rows);
Section thickness_failure(Cells& cells, Json& rows);

/// Stiff shells of irregular meshes on impact.
Section impact_failure(Cells& cells, Json& rows);

/// Desbrun's linear filter: loss of angular momentum, damping of rotating parts, and gravity that is not filtered.
Section torque_failure(Cells& cells, Json& rows);
Section turning_failure(Cells& cells, Json& rows);
Section weight_failure(Cells& cells, Json& rows);

}  // namespace malha::study
