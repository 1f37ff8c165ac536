// SPDX-License-Identifier: Apache-2.0
// What Desbrun's method makes of a scene's constraints: springs, and stencils (kernels/projection/stencil.h).
#pragma once
#include <string>
#include <vector>

#include "malha/scene.h"

namespace malha {

struct ConstraintSet;
struct Model;

struct SpringSet {
  std::string type;               // of the constraint
  std::vector<Edge> ends;         // particles
  std::vector<double> stiffness;  // N/m, of each
  std::vector<double> rest;       // m
};

/// One spring a constraint. `particles`: two of each, one after the other. Stiffness: 1 / compliance, with a rigidity
/// that of the constraint's own `softness`; without either, the constraint's stiffness times `full` (N/m).
SpringSet springs_of(const ConstraintSpec& spec, double full, const std::vector<int>& particles,
                     const std::vector<double>& softness, const std::vector<Vec3>& X);

/// The compliance of each of a set of stencils without one: 1 / (stiffness full lever^2), as a spring of that stiffness
/// (N/m) would act through the stencil's lever. What has no lever, or no stiffness, is left out of the set.
void soften_by_levers(ConstraintSet& set, double full, const std::vector<Vec3>& X);

/// The linear part of all stencils of a model, as springs without length between all pairs of a stencil's particles,
/// those of a pair as one: x^T c c^T x / alpha = sum over pairs of -c_i c_j / alpha |x_i - x_j|^2, because the sum of c
/// is 0. Some pull with less than nothing; all together they do not.
SpringSet linear_part(const Model& model);

}  // namespace malha
