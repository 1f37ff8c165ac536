// SPDX-License-Identifier: Apache-2.0
// The filter as a dense symmetric S in the executor's memory (kernels/filter/dense_filter.h).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "host/base/array.h"
#include "host/filter/system.h"
#include "kernels/filter/dense_filter.h"

namespace malha {

/// Memory layout of a dense filter: the lists of DenseView. Bodies one after the other, each padded to whole blocks of
/// rows.
struct DensePlan {
  std::vector<DenseChunk> chunks;  // body by body
  std::vector<DenseRow> rows;
  std::vector<int> particle;
  std::vector<std::int64_t> at;  // of each body's numbers of S
  std::vector<int> first_row;    // of each body
  std::int64_t values = 0;       // numbers of S
  int sums = 0;                  // blocks of sums of all chunks
};

DensePlan plan_dense(const SpringSystem& system);

/// Number of entries of S that plan_dense() would lay out.
std::int64_t dense_values(const SpringSystem& system);

/// V: storage type of S; T: type of the computation.
template <class Executor, class V, class T>
class DenseFilter {
 public:
  /// Allocates the filter: `take` must be called for every column.
  DenseFilter(const Executor& executor, int threads, const SpringSystem& system)
      : executor_(executor), plan_(plan_dense(system)) {
    chunks_ = Array<Executor, DenseChunk>(plan_.chunks), rows_ = Array<Executor, DenseRow>(plan_.rows);
    particle_ = Array<Executor, int>(plan_.particle);
    values_ = FilledArray<Executor, V>(static_cast<std::size_t>(plan_.values), V(0));
    if (kIntegers) scale_ = FilledArray<Executor, T>(plan_.particle.size(), T(0));
    x_ = Array<Executor, T>(std::size_t(kDenseSides) * plan_.rows.size(), T(0));
    y_ = Array<Executor, T>(std::size_t(kDenseSides) * plan_.sums, T(0));
    width_ = std::max(1, std::min({threads, static_cast<int>(plan_.chunks.size()),
                                   static_cast<int>(std::min<std::int64_t>(plan_.values / kGrain, 1 << 20))}));
    plan_.particle = {};
  }

  /// Sets the scale of integers, from sqrt(S_ii) and sqrt(S_jj), so that S_ij / (scale_i scale_j) is at most 32767.
  /// Must be called for every unknown before the first `take`.
  void take_diagonal(int body, int unknown, double number) {
    if (kIntegers) scale_.to_fill()[plan_.first_row[body] + unknown] = T(std::sqrt(std::max(number, 0.0) / 32767));
  }

  /// Rounds and stores column `j` of a body's S, from the diagonal downwards. `column`: by the body's unknowns.
  template <class Column>
  void take(int body, int j, int count, const Column& column) {
    const int b = j / kDenseRows, c = j % kDenseRows;
    const std::int64_t at = plan_.at[body];
    const auto put = [&](int i, int row_block, std::int64_t place) {
      values_.to_fill()[at + dense_numbers(row_block) + place] = stored(body, i, j, column(i));
    };
    // Within the diagonal block both halves are there; below, four rows of 16 columns lie together.
    for (int i = j; i < std::min(count, kDenseRows * (b + 1)); ++i) {
      const std::int64_t before = std::int64_t(kDenseRows) * kDenseRows * b;
      put(i, b, before + kDenseRows * (i % kDenseRows) + c);
      put(i, b, before + kDenseRows * c + i % kDenseRows);
    }
    for (int i = kDenseRows * (b + 1); i < count; ++i) {
      const int row = i / kDenseRows, panel = i % kDenseRows / 4, r = i % 4;
      put(i, row, std::int64_t(4) * kDenseRows * (std::int64_t(panel) * row + b) + kDenseRows * r + c);
    }
  }

  /// Called after the last `take`.
  void send() { values_.send(), scale_.send(); }

  /// Applies S to the forces of `io`, and stores accelerations.
  template <class Io>
  void apply(const Io& io) const {
    const DenseView<V, T> view{chunks_.data(), rows_.data(), values_.data(), particle_.data(),
                               scale_.data(),  x_.data(),    y_.data()};
    const auto chunks = static_cast<int>(chunks_.size()), rows = static_cast<int>(rows_.size());
    constexpr int piece = 16;
    parallel_region(executor_, width_, [&](const auto& team) {
      parallel_pieces(team, rows, piece, GatherDense<V, T, Io>{view, io});
      parallel_groups(team, 0, chunks, {nullptr, kDenseSums * sizeof(T)}, MultiplyDense<V, T>{view});
      parallel_pieces(team, rows, piece, SumDense<V, T, Io>{view, io});
    });
  }

  int launches() const { return 3; }
  std::int64_t numbers() const { return plan_.values; }
  std::size_t bytes() const {
    return chunks_.bytes() + rows_.bytes() + particle_.bytes() + values_.bytes() + scale_.bytes() + x_.bytes() +
           y_.bytes();
  }

 private:
  static constexpr bool kIntegers = std::is_integral_v<V>;
  static constexpr std::int64_t kGrain = 65536;  // entries of S per thread at least, some microseconds

  V stored(int body, int i, int j, double number) const {
    if constexpr (kIntegers) {
      const T* scale = scale_.filled() + plan_.first_row[body];
      const double unit = double(scale[i]) * double(scale[j]);
      return V(unit > 0 ? std::clamp(std::lround(number / unit), -32767L, 32767L) : 0);
    } else {
      return V(number);
    }
  }

  Executor executor_;
  DensePlan plan_;
  Array<Executor, DenseChunk> chunks_;
  Array<Executor, DenseRow> rows_;
  Array<Executor, int> particle_;
  FilledArray<Executor, V> values_;
  FilledArray<Executor, T> scale_;
  Array<Executor, T> x_, y_;
  int width_ = 1;
};

}  // namespace malha
