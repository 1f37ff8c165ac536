// SPDX-License-Identifier: Apache-2.0
// A constraint of the caller's own, C(x) = 0, as a function that is called for batches: to try an idea before it
// becomes a kernel. Slow: each batch is copied out, evaluated by the caller, and copied back.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// Constraints that share no particle, to be evaluated at once.
struct UserBatch {
  int count;         ///< of constraints
  const Vec3* x;     ///< m; k a constraint, in the order of its particles
  const int* index;  ///< of each: its place in UserConstraint::particles, divided by k
  double* C;         ///< to be filled, one a constraint
  Vec3* gradient;    ///< to be filled with dC/dx, k a constraint
};

struct UserConstraint {
  std::string name = "user";   ///< for messages
  int arity = 2;               ///< k: particles of each
  std::vector<int> particles;  ///< k a constraint, different ones; numbered as in Simulation::positions() at the start
  double compliance = 0;       ///< >= 0, XPBD's alpha: C^2 / (2 alpha) is an energy in J
  // Called by the thread that steps, never by two at once: for each batch where a substep begins, and once or twice in
  // each of its iterations. It must depend on its arguments alone, or runs differ.
  std::function<void(const UserBatch&)> evaluate;
};

/// Compares the gradients with central differences of C at these places (m, as in Simulation::positions()). Throws
/// InputError where one is off by more than `tolerance` times the constraint's largest, and says which.
void check_gradients(const UserConstraint& constraint, const std::vector<Vec3>& x, double tolerance = 1e-4);

}  // namespace malha
