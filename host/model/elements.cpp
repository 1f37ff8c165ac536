// SPDX-License-Identifier: Apache-2.0
#include "host/model/elements.h"

#include "host/mesh/topology.h"
#include "host/model/material.h"
#include "host/model/winged_triangles.h"

namespace malha {

namespace {

/// Appends elements and their softness.
template <class List>
void add_to(Elements& elements, const List& list, const std::vector<double>& softness) {
  for (const auto& one : list) elements.particles.insert(elements.particles.end(), one.begin(), one.end());
  elements.softness.insert(elements.softness.end(), softness.begin(), softness.end());
}

}  // namespace

ListedElements list_elements(Element element, const Body& body, const ConstraintSpec& spec, double shear) {
  const Mesh& mesh = body.mesh;
  ListedElements listed;
  const auto add = [&listed](const auto& list, const std::vector<double>& softness = {}) {
    add_to(listed.all, list, softness);
  };
  const bool material = spec.rigidity.has_value();
  switch (element) {  // without a default, so that the compiler reports a missing element
    case Element::Edges:
      for (const std::string& on : spec.elements)
        if (on == "shear")
          add(malha::shear(mesh), material ? shear_softness(mesh) : std::vector<double>{});
        else
          add(body.edges, material ? edge_softness(mesh, body.edges, shear) : std::vector<double>{});
      break;
    case Element::Hinges:
      if (material) {
        const PlateHinges of_plate = plate_hinges(mesh, body.boundary.pinned);
        listed.non_manifold = of_plate.non_manifold;
        add(of_plate.list, of_plate.softness);
      } else {
        add(hinges(mesh, &listed.non_manifold));
      }
      break;
    case Element::Triangles:
      add(triangles(mesh));
      break;
    case Element::Tetrahedra:
      add(mesh.tetrahedra);
      break;
    case Element::WingedTriangles: {
      const WingedTriangles winged = winged_triangles(mesh, body.boundary.pinned);
      listed.non_manifold = winged.non_manifold;
      add(winged.list, winged.softness);
      add_to(listed.remainder, winged.hinges, winged.hinge_softness);
      break;
    }
  }
  return listed;
}

}  // namespace malha
