// SPDX-License-Identifier: Apache-2.0
// Springs and stencils (kernels/projection/stencil.h) of Desbrun's method, made from the constraints of a scene.
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha {

struct ConstraintSet;
struct Model;

struct SpringSet {
  std::string type;               // of the constraints
  std::vector<Edge> ends;         // the two particles of each spring
  std::vector<double> stiffness;  // N/m, of each
  std::vector<double> rest;       // m
};

/// Makes a spring of each constraint. `particles` are two for each, X the rest positions (m). The stiffness is 1 /
/// compliance, or with a rigidity that over the `softness` of the constraint; without either it is the constraint's
/// stiffness times `full` (N/m).
SpringSet springs_of(const ConstraintSpec& spec, double full, const std::vector<int>& particles,
                     const std::vector<double>& softness, const std::vector<Vec3>& X);

/// Gives stencils without compliance one: 1 / (stiffness full lever^2), as of a spring of stiffness times `full` (N/m)
/// that acts through the stencil's lever. Stencils without a lever or stiffness are removed from the set.
void soften_by_levers(ConstraintSet& set, double full, const std::vector<Vec3>& X);

/// The linear part of all stencils of a model, as springs of rest length 0 between all pairs of a stencil's particles,
/// with one spring for each pair: x^T c c^T x / alpha = sum over pairs of -c_i c_j / alpha |x_i - x_j|^2, because the
/// sum of c is 0. Single springs may have a negative stiffness; their sum is positive semidefinite.
SpringSet linear_part(const Model& model);

}  // namespace malha
