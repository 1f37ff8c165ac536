// SPDX-License-Identifier: Apache-2.0
// The linear system behind Desbrun's filter: A = M - dt^2 H over the movable particles that springs hold, where
// H_ij = k_ij and H_ii = -sum_j k_ij (Desbrun, Schröder, Barr 1999, section 3.2). S = A^-1, and W = m S. Of stencils
// (kernels/projection/stencil.h) H has the linear part.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Particles that springs connect, directly or through others: A has no entry between two blocks.
struct SystemBlock {
  int first, count;  // unknowns
  bool free;         // no spring to a pinned particle: A has the constant vector as its softest mode, of the mass alone
  double mass;       // kg
};

/// A symmetric positive definite matrix. Unknowns are block after block, within each in the solver's order.
struct SpringSystem {
  std::vector<int> particle;  // of each unknown
  std::vector<SystemBlock> blocks;
  std::vector<double> mass;      // kg, of each unknown
  std::vector<double> diagonal;  // kg
  std::vector<int> begin;        // of each row's other entries, both triangles, columns ascending; and one more
  std::vector<int> column;
  std::vector<double> value;
  int count() const { return static_cast<int>(particle.size()); }
};

/// The linear part of all stencils of a model, as springs of rest length 0 between all pairs of a stencil's particles,
/// with one spring for each pair: x^T c c^T x / alpha = sum over pairs of -c_i c_j / alpha |x_i - x_j|^2, because the
/// sum of c is 0. Single springs may have a negative stiffness; their sum is positive semidefinite.
SpringSet linear_part(const Model& model);

/// `dt`: s, of a substep. `w`: inverse masses, 1/kg, in the solver's order; 0 for pinned particles. Without them, those
/// of the model.
SpringSystem spring_system(const Model& model, double dt, const std::vector<double>& w);
inline SpringSystem spring_system(const Model& model, double dt) { return spring_system(model, dt, model.w); }

/// y = A x for three right-hand sides.
std::vector<double> multiply(const SpringSystem& system, const std::vector<double>& x);

/// Throws InputError at a particle (the solver's order) whose pivot is only rounding errors. If one constraint is so
/// much stiffer than the others that it costs them their digits, as those of flat triangles, the message names it;
/// otherwise the step is too long for all of them.
[[noreturn]] void refuse_singular(const Model& model, int particle);

}  // namespace malha
