// SPDX-License-Identifier: Apache-2.0
// Equations of motion of tetrahedra of the stable neo-Hookean material, from its energy (Smith, de Goes, Kim 2018) and
// its first Piola-Kirchhoff stress.
#pragma once
#include <array>
#include <memory>

#include "tools/study/reference/system.h"

namespace malha::study {

/// Energy of a tetrahedron of volume V at rest: V (mu/2 (I - ln(1 + I)) + lambda/2 (J - 1 - 3/4 mu/lambda)^2), I =
/// tr(F^T F), J = det F; mu and lambda such that small strains are those of linear elasticity. 0 at rest.
class TetrahedronSystem : public System {
 public:
  double elastic_energy(const Vector& x) const override;
  void add_forces(const Vector& x, Vector& f) const override;
  Vector strains(const Vector& x) const override;

  struct Element {
    std::array<int, 4> corners;
    Eigen::Matrix3d rest;  // inverse of the matrix whose columns are the edges from corner 0 at rest
    double volume;         // m^3
  };
  std::vector<Element> elements;
  std::vector<Spring> edges;  // without stiffness, only for strains
  double mu = 0, lambda = 0;  // Pa
};

/// The system of a scene whose only body is neo_hookean.
std::unique_ptr<TetrahedronSystem> tetrahedron_system(const Scene& scene);

/// The equilibrium that damped motion from `start` reaches: explicit steps whose velocities are set to zero whenever
/// the kinetic energy falls, until the largest acceleration is below `tolerance` times gravity.
Vector relax_to_rest(const System& system, double tolerance);

}  // namespace malha::study
