// SPDX-License-Identifier: Apache-2.0
// Equations of motion with which the studies compare malha.
#include <gtest/gtest.h>

#include <cmath>

#include "tools/study/reference/tetrahedra.h"

namespace malha::study {
namespace {

TEST(StudyReference, ForcesAreNegativeGradientsOfEnergies) {
  BodySpec body;
  body.name = "body", body.mass = 1, body.shape = TetBoxShape{{1, 1, 1}, {1, 1, 1}};
  Scene scene;
  scene.name = "body", scene.bodies = {body};
  ConstraintSpec material, springs, bending;
  material.type = "neo_hookean", material.young_modulus = 100, material.parameter = 0.3;
  springs.type = "distance", springs.elements = {"edges"}, springs.compliance = 0.01;
  bending.type = "bending", bending.rigidity = 20;
  for (const std::string kind : {"springs", "tetrahedra", "bending"}) {
    scene.bodies[0].constraints = {kind == "tetrahedra" ? material : springs};
    if (kind == "bending") {
      scene.bodies[0].shape = GridShape{{1, 0.8}, {3, 2}};
      scene.bodies[0].constraints.push_back(bending);
    }
    std::unique_ptr<System> system;
    if (kind == "tetrahedra")
      system = tetrahedron_system(scene);
    else
      system = spring_system(scene);
    Vector x = system->start.x;
    EXPECT_NEAR(system->elastic_energy(x), 0, 1e-12);
    EXPECT_LT(system->accelerations(x).norm(), 1e-9) << "at rest";
    for (int k = 0; k < x.size(); ++k) x[k] += 0.1 * std::sin(3.0 * k);
    Vector f = Vector::Zero(x.size());
    system->add_forces(x, f);
    constexpr double h = 1e-6;
    for (int k = 0; k < x.size(); ++k) {
      const Vector d = h * Vector::Unit(x.size(), k);
      EXPECT_NEAR(f[k], (system->elastic_energy(x - d) - system->elastic_energy(x + d)) / (2 * h), 1e-6) << k;
    }
  }
}

TEST(StudyReference, FindsTheLargestFrequencyOfAChain) {
  BodySpec body;
  body.name = "chain", body.mass = 10, body.shape = ChainShape{{0, 0, 0}, {1, 0, 0}, 10},
  body.pins = {ListPin{{0, 10}}};
  ConstraintSpec springs;
  springs.type = "distance", springs.elements = {"edges"}, springs.compliance = 0.01;
  body.constraints = {springs};
  Scene scene;
  scene.name = "chain", scene.bodies = {body};
  const auto system = spring_system(scene);  // masses of 1 kg between the ends
  constexpr double pi = 3.14159265358979323846;
  EXPECT_NEAR(largest_frequency(*system, system->start.x), 2 * 10 * std::sin(9 * pi / 20), 0.01);
}

}  // namespace
}  // namespace malha::study
