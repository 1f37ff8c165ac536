// SPDX-License-Identifier: Apache-2.0
#include "host/multilevel/mean_plan.h"

#include <algorithm>
#include <cmath>

namespace malha {

namespace {

class Planner {
 public:
  explicit Planner(const Means& means) : means_(means) {}

  void add(const Goal& goal, bool new_piece) {
    std::vector<MeanTerm<double>> terms;
    for (int k = means_.begin[goal.mean]; k < means_.begin[goal.mean + 1]; ++k)
      terms.push_back({means_.of[k], std::round(means_.weight[k] * kWeightSteps) / kWeightSteps});
    if (terms.empty()) return;
    ++plan.means;
    std::sort(terms.begin(), terms.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
    if (!new_piece && continues_run(goal, terms)) {
      ++plan.runs.back().count;
      return;
    }
    plan.runs.push_back({goal.to, 1, static_cast<int>(plan.terms.size()), static_cast<int>(terms.size())});
    plan.terms.insert(plan.terms.end(), terms.begin(), terms.end());
  }

  MeanPlan plan;

 private:
  bool continues_run(const Goal& goal, const std::vector<MeanTerm<double>>& terms) const {
    if (plan.runs.empty()) return false;
    const MeanRun& run = plan.runs.back();
    if (goal.to != run.to + run.count || run.terms != static_cast<int>(terms.size())) return false;
    for (int t = 0; t < run.terms; ++t) {
      const MeanTerm<double>& first = plan.terms[run.term + t];
      if (terms[t].from != first.from + run.count || terms[t].weight != first.weight) return false;
    }
    return true;
  }

  // Weights are multiples of 1 over this, far above their rounding errors: those that would be the same without them
  // are the same, and each mean has its own weights, in whatever run it is.
  static constexpr double kWeightSteps = 4294967296.0;
  const Means& means_;
};

/// Sorts the runs of each piece by number of terms, so that the branches of the inner loop are predicted well.
void sort_by_terms(MeanPlan& plan) {
  for (std::size_t piece = 0; piece + 1 < plan.begin.size(); ++piece)
    std::stable_sort(plan.runs.begin() + plan.begin[piece], plan.runs.begin() + plan.begin[piece + 1],
                     [](const MeanRun& a, const MeanRun& b) { return a.terms < b.terms; });
  std::vector<MeanTerm<double>> sorted;
  for (MeanRun& run : plan.runs) {
    const auto first = plan.terms.begin() + run.term;
    run.term = static_cast<int>(sorted.size());
    sorted.insert(sorted.end(), first, first + run.terms);
  }
  plan.terms = std::move(sorted);
}

}  // namespace

MeanPlan plan_means(const Means& means, const std::vector<std::vector<Goal>>& pieces) {
  Planner planner(means);
  for (const std::vector<Goal>& piece : pieces) {
    const auto before = planner.plan.runs.size();
    for (const Goal& goal : piece) planner.add(goal, planner.plan.runs.size() == before);
    planner.plan.begin.push_back(static_cast<int>(planner.plan.runs.size()));
  }
  if (!planner.plan.in_columns()) sort_by_terms(planner.plan);
  return std::move(planner.plan);
}

std::vector<std::vector<Goal>> goals_in_order(const Means& means, int size) {
  std::vector<std::vector<Goal>> pieces;
  for (int i = 0; i < means.count(); ++i) {
    if (i % size == 0) pieces.emplace_back();
    pieces.back().push_back({i, i});
  }
  return pieces;
}

std::vector<std::vector<Goal>> goals_by_patch(const std::vector<Patch>& patches, const std::vector<Segment>& segments) {
  std::vector<std::vector<Goal>> goals;
  for (const Patch& patch : patches) {
    goals.emplace_back();
    for (int s = patch.segment; s < patch.segment + patch.segments; ++s)
      if (segments[s].first_solve && segments[s].movable)
        for (int i = 0; i < segments[s].count; ++i)
          goals.back().push_back({segments[s].global + i, segments[s].local + i});
  }
  return goals;
}

MeanParts plan_parts(const Means& means, const std::vector<Patch>& patches, const std::vector<Segment>& segments) {
  struct Location {
    int patch, slot;
  };
  std::vector<Location> location;
  for (std::size_t k = 0; k < patches.size(); ++k)
    for (int s = patches[k].segment; s < patches[k].segment + patches[k].segments; ++s) {
      const Segment& segment = segments[s];
      if (!segment.last_solve) continue;
      if (location.size() < static_cast<std::size_t>(segment.global + segment.count))
        location.resize(segment.global + segment.count);
      for (int i = 0; i < segment.count; ++i) location[segment.global + i] = {static_cast<int>(k), segment.local + i};
    }
  MeanParts parts;
  Means own;  // the parts
  std::vector<std::vector<Goal>> pieces(patches.size()), further(patches.size());
  int next = means.count();
  parts.begin = {next};
  for (int r = 0; r < means.count(); ++r) {
    const auto first = means.of.begin() + means.begin[r], last = means.of.begin() + means.begin[r + 1];
    std::vector<int> of;  // the patches
    for (auto i = first; i != last; ++i) of.push_back(location[*i].patch);
    std::sort(of.begin(), of.end());
    of.erase(std::unique(of.begin(), of.end()), of.end());
    for (std::size_t k = 0; k < of.size(); ++k) {
      for (auto i = first; i != last; ++i)
        if (location[*i].patch == of[k])
          own.of.push_back(location[*i].slot), own.weight.push_back(means.weight[i - means.of.begin()]);
      (k == 0 ? pieces : further)[of[k]].push_back({own.count(), k == 0 ? r : next++});
      own.begin.push_back(static_cast<int>(own.of.size()));
    }
    if (of.size() > 1) parts.mean.push_back(r), parts.begin.push_back(next);
  }
  for (std::size_t k = 0; k < patches.size(); ++k)
    pieces[k].insert(pieces[k].end(), further[k].begin(), further[k].end());
  parts.plan = plan_means(own, pieces);
  return parts;
}

}  // namespace malha
