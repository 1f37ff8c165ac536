// SPDX-License-Identifier: Apache-2.0
// Warnings of bodies that a run has stretched by more than their compliance explains.
#pragma once
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha {

/// Returns a warning for each body whose `distance` constraints had at some time an RMS strain of more than a tenth, of
/// which their compliance explains less. The substeps that a load needs are known only once it has acted. It covers
/// Position Based Dynamics alone. Bodies that are meant to stretch are left out: those with a stiffness below 1, those
/// that a pressure inflates, and those that tear.
std::vector<std::string> overstretch_warnings(const Simulation& simulation);

}  // namespace malha
