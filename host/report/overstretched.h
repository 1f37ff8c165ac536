// SPDX-License-Identifier: Apache-2.0
// The warning of bodies that a run stretched by more than their own elasticity explains.
#pragma once
#include <string>
#include <vector>

#include "malha/simulation.h"

namespace malha {

/// A warning for each body whose `distance` constraints were at some time longer or shorter than was asked for by more
/// than a tenth, RMS, of which their compliance explains less: what a load asks of the substeps is known when it has
/// acted. Of Position Based Dynamics. Bodies that are to stretch are left out: by a stiffness below 1, by a pressure
/// that blows them up, and those that tear.
std::vector<std::string> overstretched(const Simulation& simulation);

}  // namespace malha
