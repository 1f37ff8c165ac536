// SPDX-License-Identifier: Apache-2.0
// Scenes of malha bench self: sliding layers, measured for any length of time, and motions from start to end.
#pragma once
#include <vector>

#include "malha/scene.h"

namespace malha::bench {

struct SelfCase {
  const char* name;
  const char* what;    // description in the table's legend
  std::vector<int> n;  // default numbers of particles, approximately
  int steps;           // length of the motion; 0: any number
  Scene (*scene)(int n);
};

/// The cloth of Müller et al. 2006, figure 6: 44 x 31 particles, 2 cm apart, if n is 1,364; finer with more. It falls
/// in frames of 1/30 s over a ball, or on edge onto the ground, where it folds to a heap.
Scene cloth_of_2006(int n, bool drapes, int substeps);

/// Four sliding sheets, a heap, a cloth over a ball, a twisted and a crumpled cloth, two balls, and fifty layers.
const std::vector<SelfCase>& self_cases();

}  // namespace malha::bench
