// SPDX-License-Identifier: Apache-2.0
// Settings that lie beyond a boundary where a method is known to fail, said before a scene runs. Each line names the
// chart of `malha study stability`, or the page, that shows the boundary.
#pragma once
#include <string>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Lines for people; none: no known boundary is crossed. Takes a look or two at each constraint. `model`: of a
/// scene at its start, or what a Simulation keeps of it.
std::vector<std::string> warnings(const Model& model);

}  // namespace malha
