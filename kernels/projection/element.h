// SPDX-License-Identifier: Apache-2.0
// Elements that constraints are built on, parts of a mesh or pairs of a seam: one table for scenes, messages,
// benchmarks and tests. A new element of a mesh needs a line here and its list in host/model/build_constraints.cpp.
#pragma once
#include "kernels/parallel/compute.h"

namespace malha {

enum class Element { Edges, Hinges, Triangles, Tetrahedra, WingedTriangles, SewnPairs, AttachedPoints };

struct ElementFacts {
  int particles;       // per element
  const char* one;     // its name in tables, such as "hinge"
  const char* needed;  // which meshes have any, for messages
  bool solid;          // fills the inside of a body, rather than its surface
  bool weighed;        // its list has a weight for each element, whatever the kind
  bool sewn = false;   // of the scene's seams, instead of a body's mesh
};

KERNEL constexpr ElementFacts facts_of(Element element) {
  const ElementFacts by_element[] = {
      // in the order of the enumeration
      {2, "edge", "edges, or quads for shear", false, false},
      {4, "hinge", "a mesh with neighbouring faces", false, false},
      {3, "triangle", "a mesh with faces", false, false},
      {4, "tetrahedron", "a mesh of tetrahedra: tet_box, .mesh, .msh, .node and .ele", true, false},
      {6, "triangle", "a mesh with neighbouring faces", false, true},
      {2, "pair", "seams", false, false, true},
      {4, "particle", "seams to a surface", false, false, true},
  };
  return by_element[static_cast<int>(element)];
}

}  // namespace malha
