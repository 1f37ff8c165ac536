// SPDX-License-Identifier: Apache-2.0
// Schema of the constraints in scenes: their kinds and the parameters of each kind.
#pragma once
#include <string>
#include <vector>

namespace malha {

/// The keys of a constraint kind in scenes.
struct ConstraintSchema {
  std::string name;          // "type" in a scene
  std::string parameter;     // key of the kind's parameter
  double parameter_default;  // used if the scene has no value
  double parameter_min;
  bool min_included;       // parameter >= parameter_min, otherwise >
  double parameter_max;    // infinite: no upper bound
  bool accepts_stiffness;  // has the keys "stiffness" and "compliance"
  std::string modulus;     // key of the modulus of a material, required without accepts_stiffness; "": none
  std::string unit;        // of the modulus
  std::string shear;       // key of the modulus in shear or twist beside two moduli; "": the kind has one modulus only
  bool on_edges;           // has the key "elements", which selects among the edges of the mesh
  bool takes_maps;         // has the key "map", and that of the parameter with "_map"
};

/// All kinds of constraints that a body may have, in the order in which messages list them.
const std::vector<ConstraintSchema>& constraint_kinds();

}  // namespace malha
