// SPDX-License-Identifier: Apache-2.0
// XPBD as printed in its paper, one constraint after the other: the reference for malha's coloured, data-parallel
// sweep.
#pragma once
#include "tools/study/reference/system.h"

namespace malha::study {

/// Macklin, Müller, Chentanez 2016, algorithm 1: a step of h (s) with `iterations` Gauss-Seidel sweeps over the springs
/// in the order of their list, each with compliance 1 / stiffness (0 for infinite stiffness). A step of one sweep is a
/// substep of Macklin et al. 2019.
void xpbd_step(const SpringSystem& system, double h, int iterations, State& state);

/// A chain of springs from particle to particle, the first one pinned, at rest along `direction` (of length 1) from the
/// origin. `mass`: kg, of each particle; `spacing`: m; `stiffness`: N/m.
SpringSystem chain_system(const std::vector<double>& mass, double spacing, double stiffness,
                          const Eigen::Vector3d& direction, const Eigen::Vector3d& gravity);

/// The force (N) of the pins that explains the momentum change of the movable particles in a step of h (s). For a
/// method whose internal forces are equal and opposite it is the force of the links at the pins.
Eigen::Vector3d support_force(const System& system, const State& before, const State& after, double h);

}  // namespace malha::study
