// SPDX-License-Identifier: Apache-2.0
// Reference of the hinges of Desbrun's method: from the positions of the wings and the edge, without the kernels' code.
#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "host/model/model.h"
#include "tests/small_scenes.h"

namespace malha {

/// E = (|f| - l)^2 / (2 alpha), f = (c - c') / h_c + (d - d') / h_d: both wings over their feet c', d' on the edge at
/// rest, in heights h. Two unit vectors away from the edge, whose sum is 2 sin(theta / 2) long.
struct FoldReference {
  std::array<int, 4> of;          // the edge's ends and the wings, in the solver's order
  std::array<double, 4> weight;   // of each particle in f, 1/m
  double rest, stiffness, lever;  // l, 1 / alpha (N m), mean height (m)

  Vec3 fold(const std::vector<Vec3>& x) const {
    Vec3 f{0, 0, 0};
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k) f[k] += weight[j] * x[of[j]][k];
    return f;
  }
  double energy(const std::vector<Vec3>& x) const {
    const double off = length(fold(x)) - rest;
    return stiffness * off * off / 2;
  }
};

inline std::vector<FoldReference> folds_of(const Model& model) {
  std::vector<FoldReference> all;
  for (const ConstraintSet& set : model.stencils)
    for (int c = 0; c < set.count(); ++c) {
      FoldReference one{};
      std::copy_n(&set.particles[4 * c], 4, one.of.begin());
      const Vec3 a = model.x[one.of[0]], e = model.x[one.of[1]] - a;
      const double edge2 = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
      double heights = 0;
      for (const int wing : {2, 3}) {
        const Vec3 r = model.x[one.of[wing]] - a;
        const double foot = (r[0] * e[0] + r[1] * e[1] + r[2] * e[2]) / edge2;
        const double height = length(Vec3{r[0] - foot * e[0], r[1] - foot * e[1], r[2] - foot * e[2]});
        one.weight[wing] += 1 / height, one.weight[0] -= (1 - foot) / height, one.weight[1] -= foot / height;
        heights += height;
      }
      one.stiffness = 1 / set.alpha(c), one.lever = heights / 2;
      one.rest = 0;
      const double folded = length(one.fold(model.x));
      one.rest = folded > 1e-9 ? set.parameter * folded : 0;
      all.push_back(one);
    }
  return all;
}

}  // namespace malha
