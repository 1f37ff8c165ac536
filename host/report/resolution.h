// SPDX-License-Identifier: Apache-2.0
// How finely the scene's precision tells positions apart where its bodies are: far from the origin that is coarse.
#pragma once
#include <string>
#include <vector>

#include "host/model/model.h"

namespace malha {

struct Resolution {
  double farthest = 0;  // m, the largest coordinate
  double spacing = 0;   // m, of the numbers there
  double edge = 0;      // m, the shortest at rest that has a length; infinite: there is none
  /// Half the spacing, the error of a rounded position, at both ends of the shortest edge.
  double strain() const { return spacing / edge; }
};

/// `x`: positions in any order (m).
Resolution resolution(const Model& model, const std::vector<Vec3>& x);

/// A line for people where a rounded place is off by more than a thousandth of an edge, and something acts on such
/// places: contacts with the environment, or Desbrun's method; otherwise "".
std::string coarse_resolution(const Model& model, const std::vector<Vec3>& x);

}  // namespace malha
