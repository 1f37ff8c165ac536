// SPDX-License-Identifier: Apache-2.0
// The filter as a sparse factor in the executor's memory (kernels/filter/sparse_filter.h).
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/base/array.h"
#include "host/base/launch_graph.h"
#include "host/filter/supernodes.h"
#include "kernels/filter/sparse_filter.h"

namespace malha {

/// Memory layout of a sparse filter, the lists of SparseView: panels, segments of the work vector, and contributions
/// between them.
struct SparsePlan {
  std::vector<Panel> panels;  // task by task, each in the order of elimination; the top's at the end
  std::vector<int> panel_of;  // of each supernode
  std::vector<int> rows;
  std::vector<FilterTask> tasks;
  std::vector<int> above, sum, from;
  std::vector<int> particle;  // of the work vector's places; -1: a contribution
  std::int64_t values = 0;    // numbers of all panels
  int most_rows = 0;          // of a panel, whole blocks
};

SparsePlan plan_sparse(const SpringSystem& system, const Supernodes& all, const Subtrees& cut);

/// T: type of storage and computation.
template <class Executor, class T>
class SparseFilter {
 public:
  /// Allocates the filter: `take` must be called for every supernode.
  SparseFilter(const Executor& executor, int threads, const SpringSystem& system, const Supernodes& all,
               const Subtrees& cut)
      : executor_(executor), plan_(plan_sparse(system, all, cut)) {
    panels_ = Array<Executor, Panel>(plan_.panels), tasks_ = Array<Executor, FilterTask>(plan_.tasks);
    rows_ = Array<Executor, int>(plan_.rows), particle_ = Array<Executor, int>(plan_.particle);
    above_ = Array<Executor, int>(plan_.above), sum_ = Array<Executor, int>(plan_.sum);
    from_ = Array<Executor, int>(plan_.from);
    values_ =
        FilledArray<Executor, T>(static_cast<std::size_t>(plan_.values) + 16, T(0));  // a tile may reach beyond the end
    memory_bytes_ = (plan_.most_rows * sizeof(Vec4<T>) / 128 + 1) * 128 + 64;
    const auto tasks = static_cast<int>(plan_.tasks.size()) - 1;
    width_ = std::max(1, std::min({threads, tasks, static_cast<int>(plan_.values / kGrain)}));
    own_ = workspace(width_);
    find_top_ranges();
    // Data in the executor's memory are released on the host.
    plan_.rows = {}, plan_.particle = {}, plan_.above = {}, plan_.sum = {}, plan_.from = {};
  }

  /// Rounds and stores a panel of the factor.
  void take(int supernode, const double* numbers) {
    const Panel& panel = plan_.panels[plan_.panel_of[supernode]];
    T* to = values_.to_fill() + panel.at;
    for (int b = 0; b < panel.blocks(); ++b)
      for (int j = 0; j < panel.columns; ++j)
        for (int r = 4 * b; r < 4 * b + 4; ++r)
          *to++ = r < panel.height() ? T(numbers[std::int64_t(j) * panel.height() + r]) : T(0);
  }

  /// Called after the last `take`.
  void send() { values_.send(); }

  /// Scratch memory of a product.
  struct Workspace {
    Array<Executor, Vec4<T>> work, top;
    Array<Executor, char> memory;
    std::size_t bytes() const { return work.bytes() + top.bytes() + memory.bytes(); }
  };
  Workspace workspace(int threads) const {
    Workspace made;
    made.work = Array<Executor, Vec4<T>>(particle_.size(), {});
    made.top = Array<Executor, Vec4<T>>(2 * std::size_t(plan_.most_rows), {});
    made.memory = Array<Executor, char>(memory_bytes_ * threads, 0);
    return made;
  }

  /// Applies S to the forces of `io`, and stores accelerations.
  template <class R>
  void apply(const FilterIo<R>& io) const {
    const Points<R>&force = io.force, &a = io.acceleration;
    const auto key = [&] { return key_from(force.x, force.y, force.z, a.x, a.y, a.z, io.adds); };
    repeated_region(executor_, width_, recorded_, key, [&](const auto& team) { apply(team, own_, io); });
  }

  int launches() const {
    int all = ranges_.empty() ? 2 : 4;
    for (const TopRange& stretch : ranges_) all += stretch.wide ? 5 : 2;
    return all;
  }
  std::int64_t numbers() const { return plan_.values; }
  std::size_t bytes() const {
    return panels_.bytes() + tasks_.bytes() + rows_.bytes() + particle_.bytes() + above_.bytes() + sum_.bytes() +
           from_.bytes() + values_.bytes() + own_.bytes();
  }

  template <class Team, class Io>
  void apply(const Team& team, const Workspace& space, const Io& io) const {
    const int tasks = static_cast<int>(plan_.tasks.size()) - 1;
    const FilterTask& top = plan_.tasks[tasks];
    const SparseView<T> view{panels_.data(),          rows_.data(), values_.data(), tasks_.data(),    tasks,
                             above_.data(),           sum_.data(),  from_.data(),   particle_.data(), space.work.data(),
                             values_.bytes() > kCache};
    const ScratchMemory memory{space.memory.data(), memory_bytes_};
    Vec4<T>*first = space.top.data(), *second = first + plan_.most_rows;
    parallel_groups(team, 0, tasks, memory, ForwardTask<T, Io>{view, io});
    if (top.panels > 0) {
      parallel_pieces(team, top.own, kTopPlaces, SumTop<T, Io>{view, io});
      for (const TopRange& stretch : ranges_) forward_solve(team, view, stretch, memory, first);
      for (auto stretch = ranges_.rbegin(); stretch != ranges_.rend(); ++stretch)
        backward_solve(team, view, *stretch, memory, first, second);
      parallel_pieces(team, top.own, kTopPlaces, ScatterRoot<T, Io>{view, io});
    }
    parallel_groups(team, 0, tasks, memory, BackwardTask<T, Io>{view, io});
  }

 private:
  static constexpr std::size_t kCache = 4 << 20;  // a core's own caches, roughly: smaller panels stay there
  static constexpr std::int64_t kGrain = 16384;   // entries of panels per thread at least, some microseconds

  /// Panels of the top that one thread solves in order, or a single wide one for all threads.
  struct TopRange {
    int begin, end;
    bool wide;
  };
  static constexpr std::int64_t kWide = 8192;  // entries: as much time as the launches of a parallel solve

  void find_top_ranges() {
    const FilterTask& top = plan_.tasks.back();
    for (int p = top.panel; p < top.panel + top.panels; ++p) {
      const bool wide = std::int64_t(plan_.panels[p].columns) * plan_.panels[p].height() > kWide;
      if (wide || ranges_.empty() || ranges_.back().wide) ranges_.push_back({p, p, wide});
      ranges_.back().end = p + 1;
    }
  }

  template <class Team>
  void forward_solve(const Team& team, const SparseView<T>& view, const TopRange& stretch, const ScratchMemory& memory,
                     Vec4<T>* rows) const {
    if (!stretch.wide)
      return parallel_groups(team, 0, 1, memory, SolveRootSmall<T, true>{view, stretch.begin, stretch.end});
    const Panel& panel = plan_.panels[stretch.begin];
    parallel_groups(team, 0, pieces(panel.blocks()), memory, ForwardTop<T>{view, panel, rows});
    parallel_pieces(team, panel.columns, kTopPlaces, StoreRoot<T>{view, panel, rows});
  }
  template <class Team>
  void backward_solve(const Team& team, const SparseView<T>& view, const TopRange& stretch, const ScratchMemory& memory,
                      Vec4<T>* rows, Vec4<T>* own) const {
    if (!stretch.wide)
      return parallel_groups(team, 0, 1, memory, SolveRootSmall<T, false>{view, stretch.begin, stretch.end});
    const Panel& panel = plan_.panels[stretch.begin];
    parallel_pieces(team, 4 * panel.blocks(), kTopPlaces, GatherTop<T>{view, panel, rows});
    parallel_groups(team, 0, pieces(panel.columns), memory, BackwardTop<T>{view, panel, rows, own});
    parallel_pieces(team, panel.columns, kTopPlaces, StoreRoot<T>{view, panel, own});
  }

  static constexpr int kTopPlaces = 128;  // of the top that are copied together
  static int pieces(int items) { return (items + kTopPiece - 1) / kTopPiece; }

  Executor executor_;
  SparsePlan plan_;
  std::vector<TopRange> ranges_;  // of the top
  Array<Executor, Panel> panels_;
  Array<Executor, FilterTask> tasks_;
  Array<Executor, int> rows_, particle_, above_, sum_, from_;
  FilledArray<Executor, T> values_;
  Workspace own_;
  mutable Recording<Executor> recorded_;  // products
  std::size_t memory_bytes_ = 0;
  int width_ = 1;
};

}  // namespace malha
