// SPDX-License-Identifier: Apache-2.0
// Spacing of floating-point numbers at the positions of a scene's bodies, relative to their edges.
#pragma once
#include <string>
#include <vector>

#include "host/model/model.h"

namespace malha {

struct Resolution {
  double farthest = 0;  // m, the largest coordinate
  double spacing = 0;   // m, of floating-point numbers there
  double edge = 0;      // m, the shortest edge at rest whose length is not 0; infinite: there is none
  /// Returns the strain of the shortest edge whose both ends are off by half the spacing, the rounding error of a
  /// position.
  double strain() const { return spacing / edge; }
};

/// `x`: positions in any order (m).
Resolution resolution(const Model& model, const std::vector<Vec3>& x);

/// Returns a warning where the rounding of positions exceeds a thousandth of an edge and matters, because of contacts
/// with the environment or Desbrun's method; otherwise "".
std::string resolution_warning(const Model& model, const std::vector<Vec3>& x);

}  // namespace malha
