// SPDX-License-Identifier: Apache-2.0
// Points in the executor's memory, one array a coordinate.
#pragma once
#include <span>
#include <vector>

#include "host/base/array.h"
#include "kernels/projection/patch.h"
#include "kernels/simd/particles.h"
#include "malha/mesh.h"

namespace malha {

template <class Executor, class R>
class PointArray {
 public:
  PointArray() = default;
  explicit PointArray(const std::vector<Vec3>& points) : size_(points.size()), values_(3 * stride(), R(0)) {
    upload(points);
  }
  explicit PointArray(std::size_t size) : size_(size), values_(3 * stride(), R(0)) {}

  Points<R> points() const {
    const auto x = values_.data();
    return {x, x + stride(), x + 2 * stride()};
  }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return values_.bytes(); }

  /// `points` has size() elements; each has three.
  template <class Point>
  void upload(const std::vector<Point>& points) {
    std::vector<R> values(3 * stride(), R(0));
    for (std::size_t i = 0; i < size_; ++i)
      for (int k = 0; k < 3; ++k) values[k * stride() + i] = R(points[i][k]);
    values_.upload(values);
  }
  void set(std::size_t i, const Vec3& point) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const R number = R(point[k]);
      Memory<Executor>::copy_in(&number, 1, values_.data() + k * stride() + i);
    }
  }
  Vec3 get(std::size_t i) const {
    R number[3];
    for (std::size_t k = 0; k < 3; ++k) Memory<Executor>::copy_out(values_.data() + k * stride() + i, 1, number + k);
    return {number[0], number[1], number[2]};
  }
  template <class Point = Vec3>
  std::vector<Point> download() const {
    std::vector<Point> points;
    download_to(points);
    return points;
  }
  /// Writes point i, or the sum of both points i, to the three numbers from to[stride at[i]] on.
  template <class Number>
  void scatter_to(Number* to, std::size_t stride_of_to, const std::vector<int>& at,
                  const PointArray* low = nullptr) const {
    const std::span<const R> values = values_.on_host(staging_);
    const std::span<const R> rest = low ? low->values_.on_host(low->staging_) : std::span<const R>{};
    for (std::size_t i = 0; i < size_; ++i) {
      Number* const point = to + static_cast<std::size_t>(at[i]) * stride_of_to;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t from = k * stride() + i;
        point[k] = static_cast<Number>(rest.empty() ? double(values[from]) : double(values[from]) + double(rest[from]));
      }
    }
  }
  /// Sets point i to the at[i]-th of the list.
  void gather(const std::vector<Vec3>& points, const std::vector<int>& at) {
    R* const to = Memory<Executor>::kOnHost ? values_.data() : (staging_.resize(values_.size()), staging_.data());
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t k = 0; k < 3; ++k) to[k * stride() + i] = R(points[static_cast<std::size_t>(at[i])][k]);
    if (!Memory<Executor>::kOnHost) values_.upload(staging_);
  }
  /// Adds each point to one of the list, which has size() elements.
  void add_to(std::vector<Vec3>& points) const {
    const std::span<const R> values = values_.on_host(staging_);
    for (std::size_t i = 0; i < size_; ++i)
      for (int k = 0; k < 3; ++k) points[i][k] += values[k * stride() + i];
  }
  /// Allocates nothing on the host if the capacity of `points` suffices.
  template <class Point>
  void download_to(std::vector<Point>& points) const {
    points.resize(size_);
    const std::span<const R> values = values_.on_host(staging_);
    for (std::size_t i = 0; i < size_; ++i)
      for (int k = 0; k < 3; ++k) points[i][k] = values[k * stride() + i];
  }

 private:
  /// Padded to whole packs and one more, so that a pack may start at the last particle. The odd number of cache lines
  /// keeps the coordinates of one particle out of the same cache set.
  std::size_t stride() const {
    const std::size_t packs = (size_ + kSlotPack - 1) / kSlotPack + 1;
    return (packs + (packs % 2 == 0 ? 0 : 1)) * kSlotPack;
  }

  std::size_t size_ = 0;
  Array<Executor, R> values_;
  mutable std::vector<R> staging_;  // values_ of a device
};

/// Points as rows of four numbers, for kernels that read them in no particular order.
template <class Executor, class R>
class ScatteredArray {
 public:
  ScatteredArray() = default;
  explicit ScatteredArray(std::size_t size) : values_(size, Vec4<R>{}) {}
  explicit ScatteredArray(const std::vector<Vec3>& points) : ScatteredArray(points.size()) { upload(points); }

  ScatteredPoints<R> points() const { return {values_.data()}; }
  std::size_t bytes() const { return values_.bytes(); }

  /// `points` has size() elements; each has three.
  template <class Point>
  void upload(const std::vector<Point>& points) {
    std::vector<Vec4<R>> values;
    for (const Point& point : points) values.push_back({R(point[0]), R(point[1]), R(point[2]), R(0)});
    values_.upload(values);
  }
  template <class Point = Vec3>
  std::vector<Point> download() const {
    std::vector<Point> points;
    for (const Vec4<R>& a : values_.download()) points.push_back({a.x, a.y, a.z});
    return points;
  }
  Vec3 get(std::size_t i) const {
    const Vec4<R> a = values_.get(i);
    return {a.x, a.y, a.z};
  }
  /// Sets w of the first points.
  void upload_fourth(const std::vector<R>& numbers) {
    std::vector<Vec4<R>> values = values_.download();
    for (std::size_t i = 0; i < numbers.size(); ++i) values[i].w = numbers[i];
    values_.upload(values);
  }
  std::vector<R> download_fourth(std::size_t count) const {
    std::vector<R> numbers;
    for (const Vec4<R>& a : values_.download())
      if (numbers.size() < count) numbers.push_back(a.w);
    return numbers;
  }

 private:
  Array<Executor, Vec4<R>> values_;
};

}  // namespace malha
