// SPDX-License-Identifier: Apache-2.0
// Constraints C(x) = 0 that the caller evaluates, for trying an idea before it becomes a kernel. They are slow: each
// batch is copied out, evaluated by a function of the caller, and copied back.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Constraints that share no particle, evaluated in one call. Each has k = UserConstraint::arity particles.
struct UserBatch {
  int count;         ///< number of constraints
  const Vec3* x;     ///< positions, m; count * k, in the order of each constraint's particles
  const int* index;  ///< number of each constraint: particles[index * k] of UserConstraint is its first particle
  double* C;         ///< output: count values
  Vec3* gradient;    ///< output: dC/dx, count * k vectors
};

struct UserConstraint {
  std::string name = "user";   ///< name in messages
  int arity = 2;               ///< k, the number of particles of each constraint
  std::vector<int> particles;  ///< k distinct particles for each constraint, as indices into positions() at the start
  double compliance = 0;       ///< alpha of XPBD, >= 0; C^2 / (2 alpha) is the energy in J
  /// Fills C and gradient of a batch. The thread that calls step() calls it, one batch at a time: at the start of each
  /// substep, and once or twice in each iteration. It must depend on its arguments alone, or equal runs differ.
  std::function<void(const UserBatch&)> evaluate;
};

/// Compares the gradients with central differences of C at the positions x (m, in the order of
/// Simulation::positions()). Throws InputError, which names the constraint, for a gradient that differs by more than
/// `tolerance` times the constraint's largest.
void check_gradients(const UserConstraint& constraint, const std::vector<Vec3>& x, double tolerance = 1e-4);

}  // namespace malha
