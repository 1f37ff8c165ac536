// SPDX-License-Identifier: Apache-2.0
// Warnings of settings beyond a known failure boundary of a method, before a scene runs. Each line names the chart of
// `malha study stability`, or the page, that shows the boundary.
#pragma once
#include <string>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Returns one warning a line; none if no known boundary is crossed. It passes over all constraints once or twice.
/// `model`: of a scene at its start, or the one that a Simulation keeps.
std::vector<std::string> warnings(const Model& model);

}  // namespace malha
