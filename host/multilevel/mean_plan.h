// SPDX-License-Identifier: Apache-2.0
// Layout of restriction and prolongation: consecutive means of consecutive terms with the same weights form runs.
#pragma once
#include <vector>

#include "host/model/rest_graph.h"
#include "kernels/multilevel/transfer.h"
#include "kernels/projection/patch.h"

namespace malha {

/// A mean and the index where it is stored.
struct Goal {
  int mean, to;
};

struct MeanPlan {
  std::vector<int> begin{0};  // first run of each piece, and the number of runs
  std::vector<MeanRun> runs;
  std::vector<MeanTerm<double>> terms;
  int means = 0;
  /// Tells whether runs are long enough for packs.
  bool in_columns() const { return means >= 4 * static_cast<int>(runs.size()); }
};

/// `pieces`: goals in the order of their computation.
MeanPlan plan_means(const Means& means, const std::vector<std::vector<Goal>>& pieces);

/// A goal for every mean at its own index, in pieces of `size`.
std::vector<std::vector<Goal>> goals_in_order(const Means& means, int size);

/// A goal for each particle in the patch that solves it first, at its slot of the patch's memory.
std::vector<std::vector<Goal>> goals_by_patch(const std::vector<Patch>& patches, const std::vector<Segment>& segments);

/// Means as sums of partial sums, each over slots of the patch that solves those particles last. The first part of mean
/// r is at r; further ones are behind all means.
struct MeanParts {
  MeanPlan plan;           // patch by patch
  std::vector<int> mean;   // means of several parts
  std::vector<int> begin;  // first further part of each, and the end
};
MeanParts plan_parts(const Means& means, const std::vector<Patch>& patches, const std::vector<Segment>& segments);

}  // namespace malha
