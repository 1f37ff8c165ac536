// SPDX-License-Identifier: Apache-2.0
// Constraints of the caller's own, sorted into batches that share no particle, and one projection of such a batch.
#pragma once
#include <vector>

#include "malha/user_constraint.h"

namespace malha {

/// In the order of their batches.
struct UserBatches {
  std::vector<int> begin;  // of each batch, and one more: the number of constraints
  std::vector<int> index;  // of each constraint, as the caller counts them
  std::vector<int> list;   // its particles, the solver's numbers, k a constraint
  int count() const { return static_cast<int>(begin.size()) - 1; }
};

/// Throws InputError for constraints that no model of so many particles can have.
void require_sound(const UserConstraint& constraint, int particles);

/// `solver_of`: the solver's number of each of the user's particles. Pinned ones count: a pin may be let go.
UserBatches make_batches(const UserConstraint& constraint, const std::vector<int>& solver_of);

/// Calls the function, and throws InputError where it gives what is no number.
void evaluate(const UserConstraint& constraint, const UserBatch& batch);

/// One projection of a batch in a substep of h seconds (XPBD, along the gradients at `start`:
/// kernels/projection/direction.h). `x`: its places (m), moved here; `start`: those where the substep began, `along`:
/// gradients there. `w`: inverse masses (1/kg), likewise k a constraint. `lambda`: of each constraint, 0 in a substep's
/// first iteration.
void project(const UserConstraint& constraint, int count, const int* number, double h, const double* w, double* lambda,
             const Vec3* start, const Vec3* along, Vec3* x);

}  // namespace malha
