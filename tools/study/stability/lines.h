// SPDX-License-Identifier: Apache-2.0
// Known failures of the study "stability": one number against one setting, a line a method.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "tools/study/stability/trial.h"
#include "tools/study/study.h"

namespace malha::study {

struct Line {
  std::string title;
  std::vector<std::pair<double, double>> points;  // a NaN is what was no longer finite
  std::vector<Json> cells = {};                   // of which they are
  double at(double x) const;                      // y there; throws std::out_of_range
  /// The point at x, a number that a run gives, from a cell; NaN, null in JSON, where it diverged.
  void add(double x, Cells& from, const std::string& key, const std::function<double()>& run);
};

struct LineChart {
  std::string name, title, x, y;  // axes, both logarithmic
  std::vector<Line> lines;
};

/// run(setting) over the settings, each kept in a cell of the line's name, at x = scale setting.
Line line_over(Cells& cells, const LineChart& line_chart, const std::string& title, const std::vector<double>& settings,
               double scale, const std::function<double(double)>& run);

/// Chart and table of the lines, without sentences; adds a row a point.
Section lines_section(const LineChart& lines, Json& rows);

/// PBD's stiffness is none of the material; float at many substeps; float far from the origin.
Section stiffness_failure(Cells& cells, Json& rows);
Section substeps_failure(Cells& cells, Json& rows);
Section distance_failure(Cells& cells, Json& rows);

/// Collapsed and random starts; thickness smaller than what a particle moves in a substep.
Section start_failure(Cells& cells, Json& rows);
Section thickness_failure(Cells& cells, Json& rows);

/// Stiff shells of irregular meshes on impact.
Section impact_failure(Cells& cells, Json& rows);

/// What Desbrun's linear filter does to angular momentum, and to turning parts; weight that goes round the filter.
Section torque_failure(Cells& cells, Json& rows);
Section turning_failure(Cells& cells, Json& rows);
Section weight_failure(Cells& cells, Json& rows);

}  // namespace malha::study
