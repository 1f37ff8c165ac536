// SPDX-License-Identifier: Apache-2.0
// Scenes for tests of particle handles, and the comparison of the bits of two simulations.
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <utility>

#include "tests/small_scenes.h"

namespace malha {

inline BodySpec cloth_by_hand(const std::string& name, double x, int cells = 12) {
  BodySpec cloth;
  cloth.name = name, cloth.mass = 0.2;
  cloth.shape = GridShape{{1, 1}, {cells, cells}};
  cloth.transform.translate = {x, 0, 0};
  cloth.constraints = {stiff("distance", {"edges", "shear"}), compliant("bending", 0.01)};
  cloth.pins = {ListPin{{0, cells}}};
  return cloth;
}

/// Two cloths 3 m apart, which never meet.
inline Scene two_cloths(Precision precision = Precision::Float) {
  Scene scene = scene_of({cloth_by_hand("left", 0), cloth_by_hand("right", 3)}, kEarth, 0.01, 4, precision);
  scene.solver.levels = 0;
  return scene;
}

/// Tests whether `count` particles from `first` on have the same bits in both simulations.
inline testing::AssertionResult same_bits(const Simulation& a, const Simulation& b, std::size_t first,
                                          std::size_t count) {
  for (const auto& [p, q] : {std::pair(a.positions(), b.positions()), std::pair(a.velocities(), b.velocities())})
    for (std::size_t i = first; i < first + count; ++i)
      if (std::memcmp(&p[i], &q[i], sizeof p[i]) != 0) return testing::AssertionFailure() << "particle " << i;
  return testing::AssertionSuccess();
}

}  // namespace malha
