// SPDX-License-Identifier: Apache-2.0
// The summary of a run for the terminal.
#pragma once
#include <string>

#include "host/output/results.h"
#include "malha/simulation.h"

namespace malha {

/// Returns lines with simulated time, speed, and strain, volume and contacts where the scene has them.
std::string summary(const Simulation& simulation);

/// Returns a line with the path of each result that exists.
std::string list_results(const Results& results);

}  // namespace malha
