// SPDX-License-Identifier: Apache-2.0
#include "host/filter/sparse_filter.h"

#include <algorithm>

namespace malha {

namespace {

class Planner {
 public:
  Planner(const SpringSystem& system, const Supernodes& all, const Subtrees& cut)
      : system_(system), all_(all), top_place_(system.count(), -1), place_(system.count(), -1) {
    plan_.panel_of.resize(all.count());
    int top = 0;
    each_column(cut.top, [&](int j) { top_place_[j] = top++; });
    contributions_.resize(top);
    for (const std::vector<int>& task : cut.tasks) add_task(task);
    add_task(cut.top);
    plan_.sum = {0};
    for (const std::vector<int>& from : contributions_) {
      plan_.from.insert(plan_.from.end(), from.begin(), from.end());
      plan_.sum.push_back(static_cast<int>(plan_.from.size()));
    }
  }
  SparsePlan take() { return std::move(plan_); }

 private:
  template <class Visit>
  void each_column(const std::vector<int>& supernodes, const Visit& visit) const {
    for (const int s : supernodes)
      for (int j = all_.column_begin[s]; j < all_.column_begin[s + 1]; ++j) visit(j);
  }

  void add_task(const std::vector<int>& supernodes) {
    FilterTask task{};
    task.panel = static_cast<int>(plan_.panels.size()), task.panels = static_cast<int>(supernodes.size());
    task.base = static_cast<int>(plan_.particle.size()), task.list = static_cast<int>(plan_.above.size());
    each_column(supernodes, [&](int j) {
      place_[j] = task.own++;
      plan_.particle.push_back(system_.particle[all_.order[j]]);
    });
    std::vector<int> seen;
    for (const int s : supernodes) {
      add_panel(s);
      for (int k = all_.row_begin[s]; k < all_.row_begin[s + 1]; ++k) {
        const int j = all_.rows[k];
        if (place_[j] < 0) {  // the column belongs to an ancestor in the top
          place_[j] = task.own + task.above++;
          seen.push_back(j);
          plan_.above.push_back(top_place_[j]);
          contributions_[top_place_[j]].push_back(task.base + place_[j]);
          plan_.particle.push_back(-1);
        }
        plan_.rows.push_back(place_[j]);
      }
    }
    for (const int j : seen) place_[j] = -1;
    plan_.tasks.push_back(task);
  }

  void add_panel(int s) {
    plan_.panel_of[s] = static_cast<int>(plan_.panels.size());
    const Panel panel{place_[all_.column_begin[s]], all_.columns(s), all_.below(s), static_cast<int>(plan_.rows.size()),
                      plan_.values};
    plan_.panels.push_back(panel);
    plan_.values += 4ll * panel.blocks() * panel.columns;
    plan_.most_rows = std::max(plan_.most_rows, 4 * panel.blocks());
  }

  const SpringSystem& system_;
  const Supernodes& all_;
  std::vector<int> top_place_;                   // the place of each column of the top in the top's segment
  std::vector<int> place_;                       // the place of each column in the segment of the present task
  std::vector<std::vector<int>> contributions_;  // to each place of the top, in the order of tasks
  SparsePlan plan_;
};

}  // namespace

SparsePlan plan_sparse(const SpringSystem& system, const Supernodes& all, const Subtrees& cut) {
  return Planner(system, all, cut).take();
}

}  // namespace malha
