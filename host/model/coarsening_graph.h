// SPDX-License-Identifier: Apache-2.0
// What levels carry of a model: what keeps its particles from moving apart, and how far its weight stretches that.
#pragma once
#include <vector>

#include "host/model/rest_graph.h"

namespace malha {

struct Model;

/// A connected part of what pulls.
struct LinkedPart {
  int particles = 0;
  int longest = 0;       // links on the way from the farthest particle to the nearest one that is held
  bool solid = false;    // of tetrahedra
  bool elastic = false;  // its links have compliances
  bool soft = false;     // a sweep leaves a part of their errors: stiffness below 1
  bool loaded = false;   // more than weight may stretch it at rest: contacts, pins that move
  double stretch = 0;    // of such ones: the mean strain by which its weight stretches it at rest; 0: nothing hangs
  double lost = 0;       // h^2 (w_a + w_b) / alpha, the mean: above 1 a sweep of a substep loses the compliance
};

struct Linkage {
  std::vector<Link> links;   // in the user's numbers
  std::vector<Vector> give;  // of each particle (see stretch_by_weight()); empty: nothing is elastic
  std::vector<int> part;     // of each particle
  std::vector<LinkedPart> parts;
};

/// `w`: of the model's particles now, 1/kg, 0 where they are held. Constraints that are much softer than others of
/// their part do not count.
Linkage linkage_of(const Model& model, const std::vector<double>& w);

}  // namespace malha
