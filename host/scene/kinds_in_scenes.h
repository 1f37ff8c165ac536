// SPDX-License-Identifier: Apache-2.0
// What a scene file may say about constraints: the kinds, and each kind's own number.
#pragma once
#include <string>
#include <vector>

namespace malha {

struct ConstraintSchema {
  std::string name;          // the "type" in a scene
  std::string parameter;     // the key of the kind's own number
  double parameter_default;  // where the scene does not say
  double parameter_min;
  bool min_included;     // parameter >= parameter_min, rather than >
  double parameter_max;  // infinite: none
  bool free;             // takes "stiffness" or "compliance"
  std::string modulus;   // the key of a material's modulus; where the kind is not free it is required. "": none
  std::string unit;      // of the modulus
  bool on_edges;         // takes "elements": which edges of the mesh
};

/// Every kind that a body may name, in the order in which messages list them.
const std::vector<ConstraintSchema>& constraint_kinds();

}  // namespace malha
