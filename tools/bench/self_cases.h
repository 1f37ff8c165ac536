// What malha bench self measures: layers that slide for as long as one likes, and motions from start to end.
#pragma once
#include <string>
#include <vector>

#include "host/scene.h"

namespace malha::bench {

struct SelfCase {
  const char* name;
  const char* what;    // in a line of the table's legend
  std::vector<int> n;  // particles, about, where none are asked for
  int steps;           // of the motion; 0: as long as one likes
  Scene (*scene)(int n);
};

/// Four sheets that slide, a heap, a cloth over a ball, a twisted one, a crumpled one, and two balls.
const std::vector<SelfCase>& self_cases();

}  // namespace malha::bench
