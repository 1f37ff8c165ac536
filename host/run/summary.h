// SPDX-License-Identifier: Apache-2.0
// A run in the few lines that a person wants at its end.
#pragma once
#include <string>

#include "host/output/results.h"
#include "malha/simulation.h"

namespace malha {

/// Simulated time, speed, and what there is of strain, volume and contacts; a line each.
std::string summary(const Simulation& simulation);

/// Where the results are that exist; a line each.
std::string list_results(const Results& results);

}  // namespace malha
