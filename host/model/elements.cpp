#include "host/model/elements.h"

#include "host/mesh/topology.h"
#include "host/model/material.h"
#include "host/model/winged_triangles.h"

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
    case Element::WingedTriangles: {
      const WingedTriangles winged = winged_triangles(mesh);
      add(winged.list, winged.softness);
      break;
    }
  }
  return all;
}

Elements list_remainder(Element element, const Mesh& mesh) {
  Elements all;
  if (element != Element::WingedTriangles) return all;
  WingedTriangles winged = winged_triangles(mesh);
  for (const auto& hinge : winged.hinges) all.particles.insert(all.particles.end(), hinge.begin(), hinge.end());
  all.softness = std::move(winged.hinge_softness);
  return all;
}

}  // namespace malha
