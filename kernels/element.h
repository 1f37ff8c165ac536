// What of a mesh a constraint can stand on: one table, which scenes, messages, benchmarks and tests read.
// A new element is a line here and its list in host/model/elements.cpp.
#pragma once

namespace malha {

enum class Element { Edges, Hinges, Triangles, Tetrahedra };

struct ElementFacts {
  int particles;       // of one
  const char* one;     // "hinge", in tables
  const char* needed;  // which meshes have any, in messages
  bool solid;          // of the inside of a body, rather than of its surface
};

/// By the element's place in the enumeration.
inline constexpr ElementFacts kElements[] = {
    {2, "edge", "edges, or quads for shear", false},
    {4, "hinge", "a mesh with neighbouring faces", false},
    {3, "triangle", "a mesh with faces", false},
    {4, "tetrahedron", "a mesh of tetrahedra: tet_box, .mesh, .msh, .node and .ele", true},
};

constexpr ElementFacts facts_of(Element element) { return kElements[static_cast<int>(element)]; }

}  // namespace malha
