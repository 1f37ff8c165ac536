// SPDX-License-Identifier: Apache-2.0
// What of a mesh a constraint can stand on: one table, which scenes, messages, benchmarks and tests read.
// A new element is a line here and its list in host/model/elements.cpp.
#pragma once
#include "kernels/parallel/compute.h"

namespace malha {

enum class Element { Edges, Hinges, Triangles, Tetrahedra, WingedTriangles };

struct ElementFacts {
  int particles;       // of one
  const char* one;     // "hinge", in tables
  const char* needed;  // which meshes have any, in messages
  bool solid;          // of the inside of a body, rather than of its surface
  bool weighed;        // its list says how much each one counts, whatever the kind
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
