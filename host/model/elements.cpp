#include "host/model/elements.h"

#include "host/mesh/topology.h"
#include "host/model/material.h"
#include "host/model/winged_triangles.h"

namespace malha {

namespace {

/// Appends what a list holds, and its softness.
template <class List>
void add_to(Elements& elements, const List& list, const std::vector<double>& softness) {
  for (const auto& one : list) elements.particles.insert(elements.particles.end(), one.begin(), one.end());
  elements.softness.insert(elements.softness.end(), softness.begin(), softness.end());
}

}  // namespace

ListedElements list_elements(Element element, const Mesh& mesh, const std::vector<Edge>& edges,
                             const ConstraintSpec& spec) {
  ListedElements listed;
  const auto add = [&listed](const auto& list, const std::vector<double>& softness = {}) {
    add_to(listed.all, list, softness);
  };
  const bool material = spec.rigidity.has_value();
  switch (element) {  // without a default: the compiler names the element that is missing
    case Element::Edges:
      for (const std::string& on : spec.on)
        if (on == "shear")
          add(shear(mesh), material ? shear_softness(mesh) : std::vector<double>{});
        else
          add(edges, material ? edge_softness(mesh, edges) : std::vector<double>{});
      break;
    case Element::Hinges:
      if (material) {
        std::vector<double> shares;
        const auto list = plate_hinges(mesh, shares, &listed.crowded);
        add(list, hinge_softness(mesh, list, shares));
      } else {
        add(hinges(mesh, &listed.crowded));
      }
      break;
    case Element::Triangles:
      add(triangles(mesh));
      break;
    case Element::Tetrahedra:
      add(mesh.tetrahedra);
      break;
    case Element::WingedTriangles: {
      const WingedTriangles winged = winged_triangles(mesh);
      listed.crowded = winged.crowded;
      add(winged.list, winged.softness);
      add_to(listed.remainder, winged.hinges, winged.hinge_softness);
      break;
    }
  }
  return listed;
}

}  // namespace malha
