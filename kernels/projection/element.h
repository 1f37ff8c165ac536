// SPDX-License-Identifier: Apache-2.0
// Mesh elements that constraints are built on: one table for scenes, messages, benchmarks and tests.
// A new element needs a line here and its list in host/model/build_constraints.cpp.
#pragma once
#include "kernels/parallel/compute.h"

namespace malha {

enum class Element { Edges, Hinges, Triangles, Tetrahedra, WingedTriangles };

struct ElementFacts {
  int particles;       // per element
  const char* one;     // its name in tables, such as "hinge"
  const char* needed;  // which meshes have any, for messages
  bool solid;          // fills the inside of a body, rather than its surface
  bool weighed;        // its list has a weight for each element, whatever the kind
};

KERNEL constexpr ElementFacts facts_of(Element element) {
  const ElementFacts by_element[] = {
      // in the order of the enumeration
      {2, "edge", "edges, or quads for shear", false, false},
      {4, "hinge", "a mesh with neighbouring faces", false, false},
      {3, "triangle", "a mesh with faces", false, false},
      {4, "tetrahedron", "a mesh of tetrahedra: tet_box, .mesh, .msh, .node and .ele", true, false},
      {6, "triangle", "a mesh with neighbouring faces", false, true},
  };
  return by_element[static_cast<int>(element)];
}

}  // namespace malha
