// SPDX-License-Identifier: Apache-2.0
// Tetrahedra of the stable neo-Hookean material as plain equations of motion, from its energy (Smith, de Goes, Kim
// 2018) and its first Piola-Kirchhoff stress alone.
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
    Eigen::Matrix3d rest;  // inverse of the edges from corner 0, as columns, at rest
    double volume;         // m^3
  };
  std::vector<Element> elements;
  std::vector<Spring> edges;  // without stiffness: for strains
  double mu = 0, lambda = 0;  // Pa
};

/// Of a scene whose only body is neo_hookean.
std::unique_ptr<TetrahedronSystem> tetrahedron_system(const Scene& scene);

/// Where damped motion ends: particles that come to rest from `start`, by explicit steps whose velocities are dropped
/// whenever the kinetic energy falls, until the largest acceleration is below `enough` of gravity's.
Vector relax_to_rest(const System& system, double tolerance);

}  // namespace malha::study
