// SPDX-License-Identifier: Apache-2.0
// What looks make of a model, in the user's numbers: they keep nothing of it.
#pragma once
#include <cstddef>
#include <vector>

#include "host/model/model.h"
#include "host/model/tangent.h"
#include "malha/mesh.h"

namespace malha {

/// `particles`: of the solver.
std::vector<int> in_user_numbers(const Model& model, const int* particles, std::size_t count);

/// Throws std::invalid_argument for another number of particles than those that a look was made for.
void require_particles(std::size_t found, std::size_t allowed);

/// A body with pressure.
struct Shell {
  Shell(const Model& model, const PressureSet& set);
  /// V - V0 (m^3) at x (m), and its gradient (m^2) at each of `particles`.
  double evaluate(const std::vector<Vec3>& x, std::vector<Vector3<double>>& gradient) const;

  std::vector<int> particles;
  std::vector<Triangle> triangles;  // by places in `particles`
  double target = 0;                // V0
};

}  // namespace malha
