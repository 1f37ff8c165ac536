// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/points.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/bench/medians.h"

namespace malha::study {

std::vector<Point> points_at(const Json& rows, const std::string& case_name, double time) {
  std::vector<Point> points;
  for (const Json& row : rows) {
    if (row["case"] != case_name || row["time_s"] != time || row["rms_error_m"].is_null()) continue;
    points.push_back({row["series"].get<std::string>(), row["settings"].get<std::string>(), row["ours"].get<bool>(),
                      row["variant"].get<bool>(), row["ms_per_s"].get<double>(), row["sweeps_per_s"].get<double>(),
                      row["rms_error_m"].get<double>(), row["energy_drift"].get<double>(),
                      row["rms_strain_error"].get<double>(), row["momentum_error_kg_m_per_s"].get<double>(),
                      row["angular_momentum_error_kg_m2_per_s"].get<double>()});
  }
  return points;
}

const Point* cheapest(const std::vector<Point>& points, double error, double Point::*cost, bool malha_only) {
  const Point* best = nullptr;
  for (const Point& point : points)
    if (point.error <= error && (point.is_malha || !malha_only) && (best == nullptr || point.*cost < best->*cost))
      best = &point;
  return best;
}

double order_of(const std::vector<Point>& points, const std::string& series) {
  std::vector<double> slopes;
  const Point* before = nullptr;
  for (const Point& point : points) {
    if (point.series != series) continue;
    if (before != nullptr && point.error > 0 && point.error < 0.8 * before->error)
      slopes.push_back(std::log(before->error / point.error) / std::log(point.sweeps / before->sweeps));
    before = &point;
  }
  if (slopes.size() < 2) return 0;
  return bench::median({slopes.end() - std::min<std::ptrdiff_t>(3, std::ssize(slopes)), slopes.end()});
}

}  // namespace malha::study
