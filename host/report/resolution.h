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

/// Of the numbers of the scene's precision at a coordinate, m.
double spacing_at(const Model& model, double coordinate);

/// Of the numbers where the farthest coordinate is, m, without a look at the edges. `x`: positions in any order (m).
double spacing(const Model& model, const std::vector<Vec3>& x);

/// `x`: positions in any order (m).
Resolution resolution(const Model& model, const std::vector<Vec3>& x);

/// A line for people where rounding alone can strain an edge by more than a thousandth; otherwise "".
std::string coarse_resolution(const Model& model, const std::vector<Vec3>& x);

}  // namespace malha
