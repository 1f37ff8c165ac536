// SPDX-License-Identifier: Apache-2.0
// Partial Cholesky factorisation of a dense front, the numeric part of a multifrontal factorisation (Duff, Reid 1983),
// in blocks, so that nearly all of it is matrix products from registers.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// View of a column-major matrix.
template <class R>
struct ColumnMajorView {
  R* data;
  int stride;  // from a column to the next
  KERNEL R& operator()(int i, int j) const { return data[i + static_cast<long long>(j) * stride]; }
  KERNEL ColumnMajorView from(int i, int j) const { return {&(*this)(i, j), stride}; }
};

/// C -= A B, or A B^T with `transposed`. C: rows x columns; A: rows x inner. `lower`: what lies above the diagonal of C
/// may become anything. Every number of C is a sum in the order of `inner`.
template <class R, class Isa>
struct SubtractProduct {
  ColumnMajorView<R> C, A, B;
  bool transposed;
  bool lower;
  int rows, columns, inner;

  KERNEL void run() const {
    constexpr int depth = 128, high = 64;
    for (int k = 0; k < inner; k += depth)
      for (int i = 0; i < rows; i += high) block(i, least(high, rows - i), k, least(depth, inner - k));
  }

 private:
  using S = Lane<R, Isa>;
  static constexpr int lanes = kLanes<R, Isa>;
  KERNEL static int least(int a, int b) { return a < b ? a : b; }

  KERNEL void block(int first, int high, int k, int depth) const {
    int j = 0;
    for (; j + 4 <= columns; j += 4) strip<4>(first, high, j, k, depth);
    for (; j < columns; ++j) strip<1>(first, high, j, k, depth);
  }
  template <int wide>
  KERNEL void strip(int first, int high, int j, int k, int depth) const {
    if (lower && first + high <= j) return;
    int i = first;
    const int end = first + high;
    for (; i + 2 * lanes <= end; i += 2 * lanes) tile<S, 2, wide>(i, j, k, depth);
    for (; i + lanes <= end; i += lanes) tile<S, 1, wide>(i, j, k, depth);
    for (; i < end; ++i) tile<R, 1, wide>(i, j, k, depth);
  }
  template <class T, int tall, int wide>
  KERNEL void tile(int i, int j, int k, int depth) const {
    constexpr int step = int(sizeof(T) / sizeof(R));
    T c[tall][wide];
    for (int a = 0; a < tall; ++a)
      for (int b = 0; b < wide; ++b) load(&C(i + a * step, j + b), c[a][b]);
    const R* left = &A(i, k);
    const R* right = transposed ? &B(j, k) : &B(k, j);
    const long long along = transposed ? B.stride : 1, across = transposed ? 1 : B.stride;
    for (int m = 0; m < depth; ++m, left += A.stride, right += along) {
      T row[tall];
      for (int a = 0; a < tall; ++a) load(left + a * step, row[a]);
      for (int b = 0; b < wide; ++b) {
        const T factor(right[b * across]);
        for (int a = 0; a < tall; ++a) c[a][b] = c[a][b] - row[a] * factor;
      }
    }
    for (int a = 0; a < tall; ++a)
      for (int b = 0; b < wide; ++b) store(c[a][b], &C(i + a * step, j + b));
  }
};

/// Eliminates the first `pivots` of `height` unknowns. In: the front's columns of the pivots (lower part) in `panel`,
/// and the rest (lower part) in `update`. Out: [L11^-1; -L21 L11^-1] in `panel`, zeros above the diagonal included, and
/// the Schur complement in `update`.
template <class R, class Isa>
struct EliminateFront {
  int height, pivots;
  ColumnMajorView<R> panel, update;
  ColumnMajorView<R> copy;  // scratch, pivots x pivots
  const R* least;           // lower bound of each pivot
  int* failed;              // out: the first pivot below it; other results are then undefined

  KERNEL void operator()(int) const {
    for (int k = 0; k < pivots && *failed < 0; k += kBlock) {
      const int end = k + kBlock < pivots ? k + kBlock : pivots;
      factor(k, end);
      if (end < pivots)
        subtract(panel.from(end, end), panel.from(end, k), panel.from(end, k), true, true, height - end, pivots - end,
                 end - k);
    }
    if (*failed >= 0) return;
    if (height > pivots) {
      const ColumnMajorView<R> below = panel.from(pivots, 0);
      subtract(update, below, below, true, true, height - pivots, height - pivots, pivots);
    }
    invert();
  }

 private:
  static constexpr int kBlock = 32;

  KERNEL static void subtract(ColumnMajorView<R> C, ColumnMajorView<R> A, ColumnMajorView<R> B, bool transposed,
                              bool lower, int rows, int columns, int inner) {
    if (rows > 0 && columns > 0) SubtractProduct<R, Isa>{C, A, B, transposed, lower, rows, columns, inner}.run();
  }

  /// Columns begin .. end - 1, from the diagonal to the bottom.
  KERNEL void factor(int begin, int end) const {
    for (int k = begin; k < end; ++k) {
      R* column = &panel(0, k);
      for (int j = begin; j < k; ++j) {
        const R* other = &panel(0, j);
        const R factor = other[k];
        for (int i = k; i < height; ++i) column[i] -= other[i] * factor;
      }
      if (!(column[k] > least[k])) {
        *failed = k;
        return;
      }
      const R d = sqrt(column[k]), per = R(1) / d;
      column[k] = d;
      for (int i = k + 1; i < height; ++i) column[i] *= per;
    }
  }

  /// Solves P L11 = [1; -L21], the last column first.
  KERNEL void invert() const {
    for (int j = 0; j < pivots; ++j) {
      for (int i = j; i < pivots; ++i) copy(i, j) = panel(i, j);
      for (int i = 0; i < pivots; ++i) panel(i, j) = R(i == j);
      for (int i = pivots; i < height; ++i) panel(i, j) = -panel(i, j);
    }
    for (int end = pivots, begin; end > 0; end = begin) {
      begin = (end - 1) / kBlock * kBlock;
      if (end < pivots)
        subtract(panel.from(begin, begin), panel.from(begin, end), copy.from(end, begin), false, false, height - begin,
                 end - begin, pivots - end);
      for (int j = end - 1; j >= begin; --j) {
        R* column = &panel(0, j);
        for (int k = j + 1; k < end; ++k) {
          const R* other = &panel(0, k);
          const R factor = copy(k, j);
          for (int i = j; i < height; ++i) column[i] -= other[i] * factor;
        }
        const R per = R(1) / copy(j, j);
        for (int i = j; i < height; ++i) column[i] *= per;
      }
    }
  }
};

}  // namespace malha
