// The springs of Desbrun's method that stand for a scene's constraints.
#pragma once
#include <string>
#include <vector>

#include "host/scene.h"

namespace malha {

struct SpringSet {
  std::string type;               // of the constraint
  std::vector<Edge> ends;         // particles
  std::vector<double> stiffness;  // N/m, of each
  std::vector<double> rest;       // m
};

/// One spring a constraint. `particles`: of all of them one after the other, two of a distance, four of a bending
/// constraint, whose spring spans the hinge from wing to wing. Stiffness: 1 / compliance, with a rigidity that of the
/// constraint's own `softness`; without either, the constraint's stiffness times `full` (N/m). A bending compliance
/// (rad/(N m)) acts through the heights h of the two wings as its levers: k = 4 / (compliance (h1 + h2)^2).
SpringSet springs_of(const ConstraintSpec& spec, double full, const std::vector<int>& particles,
                     const std::vector<double>& softness, const std::vector<Vec3>& X);

}  // namespace malha
