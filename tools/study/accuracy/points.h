// SPDX-License-Identifier: Apache-2.0
// What the charts and sentences of the study "accuracy" are made from: a point a method, case and time.
#pragma once
#include <string>
#include <vector>

#include "tools/study/accuracy/methods.h"
#include "tools/study/cells.h"

namespace malha::study {

struct Point {
  std::string series, settings;               // "XPBD, substeps, float", "16x1"
  bool is_malha = true;                       // malha's
  bool variant = false;                       // of the chart of filters alone
  double ms = 0, sweeps = 0;                  // a simulated second
  double error = 0;                           // m, RMS
  double energy = 0;                          // drift, relative
  double strain = 0;                          // RMS error
  double momentum = 0, angular_momentum = 0;  // errors, kg m/s, kg m^2/s
};

using Points = std::vector<Point>;

/// Of one case at one time; runs that diverged before it are left out.
std::vector<Point> points_at(const Json& rows, const std::string& case_name, double time);

/// The cheapest point by `cost` with an error of at most `error` m; null where none is so good.
const Point* cheapest(const std::vector<Point>& points, double error, double Point::*cost, bool malha_only);

/// How the error falls with the sweeps over a series' last points that are still falling: the slope of their
/// logarithms, between neighbours, its median. 1: first order. 0 where fewer than three points fall.
double order_of(const std::vector<Point>& points, const std::string& series);

}  // namespace malha::study
