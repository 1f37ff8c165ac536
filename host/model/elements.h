// SPDX-License-Identifier: Apache-2.0
// The lists behind the table of elements (kernels/projection/element.h): what of a body's mesh a constraint stands on.
#pragma once
#include <vector>

#include "host/model/body.h"
#include "kernels/projection/element.h"

namespace malha {

struct Elements {
  std::vector<int> particles;  // in the body's own numbering, facts_of(element).particles each
  std::vector<double>
      softness;  // of a material beside stiffness and compliance: of each its compliance times the modulus
};

struct ListedElements {
  Elements all;
  /// What of the mesh no such element covers, for the kind's Remainder: of winged triangles the hinges at the rim that
  /// none of them has, with their softness. Of other elements nothing.
  Elements remainder;
  int crowded = 0;  // edges of more than two triangles, where what bends has no hinge
};

/// Of the body's mesh. `spec.elements`: which of the edges; a rigidity is that of the material. `shear`: of a body's
/// diagonals, over that of its edges (edge_softness).
ListedElements list_elements(Element element, const Body& body, const ConstraintSpec& spec, double shear);

}  // namespace malha
