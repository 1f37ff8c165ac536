// SPDX-License-Identifier: Apache-2.0
// Numbers for tests: reproducible random ones, and comparison bit by bit.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>

#include "kernels/simd/vec.h"

namespace malha {

/// The same numbers on every platform (the standard's distributions are not).
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  /// In [low, high).
  double operator()(double low = -1, double high = 1) { return low + (high - low) * (engine_() * 0x1p-32); }
  /// In 0 .. n - 1.
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint32_t>(n)); }
  Vector3<double> in_cube(double half = 1) {
    const double x = (*this)(-half, half), y = (*this)(-half, half), z = (*this)(-half, half);
    return {x, y, z};
  }
  /// Uniform over the unit sphere.
  Vector3<double> direction() {
    for (;;) {
      const Vector3<double> d = in_cube();
      const double squared = dot(d, d);
      if (squared > 0.01 && squared < 1) return d * (1 / std::sqrt(squared));
    }
  }

 private:
  std::mt19937 engine_;
};

/// Tells -0 from 0, and NaN equals itself.
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class R>
Vector3<double> to_double(const Vector3<R>& a) {
  return {double(a.x), double(a.y), double(a.z)};
}

}  // namespace malha
