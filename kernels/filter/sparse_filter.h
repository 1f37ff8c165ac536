// SPDX-License-Identifier: Apache-2.0
// The product S F from a sparse Cholesky factor A = L L^T, for three right-hand sides at once. The panel of a supernode
// is [L11^-1; -L21 L11^-1], so that both substitutions are products, without recurrences.
// Work is partitioned into tasks (subtrees of the elimination tree) and the top above them. Each has a segment of the
// work vector: its own columns, and in a task behind them its contributions to columns of the top.
#pragma once
#include "kernels/filter/filter_io.h"
#include "kernels/simd/tile.h"

namespace malha {

/// Panel of a supernode. Its entries are stored as four rows of one column, then the next column, then the next four
/// rows.
struct Panel {
  int first;     // index of its first column in the segment
  int columns;   // its own columns, at first, first + 1, ...
  int below;     // rows below
  int row;       // offset of their indices in the list of rows
  long long at;  // offset of its entries
  KERNEL int height() const { return columns + below; }
  KERNEL int blocks() const { return (height() + 3) / 4; }
};

struct FilterTask {
  int panel, panels;
  int base;        // offset of its segment
  int own, above;  // number of own columns; number of contributions
  int list;        // offset of the contributions' columns in `above` of the view
};

/// T: type of the panels and of the work vector.
template <class T>
struct SparseView {
  const Panel* panels;
  const int* rows;
  const T* values;
  const FilterTask* tasks;  // the last is the top
  int top;                  // index of the top
  const int* above;         // indices in the top's segment
  const int* sum;           // first contribution in `from` of each entry of the top, and their number
  const int* from;          // indices in the whole work vector
  const int* particle;      // of each entry of the work vector that is an own column
  Vec4<T>* work;
  bool far;  // whether the panels exceed a core's own caches
};

/// Prefetch distance in panels that come from memory, bytes; in the backward solve, the largest part of the next panel
/// that is prefetched, bytes, and the columns from which on a panel prefetches within itself. (A million particles on
/// one thread: 68 instead of 88 ms.)
inline constexpr int kSparseAhead = 4096, kSparseNext = 65536, kSparseWide = 64;

/// Calls work<q>() for the first `count` of four columns.
template <class Work>
KERNEL void for_columns(int count, const Work& work) {
  work.template operator()<0>();
  if (count > 1) work.template operator()<1>();
  if (count > 2) work.template operator()<2>();
  if (count > 3) work.template operator()<3>();
}

/// Multiplies a panel by its own columns: blocks begin .. end - 1 of four rows each, stored from out[4 * begin] on.
template <class T, class Isa>
struct PanelProduct {
  using Four = Tile<T, Isa>;
  const T* values;
  int columns;
  const Vec4<T>* own;
  Vec4<T>* out;
  bool far;  // as in SparseView

  KERNEL void run(int begin, int end) const {
    int b = begin;
    for (; b + 4 <= end; b += 4) blocks<4>(b);
    for (; b < end; ++b) blocks<1>(b);
  }

 private:
  template <int count>
  KERNEL void blocks(int b) const {
    Four sum[count];
    for (int k = 0; k < count; ++k) sum[k] = Four::zero();
    const int last = 4 * (b + count) < columns ? 4 * (b + count) : columns;  // L11^-1 is lower triangular
    const T* from = values + 4ll * b * columns;
    for (int j = 0; j < last; j += 4) {
      Four four[count];  // columns; entries behind the last belong to others and are not used
      for (int k = 0; k < count; ++k) {
        const T* at = from + 4 * (k * columns + j);
        if (far) prefetch(reinterpret_cast<const char*>(at) + kSparseAhead, 16 * int(sizeof(T)));
        four[k] = Four::load_from(at);
      }
      for_columns(last - j, [&]<int q>() KERNEL_LAMBDA {
        const Four x = Four::repeat_row(own[j + q]);
        for (int k = 0; k < count; ++k) sum[k].add_product(four[k].template splat_row<q>(), x);
      });
    }
    for (int k = 0; k < count; ++k) sum[k].store_to(&out[4 * (b + k)].x);
  }
};

/// Multiplies a transposed panel by all its rows (padded to whole blocks): columns begin .. end - 1, stored from
/// out[begin] on.
template <class T, class Isa>
struct TransposedProduct {
  using Four = Tile<T, Isa>;
  const T* values;
  int columns, blocks;
  const Vec4<T>* rows;
  Vec4<T>* out;
  bool far;

  KERNEL void run(int begin, int end) const {
    int j = begin;
    constexpr int lanes = kLanes<T, Isa>;
    if constexpr (lanes > 1)  // OneLane has no registers for so many sums
      for (; j + 8 <= end; j += 8) some<2>(j, 4);
    for (; j < end; j += 4) some<1>(j, end - j);
  }

 private:
  /// Computes `fours` times four columns, of the last four only `count`.
  template <int fours>
  KERNEL void some(int j, int count) const {
    Four sum[4 * fours];
    for (int k = 0; k < 4 * fours; ++k) sum[k] = Four::zero();
    for (int b = j / 4; b < blocks; ++b) {
      const Four x = Four::load_from(&rows[4 * b].x);
      for (int f = 0; f < fours; ++f) {
        const T* from = values + 4 * (static_cast<long long>(b) * columns + j + 4 * f);
        const Four four = Four::load_from(from);
        if (far && columns > kSparseWide) prefetch(from + 8 * 4 * columns);  // eight blocks of rows on
        for_columns(f + 1 < fours ? 4 : count,
                    [&]<int q>() KERNEL_LAMBDA { sum[4 * f + q].add_product(four.template splat_row<q>(), x); });
      }
    }
    for (int k = 0; k < 4 * (fours - 1) + count && k < 4 * fours; ++k) out[j + k] = sum[k].sum_of_rows();
  }
};

template <class T>
KERNEL void accumulate(Vec4<T>& to, const Vec4<T>& a) {
  to.x += a.x, to.y += a.y, to.z += a.z, to.w += a.w;
}

/// Chunk of a panel for one thread of a group: blocks in the forward solve; columns, in pairs of four, in the backward
/// solve.
inline constexpr int kPanelBlocks = 4, kPanelColumns = 8;

/// Solves L y = b over the panels begin .. end - 1 of a segment, which begins at `work`. `out`: scratch for the rows of
/// one panel.
template <class T, class Group>
KERNEL void forward_solve(const Group& group, const SparseView<T>& view, int begin, int end, Vec4<T>* work,
                          Vec4<T>* out) {
  for (int p = begin; p < end; ++p) {
    const Panel panel = view.panels[p];
    Vec4<T>* own = work + panel.first;
    const PanelProduct<T, typename Group::Isa> product{view.values + panel.at, panel.columns, own, out, view.far};
    group.for_each_chunk(panel.blocks(), kPanelBlocks,
                         [&](int first, int last) KERNEL_LAMBDA { product.run(first, last); });
    group.for_each(panel.columns, [&](int k) KERNEL_LAMBDA { own[k] = out[k]; });
    const int* rows = view.rows + panel.row;
    group.for_each(panel.below, [&](int k) KERNEL_LAMBDA { accumulate(work[rows[k]], out[panel.columns + k]); });
  }
}

/// Solves L^T x = y over them, from the last to the first. `all`: scratch as `out`.
template <class T, class Group>
KERNEL void backward_solve(const Group& group, const SparseView<T>& view, int begin, int end, Vec4<T>* work,
                           Vec4<T>* all) {
  for (int p = end - 1; p >= begin; --p) {
    const Panel panel = view.panels[p];
    if (view.far && p > begin) {
      const T* next = view.values + view.panels[p - 1].at;
      const long long numbers = panel.at - view.panels[p - 1].at, most = kSparseNext / int(sizeof(T));
      for (long long k = 0; k < numbers && k < most; k += 64 / int(sizeof(T))) prefetch(next + k);
    }
    Vec4<T>* own = work + panel.first;
    const int* rows = view.rows + panel.row;
    const int padding = 4 * panel.blocks() - panel.height();
    group.for_each(panel.columns, [&](int k) KERNEL_LAMBDA { all[k] = own[k]; });
    group.for_each(panel.below, [&](int k) KERNEL_LAMBDA { all[panel.columns + k] = work[rows[k]]; });
    group.for_each(padding, [&](int k) KERNEL_LAMBDA { all[panel.height() + k] = {T(0), T(0), T(0), T(0)}; });
    const TransposedProduct<T, typename Group::Isa> product{
        view.values + panel.at, panel.columns, panel.blocks(), all, own, view.far};
    group.for_each_chunk(panel.columns, kPanelColumns,
                         [&](int first, int last) KERNEL_LAMBDA { product.run(first, last); });
  }
}

/// Forward solve L y = F over a task.
template <class T, class Io>
struct ForwardTask {
  using Shared = void;
  SparseView<T> view;
  Io io;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const FilterTask& task = view.tasks[group.index];
    Vec4<T>* work = view.work + task.base;
    const int* particle = view.particle + task.base;
    group.for_each(task.own, [&](int k) KERNEL_LAMBDA { work[k] = io.template load_rhs<T>(particle[k]); });
    group.for_each(task.above, [&](int k) KERNEL_LAMBDA { work[task.own + k] = {T(0), T(0), T(0), T(0)}; });
    forward_solve(group, view, task.panel, task.panel + task.panels, work, static_cast<Vec4<T>*>(group.memory));
  }
};

/// Backward solve L^T x = y over a task, from the top's x, which stores the result by particle.
template <class T, class Io>
struct BackwardTask {
  using Shared = void;
  SparseView<T> view;
  Io io;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const FilterTask& task = view.tasks[group.index];
    Vec4<T>* work = view.work + task.base;
    const Vec4<T>* top = view.work + view.tasks[view.top].base;
    group.for_each(task.above, [&](int k) KERNEL_LAMBDA { work[task.own + k] = top[view.above[task.list + k]]; });
    backward_solve(group, view, task.panel, task.panel + task.panels, work, static_cast<Vec4<T>*>(group.memory));
    group.for_each(task.own, [&](int k) KERNEL_LAMBDA { io.store_solution(view.particle[task.base + k], work[k]); });
  }
};

/// Solves the narrow panels `begin` .. `end` - 1 of the top in order, by one group.
template <class T, bool up>
struct SolveRootSmall {
  using Shared = void;
  SparseView<T> view;
  int begin, end;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    Vec4<T>* work = view.work + view.tasks[view.top].base;
    Vec4<T>* rows = static_cast<Vec4<T>*>(group.memory);
    if constexpr (up)
      forward_solve(group, view, begin, end, work, rows);
    else
      backward_solve(group, view, begin, end, work, rows);
  }
};

/// Computes the top's right-hand sides: forces plus the tasks' contributions in their order. One item per entry.
template <class T, class Io>
struct SumTop {
  SparseView<T> view;
  Io io;
  KERNEL void operator()(int k) const {
    const int at = view.tasks[view.top].base + k;
    Vec4<T> sum = io.template load_rhs<T>(view.particle[at]);
    for (int s = view.sum[k]; s < view.sum[k + 1]; ++s) accumulate(sum, view.work[view.from[s]]);
    view.work[at] = sum;
  }
};

/// Stores the top's part of the result by particle. One item per entry.
template <class T, class Io>
struct ScatterRoot {
  SparseView<T> view;
  Io io;
  KERNEL void operator()(int k) const {
    const int at = view.tasks[view.top].base + k;
    io.store_solution(view.particle[at], view.work[at]);
  }
};

/// Blocks or columns of a wide panel of the top per group.
inline constexpr int kTopPiece = 32;

/// Forward solve of a piece of a wide panel of the top. `out`: product of the panel.
template <class T>
struct ForwardTop {
  using Shared = void;
  SparseView<T> view;
  Panel panel;
  Vec4<T>* out;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int begin = group.index * kTopPiece, blocks = panel.blocks();
    const int end = begin + kTopPiece < blocks ? begin + kTopPiece : blocks;
    Vec4<T>* work = view.work + view.tasks[view.top].base;
    const PanelProduct<T, typename Group::Isa> product{view.values + panel.at, panel.columns, work + panel.first, out,
                                                       view.far};
    group.for_each_chunk(end - begin, kPanelBlocks,
                         [&](int first, int last) KERNEL_LAMBDA { product.run(begin + first, begin + last); });
    const int* rows = view.rows + panel.row - panel.columns;
    const int first = 4 * begin > panel.columns ? 4 * begin : panel.columns;
    const int last = 4 * end < panel.height() ? 4 * end : panel.height();
    group.for_each(last - first, [&](int k) KERNEL_LAMBDA { accumulate(work[rows[first + k]], out[first + k]); });
  }
};

/// Backward solve of a piece of a wide panel of the top. `all`: rows of the panel; `out`: result, by column.
template <class T>
struct BackwardTop {
  using Shared = void;
  SparseView<T> view;
  Panel panel;
  const Vec4<T>* all;
  Vec4<T>* out;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int begin = group.index * kTopPiece;
    const int end = begin + kTopPiece < panel.columns ? begin + kTopPiece : panel.columns;
    const TransposedProduct<T, typename Group::Isa> product{
        view.values + panel.at, panel.columns, panel.blocks(), all, out, view.far};
    group.for_each_chunk(end - begin, kPanelColumns,
                         [&](int first, int last) KERNEL_LAMBDA { product.run(begin + first, begin + last); });
  }
};

/// Gathers the rows of a panel of the top, padded to whole blocks. One item per row.
template <class T>
struct GatherTop {
  SparseView<T> view;
  Panel panel;
  Vec4<T>* all;
  KERNEL void operator()(int k) const {
    const Vec4<T>* work = view.work + view.tasks[view.top].base;
    all[k] = k < panel.columns    ? work[panel.first + k]
             : k < panel.height() ? work[view.rows[panel.row + k - panel.columns]]
                                  : Vec4<T>{T(0), T(0), T(0), T(0)};
  }
};

/// Stores the own columns of a panel of the top from `out`. One item per column.
template <class T>
struct StoreRoot {
  SparseView<T> view;
  Panel panel;
  const Vec4<T>* out;
  KERNEL void operator()(int k) const { view.work[view.tasks[view.top].base + panel.first + k] = out[k]; }
};

}  // namespace malha
