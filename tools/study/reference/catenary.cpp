// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/catenary.h"

#include <cmath>

namespace malha::study {

namespace {

/// The position of the point at s m along the unstretched line, under the horizontal force H.
Vec3 place(double s, double H, double length, double weight, double EA) {
  const double V = weight / 2, below = V - weight * s / length;  // vertical force at the start and at s
  const double a = H * length / weight;
  return {H * s / EA + a * (std::asinh(V / H) - std::asinh(below / H)),
          -weight * s / EA * (V / weight - s / (2 * length)) - a * (std::hypot(1, V / H) - std::hypot(1, below / H)),
          0};
}

}  // namespace

std::vector<Vec3> elastic_catenary(double span, double length, double weight, double EA, int points) {
  double low = 1e-9 * weight, high = 1e9 * weight;  // the span grows with the force
  for (int turn = 0; turn < 200; ++turn) {
    const double middle = std::sqrt(low * high);
    (place(length, middle, length, weight, EA)[0] < span ? low : high) = middle;
  }
  std::vector<Vec3> all;
  for (int k = 0; k <= points; ++k) all.push_back(place(length * k / points, low, length, weight, EA));
  return all;
}

}  // namespace malha::study
