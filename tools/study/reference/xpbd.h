// SPDX-License-Identifier: Apache-2.0
// XPBD as its paper prints it, one constraint after the other: what a coloured, data-parallel sweep is compared with.
#pragma once
#include "tools/study/reference/system.h"

namespace malha::study {

/// Macklin, Müller, Chentanez 2016, algorithm 1: a step of h (s) with so many Gauss-Seidel sweeps over the springs in
/// their own order, each of compliance 1 / stiffness (infinite stiffness: 0). A step of one sweep is a substep of
/// Macklin et al. 2019.
void xpbd_step(const SpringSystem& system, double h, int iterations, State& state);

/// A chain of springs from particle to particle, the first one pinned, at rest along `direction` (of length 1) from the
/// origin. `mass`: kg, of each particle; `spacing`: m; `stiffness`: N/m.
SpringSystem chain_system(const std::vector<double>& mass, double spacing, double stiffness,
                          const Eigen::Vector3d& direction, const Eigen::Vector3d& gravity);

/// N: what the pins must give so that the movable particles' momentum changes as it did within a step of h (s). Of any
/// method whose inner forces are equal and opposite it is the pull of the links at the pins.
Eigen::Vector3d support_force(const System& system, const State& before, const State& after, double h);

}  // namespace malha::study
