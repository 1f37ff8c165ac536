// SPDX-License-Identifier: Apache-2.0
// Scenes built in code, for tests: small, valid, and with nothing in them that was not asked for.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "malha/scene.h"

namespace malha {

inline ConstraintSpec constraint(const std::string& type, double parameter = 1) {
  ConstraintSpec spec;
  spec.type = type;
  spec.parameter = parameter;
  if (type == "distance" || type == "distance_limit") spec.elements = {"edges"};
  return spec;
}

inline ConstraintSpec with_compliance(const std::string& type, double compliance, double parameter = 1) {
  ConstraintSpec spec = constraint(type, parameter);
  spec.compliance = compliance;
  return spec;
}

inline ConstraintSpec neo_hookean(double young_modulus, double poisson_ratio) {
  ConstraintSpec spec = constraint("neo_hookean", poisson_ratio);
  spec.young_modulus = young_modulus;
  return spec;
}

/// A body of one kilogram.
inline BodySpec body(const std::string& name, const Shape& shape, std::vector<ConstraintSpec> constraints = {}) {
  BodySpec spec;
  spec.name = name;
  spec.shape = shape;
  spec.mass = 1;
  spec.constraints = std::move(constraints);
  return spec;
}

inline EnvironmentSpec obstacle(const std::string& name, const Shape& shape, Sides sides = Sides::Solid) {
  EnvironmentSpec spec;
  spec.name = name;
  spec.shape = shape;
  spec.sides = sides;
  return spec;
}

/// No gravity, no environment, float, ten substeps.
inline Scene scene_of(std::vector<BodySpec> bodies, std::vector<EnvironmentSpec> environment = {}) {
  Scene scene;
  scene.file = "test.json";
  scene.name = "test";
  scene.bodies = std::move(bodies);
  scene.environment = std::move(environment);
  return scene;
}

}  // namespace malha
