#include "host/model/elements.h"

#include "host/mesh/topology.h"
#include "host/model/material.h"

namespace malha {

Elements list_elements(Element element, const Mesh& mesh, const std::vector<Edge>& edges, const ConstraintSpec& spec) {
  Elements all;
  const auto add = [&all](const auto& list, const std::vector<double>& softness = {}) {
    for (const auto& one : list) all.particles.insert(all.particles.end(), one.begin(), one.end());
    all.softness.insert(all.softness.end(), softness.begin(), softness.end());
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
        const auto list = plate_hinges(mesh, shares);
        add(list, hinge_softness(mesh, list, shares));
      } else {
        add(hinges(mesh));
      }
      break;
    case Element::Triangles:
      add(triangles(mesh));
      break;
    case Element::Tetrahedra:
      add(mesh.tetrahedra);
      break;
  }
  return all;
}

}  // namespace malha
