// SPDX-License-Identifier: Apache-2.0
// Elements of a body's mesh on which constraints act: edges, hinges, triangles ... (kernels/projection/element.h).
#pragma once
#include <vector>

#include "host/model/body.h"
#include "kernels/projection/element.h"

namespace malha {

struct Elements {
  std::vector<int> particles;  // facts_of(element).particles for each element, in the body's numbering
  // Of a material, for each element its compliance times the modulus; empty for constraints with stiffness or
  // compliance.
  std::vector<double> softness;
};

struct ListedElements {
  Elements all;
  /// The rest of the mesh, for the Remainder of the constraint kind: for winged triangles it has the hinges that belong
  /// to none of them, with their softness. For other elements it is empty.
  Elements remainder;
  int non_manifold = 0;  // number of edges with more than two triangles, which have no hinge
};

/// Lists the elements of the body's mesh for a constraint. `spec.elements` selects among edges; `spec.rigidity` is that
/// of the material. `shear` is the rigidity of the diagonals of quads over that of the edges, see edge_softness().
ListedElements list_elements(Element element, const Body& body, const ConstraintSpec& spec, double shear);

}  // namespace malha
