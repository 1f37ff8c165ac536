// SPDX-License-Identifier: Apache-2.0
// What the particles of a finer level follow, while a coarser one is made.
#pragma once
#include <array>

#include "host/model/rest_graph.h"
#include "host/model/tangent.h"

namespace malha {

inline constexpr int kMostParents = 4;
inline constexpr double kSmallWeight = 0.02;  // what is less is left out

/// A coarse particle as seen from a finer one: the way to it, in the finer one's tangent plane.
struct Parent {
  int of;  // its number among the coarse ones
  Vector way;
  double weight = 1;
};

/// At most kMostParents of them, in one place.
struct Parents {
  std::array<Parent, kMostParents> of;
  int count = 0;
  Parent* begin() { return of.data(); }
  Parent* end() { return of.data() + count; }
  const Parent* begin() const { return of.data(); }
  const Parent* end() const { return of.data() + count; }
};

}  // namespace malha
