// SPDX-License-Identifier: Apache-2.0
// The heavy elastica: a clamped strip that bends under its own weight.
#pragma once
#include <vector>

namespace malha::study {

/// A point of the line, in lengths of the strip from the clamp, and how steeply it goes down there, rad.
struct ElasticaPoint {
  double reach, drop, slope;
};

/// The inextensible line that leaves a clamp horizontally and bends under its weight: theta'' + Gamma (1 - s) cos theta
/// = 0, theta(0) = 0, theta'(1) = 0, with Gamma = density g L^3 / D up to 1000, on the branch that falls from the clamp
/// on. Its `points` + 1 points divide it evenly. By shooting from the free end.
std::vector<ElasticaPoint> heavy_elastica(double gamma, int points);

}  // namespace malha::study
