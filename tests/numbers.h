// SPDX-License-Identifier: Apache-2.0
// Numbers for tests: reproducible random numbers, and bitwise comparison.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>

#include "kernels/simd/vec.h"

namespace malha {

/// Random numbers that are the same on every platform, unlike the standard's distributions.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  /// A uniform number in [low, high).
  double operator()(double low = -1, double high = 1) { return low + (high - low) * (engine_() * 0x1p-32); }
  /// A uniform integer in 0 .. n - 1.
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint32_t>(n)); }
  Vector3<double> in_cube(double half = 1) {
    const double x = (*this)(-half, half), y = (*this)(-half, half), z = (*this)(-half, half);
    return {x, y, z};
  }
  /// A direction, uniform over the unit sphere.
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

/// Bitwise equality: -0 differs from 0, and a NaN equals itself.
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

template <class R>
Vector3<double> to_double(const Vector3<R>& a) {
  return {double(a.x), double(a.y), double(a.z)};
}

}  // namespace malha
