// SPDX-License-Identifier: Apache-2.0
// Parts of a model in the user's order, for visual fields.
#pragma once
#include <cstddef>
#include <vector>

#include "host/model/model.h"
#include "host/model/rest_graph.h"
#include "malha/mesh.h"

namespace malha {

/// Maps `particles` from the solver's order to the user's.
std::vector<int> to_user_indices(const Model& model, const int* particles, std::size_t count);

/// Throws std::invalid_argument for another number of particles than the field was made for.
void require_particles(std::size_t found, std::size_t allowed);

/// Closed surface of a body with pressure.
struct ClosedSurface {
  ClosedSurface(const Model& model, const PressureSet& set);
  /// Returns V - V0 (m^3) at x (m), and its gradient (m^2) at each of `particles`.
  double evaluate(const std::vector<Vec3>& x, std::vector<Vector3<double>>& gradient) const;

  std::vector<int> particles;
  std::vector<Triangle> triangles;  // indices in `particles`
  double target = 0;                // V0, m^3
};

}  // namespace malha
