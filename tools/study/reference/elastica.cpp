// SPDX-License-Identifier: Apache-2.0
#include "tools/study/reference/elastica.h"

#include <cmath>

namespace malha::study {

std::vector<ElasticaPoint> heavy_elastica(double gamma, int points) {
  const int parts = (4000 + points - 1) / points, n = points * parts;  // errors of 1e-5 at a Gamma of 1000
  double low = 0, high = std::acos(0.0);                               // slope at the free end
  std::vector<ElasticaPoint> line(points + 1);
  for (int pass = 0; pass < 60; ++pass) {
    double theta = (low + high) / 2, bend = 0, reach = 0, drop = 0;
    line[points] = {0, 0, theta};
    for (int k = 0; k < n && theta >= 0; ++k) {  // the midpoint rule; a line that rises has bent too much
      const double half = theta + bend / (2 * n);
      bend -= gamma * ((k + 0.5) / n) * std::cos(half) / n;
      reach += std::cos(half) / n, drop += std::sin(half) / n, theta = half + bend / (2 * n);
      if ((k + 1) % parts == 0) line[points - (k + 1) / parts] = {reach, drop, theta};
    }
    (theta < 0 ? low : high) = (low + high) / 2;
  }
  const ElasticaPoint clamp = line.front();
  for (ElasticaPoint& point : line) point.reach = clamp.reach - point.reach, point.drop = clamp.drop - point.drop;
  return line;
}

}  // namespace malha::study
