// SPDX-License-Identifier: Apache-2.0
// The product S F from a sparse Cholesky factor A = L L^T, for three right-hand sides at once. The panel of a supernode
// is [L11^-1; -L21 L11^-1], so that both substitutions are products, without recurrences.
// Work is cut into tasks (subtrees of the elimination tree) and the top above them. Each has a segment of the work
// vector: its own columns, then, in a task, its contributions to columns of the top.
#pragma once
#include "kernels/filter/filter_io.h"
#include "kernels/simd/tile.h"

namespace malha {

struct Panel {
  int first;     // place of its first column in the segment
  int columns;   // own, at places first, first + 1, ...
  int below;     // rows below
  int row;       // where their places stand in the list of rows
  long long at;  // of its numbers: four rows of one column side by side, then the next column, then the next four rows
  KERNEL int height() const { return columns + below; }
  KERNEL int blocks() const { return (height() + 3) / 4; }
};

struct FilterTask {
  int panel, panels;
  int base;        // of its segment
  int own, above;  // columns of its own; contributions
  int list;        // where the contributions' columns stand in `above` of the view
};

/// T: numbers of the panels and of the work.
template <class T>
struct SparseView {
  const Panel* panels;
  const int* rows;
  const T* values;
  const FilterTask* tasks;  // the last is the top
  int top;                  // its number
  const int* above;         // places in the top's segment
  const int* sum;           // of each place of the top: where its contributions begin in `from`, and one more
  const int* from;          // places in the whole work vector
  const int* particle;      // of each place of the work vector that is a column's own
  Vec4<T>* work;
  bool far;  // the panels are not in a core's own caches
};

/// Panels that come from memory are asked for this far ahead, bytes; going down through them, the next panel is asked
/// for up to this size, and a wide one within itself. (A million particles on one thread: 68 instead of 88 ms.)
inline constexpr int kSparseAhead = 4096, kSparseNext = 65536, kSparseWide = 64;

/// work<q>() for the first `count` of four columns.
template <class Work>
KERNEL void for_columns(int count, const Work& work) {
  work.template operator()<0>();
  if (count > 1) work.template operator()<1>();
  if (count > 2) work.template operator()<2>();
  if (count > 3) work.template operator()<3>();
}

/// Panel times own columns: blocks begin .. end - 1 of four rows each, to out[4 * begin] and on.
template <class T, class Isa>
struct PanelProduct {
  using Four = Tile<T, Isa>;
  const T* values;
  int columns;
  const Vec4<T>* own;
  Vec4<T>* out;
  bool far;  // the numbers are not in the caches

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
      Four four[count];  // columns; those behind the last are somebody else's numbers
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

/// Transposed panel times all its rows (padded to whole blocks): columns begin .. end - 1, to out[begin] and on.
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
    if constexpr (lanes > 1)  // one has no registers for so many sums
      for (; j + 8 <= end; j += 8) some<2>(j, 4);
    for (; j < end; j += 4) some<1>(j, end - j);
  }

 private:
  /// `fours` times four columns, of the last of which only `count` are wanted.
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

/// What one thread of a group takes of a panel at once: blocks going up; columns coming down, whole pairs of four.
inline constexpr int kPanelBlocks = 4, kPanelColumns = 8;

/// L y = b over the panels begin .. end - 1 of a segment, whose places begin at `work`. `out`: room for one panel's
/// rows.
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

/// L^T x = y over them, from the last to the first. `all`: as `out`.
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

/// L y = F over a task.
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

/// L^T x = y over a task, from the top's x, and out to the particles.
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

/// Narrow panels of the top, one after the other: `begin` .. `end` - 1, by one group.
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

/// The top's right-hand sides: forces, and the tasks' contributions in their order. By place.
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

/// The top's part of the result, out to the particles. By place.
template <class T, class Io>
struct ScatterRoot {
  SparseView<T> view;
  Io io;
  KERNEL void operator()(int k) const {
    const int at = view.tasks[view.top].base + k;
    io.store_solution(view.particle[at], view.work[at]);
  }
};

/// Blocks or columns of a wide panel of the top that are worked on together.
inline constexpr int kTopPiece = 32;

/// A wide panel of the top, a piece of its blocks: `out` holds its product for all of them.
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

/// The same of L^T: `all` holds the panel's rows, `out` takes the columns of this piece.
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

/// The rows of a panel of the top in a list of their own, whole blocks. By row.
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

/// The own columns of a panel of the top, from `out`. By column.
template <class T>
struct StoreRoot {
  SparseView<T> view;
  Panel panel;
  const Vec4<T>* out;
  KERNEL void operator()(int k) const { view.work[view.tasks[view.top].base + panel.first + k] = out[k]; }
};

}  // namespace malha
