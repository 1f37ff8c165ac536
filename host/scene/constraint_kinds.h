// What a scene file may say about constraints: the kinds, and each kind's own number.
#pragma once
#include <limits>
#include <string>
#include <vector>

namespace malha {

struct ConstraintKind {
  std::string name;          // the "type" in a scene
  std::string parameter;     // the key of the kind's own number
  double parameter_default;  // where the scene does not say
  double parameter_min;
  bool min_included;     // parameter >= parameter_min, rather than >
  bool material;         // takes "rigidity"
  bool on_edges;         // takes "on": which edges of the mesh
  bool hard = false;     // takes neither stiffness nor compliance
  bool elastic = false;  // takes "young_modulus", and nothing else that says how stiff
  double parameter_max = std::numeric_limits<double>::infinity();
};

/// Every kind that a body may name, in the order in which messages list them.
const std::vector<ConstraintKind>& constraint_kinds();

}  // namespace malha
