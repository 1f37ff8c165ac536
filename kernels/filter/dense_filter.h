// SPDX-License-Identifier: Apache-2.0
// The product S F with a dense symmetric S, for three right-hand sides at once. Each entry of S is stored and read
// once, for its row and its column. Rows are in blocks of 16. Left of the diagonal a block is four panels of four rows,
// 16 columns after 16; the 16 x 16 block on the diagonal is stored in full. Right-hand sides and sums are 16 x, 16 y,
// 16 z per block.
#pragma once
#include "kernels/filter/filter_io.h"
#include "kernels/simd/tile.h"

namespace malha {

inline constexpr int kDenseRows = 16;
/// Prefetch distance in S, bytes. (Without it one thread reads from memory half as fast: 11 instead of 27 GB/s.)
inline constexpr int kDenseAhead = 8192;
/// Size of a block of right-hand sides, numbers.
inline constexpr int kDenseSides = 3 * kDenseRows;

/// Number of entries of S before the block of rows `b`.
KERNEL long long dense_numbers(long long b) { return kDenseRows * kDenseRows * (b * (b + 1) / 2); }

/// Consecutive blocks of rows of one body that one group multiplies, with sums of its own.
struct DenseChunk {
  int begin, end;  // blocks of rows
  long long at;    // offset of the body's entries of S
  int x;           // first block of the body's right-hand sides
  int y;           // first block of its sums, one for every block of rows before `end`
};

/// A block of rows of the result, and the chunks that have sums of it.
struct DenseRow {
  int chunk, chunks;
  int b;  // in the body
};

/// V: storage type of S; T: type of the computation.
template <class V, class T>
struct DenseView {
  const DenseChunk* chunks;
  const DenseRow* rows;
  const V* values;
  const int* particle;  // of each row; -1: padding
  const T* scale;       // of each row if V is an integer, S_ij = scale_i scale_j value; otherwise null
  T *x, *y;
};

/// Fast memory of a block of threads for the sums of a panel, numbers.
inline constexpr int kDenseSums = 4 * kDenseSides;

/// y = S x over a chunk.
template <class V, class T>
struct MultiplyDense {
  using Shared = void;
  DenseView<V, T> view;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const DenseChunk chunk = view.chunks[group.index];
    const T* x = view.x + static_cast<long long>(kDenseSides) * chunk.x;
    T* y = view.y + static_cast<long long>(kDenseSides) * chunk.y;
    group.for_each(kDenseSides * chunk.end, [&](int k) KERNEL_LAMBDA { y[k] = T(0); });
    const V* values = view.values + chunk.at + dense_numbers(chunk.begin);
    for (int b = chunk.begin; b < chunk.end; ++b) {
      for (int q = 0; q < 4; ++q, values += 4 * kDenseRows * b) panel(group, values, x, y, b, q);
      diagonal(group, values, x + kDenseSides * b, y + kDenseSides * b);
      values += kDenseRows * kDenseRows;
    }
  }

 private:
  template <class Isa>
  KERNEL static void panel(const Group<Isa>&, const V* values, const T* x, T* y, int b, int q) {
    using Sixteen = Tile<T, Isa>;
    Sixteen sum[4][3], own[4][3];
    const int first = kDenseSides * b + 4 * q;
    for (int r = 0; r < 4; ++r)
      for (int k = 0; k < 3; ++k) {
        sum[r][k] = Sixteen::zero();
        own[r][k] = Sixteen::broadcast(x[first + kDenseRows * k + r]);
      }
    for (int c = 0; c < b; ++c, values += 4 * kDenseRows, x += kDenseSides, y += kDenseSides) {
      prefetch(reinterpret_cast<const char*>(values) + kDenseAhead, 4 * kDenseRows * int(sizeof(V)));
      Sixteen s[4];
      for (int r = 0; r < 4; ++r) s[r] = Sixteen::load_from(values + kDenseRows * r);
      for (int k = 0; k < 3; ++k) {
        const Sixteen other = Sixteen::load_from(x + kDenseRows * k);
        Sixteen column = Sixteen::load_from(y + kDenseRows * k);
        for (int r = 0; r < 4; ++r) {
          sum[r][k].add_product(s[r], other);
          column.add_product(s[r], own[r][k]);
        }
        column.store_to(y + kDenseRows * k);
      }
    }
    for (int k = 0; k < 3; ++k) {
      const Vec4<T> rows = Sixteen::sums(sum[0][k], sum[1][k], sum[2][k], sum[3][k]);
      T* own_y = y + 4 * q + kDenseRows * k;
      own_y[0] += rows.x, own_y[1] += rows.y, own_y[2] += rows.z, own_y[3] += rows.w;
    }
  }

  template <class Isa>
  KERNEL static void diagonal(const Group<Isa>&, const V* values, const T* x, T* y) {
    using Sixteen = Tile<T, Isa>;
    for (int k = 0; k < 3; ++k) {
      Sixteen sum = Sixteen::load_from(y + kDenseRows * k);
      for (int r = 0; r < kDenseRows; ++r)
        sum.add_product(Sixteen::load_from(values + kDenseRows * r), Sixteen::broadcast(x[kDenseRows * k + r]));
      sum.store_to(y + kDenseRows * k);
    }
  }

  /// On a device each thread has one of the sixteen columns, of x, y or z.
  template <class Threads>
  KERNEL static void panel(const Block<Threads>& block, const V* values, const T* x, T* y, int b, int q) {
    T* sums = static_cast<T*>(block.memory);
    const int first = kDenseSides * b + 4 * q;
    block.for_each(kDenseSides, [&](int l) KERNEL_LAMBDA {
      const int column = l % kDenseRows;
      T sum[4] = {}, own[4];
      for (int r = 0; r < 4; ++r) own[r] = x[first + (l - column) + r];
      for (int c = 0; c < b; ++c) {
        const V* s = values + 4 * kDenseRows * c + column;
        const T other = x[kDenseSides * c + l];
        T all = y[kDenseSides * c + l];
        for (int r = 0; r < 4; ++r) {
          const T number = T(s[kDenseRows * r]);
          sum[r] = sum[r] + number * other;
          all = all + number * own[r];
        }
        y[kDenseSides * c + l] = all;
      }
      for (int r = 0; r < 4; ++r) sums[kDenseSides * r + l] = sum[r];
    });
    block.for_each(12, [&](int i) KERNEL_LAMBDA {
      const int r = i % 4, k = i / 4;
      const T* t = sums + kDenseSides * r + kDenseRows * k;
      const auto sum = [&](int j) KERNEL_LAMBDA { return (t[j] + t[4 + j]) + (t[8 + j] + t[12 + j]); };  // as Tile's
      y[first + kDenseRows * k + r] += (sum(0) + sum(1)) + (sum(2) + sum(3));
    });
  }

  template <class Threads>
  KERNEL static void diagonal(const Block<Threads>& block, const V* values, const T* x, T* y) {
    block.for_each(kDenseSides, [&](int l) KERNEL_LAMBDA {
      const int column = l % kDenseRows;
      T sum = y[l];
      for (int r = 0; r < kDenseRows; ++r) sum = sum + T(values[kDenseRows * r + column]) * x[l - column + r];
      y[l] = sum;
    });
  }
};

/// Gathers the right-hand sides of a block of rows.
template <class V, class T, class Io>
struct GatherDense {
  DenseView<V, T> view;
  Io io;
  KERNEL void operator()(int b) const {
    T* x = view.x + static_cast<long long>(kDenseSides) * b;
    for (int r = 0; r < kDenseRows; ++r) {
      const int particle = view.particle[kDenseRows * b + r];
      const T scale = view.scale ? view.scale[kDenseRows * b + r] : T(1);
      const Vec4<T> f = particle < 0 ? Vec4<T>{T(0), T(0), T(0), T(0)} : io.template load_rhs<T>(particle);
      x[r] = f.x * scale, x[kDenseRows + r] = f.y * scale, x[2 * kDenseRows + r] = f.z * scale;
    }
  }
};

/// Adds up the chunks' sums of a block of rows in order, and stores the result by particle.
template <class V, class T, class Io>
struct SumDense {
  DenseView<V, T> view;
  Io io;
  KERNEL void operator()(int b) const {
    const DenseRow row = view.rows[b];
    T sum[kDenseSides] = {};
    for (int c = row.chunk; c < row.chunk + row.chunks; ++c) {
      const T* y = view.y + static_cast<long long>(kDenseSides) * (view.chunks[c].y + row.b);
      for (int k = 0; k < kDenseSides; ++k) sum[k] += y[k];
    }
    for (int r = 0; r < kDenseRows; ++r) {
      const int particle = view.particle[kDenseRows * b + r];
      const T scale = view.scale ? view.scale[kDenseRows * b + r] : T(1);
      if (particle >= 0)
        io.store_solution(particle,
                          Vec4<T>{sum[r] * scale, sum[kDenseRows + r] * scale, sum[2 * kDenseRows + r] * scale, T(0)});
    }
  }
};

}  // namespace malha
