// SPDX-License-Identifier: Apache-2.0
// Elastic catenary in closed form.
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha::study {

/// The elastic catenary (Irvine, Cable Structures, 1981, section 1.3) between (0, 0) and (span, 0): positions (m, z =
/// 0) of the `points` + 1 points that divide a line of unstretched `length` (m), total `weight` (N) and stiffness EA
/// (N) evenly.
std::vector<Vec3> elastic_catenary(double span, double length, double weight, double EA, int points);

}  // namespace malha::study
