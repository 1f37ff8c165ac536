// The lists behind the table of elements (kernels/element.h): what of a body's mesh a constraint stands on.
#pragma once
#include <vector>

#include "host/mesh.h"
#include "host/scene.h"
#include "kernels/element.h"

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

/// `edges`: of the mesh. `spec.on`: which of the edges; a rigidity is that of the material.
ListedElements list_elements(Element element, const Mesh& mesh, const std::vector<Edge>& edges,
                             const ConstraintSpec& spec);

}  // namespace malha
