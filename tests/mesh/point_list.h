// SPDX-License-Identifier: Apache-2.0
// A growing, copyable list of points on the host, in the layout that kernels read.
#pragma once
#include <vector>

#include "kernels/simd/particles.h"

namespace malha {

template <class R>
class PointList {
 public:
  PointList() = default;
  explicit PointList(std::size_t size) : x_(size), y_(size), z_(size) {}

  void push_back(const Vector3<double>& a) { x_.push_back(R(a.x)), y_.push_back(R(a.y)), z_.push_back(R(a.z)); }
  void set(int i, const Vector3<R>& a) { points().set(i, a); }
  Vector3<R> operator[](int i) const { return {x_[i], y_[i], z_[i]}; }
  int size() const { return static_cast<int>(x_.size()); }
  Points<R> points() { return {x_.data(), y_.data(), z_.data()}; }

 private:
  std::vector<R> x_, y_, z_;
};

}  // namespace malha
