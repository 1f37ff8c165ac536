// SPDX-License-Identifier: Apache-2.0
// Strips that bend by a rigidity, for tests of filtered bending.
#pragma once
#include <string>

#include "tests/small_scenes.h"

namespace malha {

inline ConstraintSpec bending_of(const std::string& type, double D) {
  ConstraintSpec spec = stiff(type, {}, 1, type == "plate" ? 0 : 1);
  spec.rigidity = D;
  return spec;
}

/// A strip of 1 m along z and 0.25 m across, of 0.1 kg/m^2, with `cells` cells along. Its first two rows are pinned.
inline BodySpec clamped_strip(int cells, double D, const std::string& type = "bending") {
  BodySpec body;
  const int across = cells / 4;
  body.name = "strip", body.shape = GridShape{{0.25, 1}, {across, cells}}, body.density = 0.1;
  ListPin clamp;
  for (int i = 0; i < 2 * (across + 1); ++i) clamp.particles.push_back(i);
  body.pins = {clamp};
  body.constraints = {stiff("distance", {"edges", "shear"}), bending_of(type, D)};
  return body;
}

}  // namespace malha
