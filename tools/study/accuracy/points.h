// SPDX-License-Identifier: Apache-2.0
// Points of the study "accuracy", from which charts and sentences are made: a method's cost and error at one time.
#pragma once
#include <string>
#include <vector>

#include "tools/study/accuracy/methods.h"
#include "tools/study/cells.h"

namespace malha::study {

struct Point {
  std::string series, settings;  // "XPBD, substeps, float", "16x1"
  bool is_malha = true;
  bool variant = false;                       // appears only in the chart of filters
  double ms = 0, sweeps = 0;                  // per simulated second
  double error = 0;                           // RMS, m
  double energy = 0;                          // relative drift
  double strain = 0;                          // RMS error
  double momentum = 0, angular_momentum = 0;  // errors, kg m/s and kg m^2/s
};

using Points = std::vector<Point>;

/// The points of a case at a time, without runs that diverged before.
std::vector<Point> points_at(const Json& rows, const std::string& case_name, double time);

/// The cheapest point by `cost` with an error of at most `error` m; null if there is none.
const Point* cheapest(const std::vector<Point>& points, double error, double Point::*cost, bool malha_only);

/// The order at which a series' error falls with the sweeps: the median slope of the logarithms between the last
/// neighbouring points whose error still falls. 0 if there are fewer than three such points.
double order_of(const std::vector<Point>& points, const std::string& series);

}  // namespace malha::study
