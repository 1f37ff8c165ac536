// SPDX-License-Identifier: Apache-2.0
// The graph that levels coarsen: the links that keep the particles of a model together, its connected components, and
// their static stretch.
#pragma once
#include <vector>

#include "host/model/rest_graph.h"

namespace malha {

struct Model;

/// A connected component of the links.
struct GraphComponent {
  int particles = 0;
  int max_graph_distance = 0;  // links between the farthest particle and its nearest pinned one
  bool solid = false;          // it consists of tetrahedra
  bool elastic = false;        // its links have compliances
  bool soft = false;           // stiffness below 1: a sweep leaves a part of the error
  bool loaded = false;         // contacts or moving pins may stretch it too, not only its weight
  double stretch = 0;          // mean static strain by its weight, if it is elastic; 0: it is not suspended
  double compliance_loss = 0;  // mean of h^2 (w_a + w_b) / alpha; above 1 a sweep of a substep loses the compliance
};

struct CoarseningGraph {
  std::vector<Link> links;      // in the user's numbering
  std::vector<Vector> stretch;  // of each particle, by its weight (coarsening_graph.cpp); empty: no part is elastic
  std::vector<int> part;        // component of each particle
  std::vector<GraphComponent> parts;
};

/// Builds the graph of a model. `w` are the present inverse masses (1/kg) in the solver's order, 0 for pinned
/// particles. Constraints that are much softer than others of their component are left out.
CoarseningGraph coarsening_graph(const Model& model, const std::vector<double>& w);

}  // namespace malha
