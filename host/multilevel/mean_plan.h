// SPDX-License-Identifier: Apache-2.0
// Means laid out in runs: those side by side that read what lies side by side, with the same weights.
#pragma once
#include <vector>

#include "host/model/rest_graph.h"
#include "kernels/multilevel/transfer.h"
#include "kernels/projection/patch.h"

namespace malha {

/// A mean and where it goes.
struct Goal {
  int mean, to;
};

struct MeanPlan {
  std::vector<int> begin{0};  // of each piece, and one more
  std::vector<MeanRun> runs;
  std::vector<MeanTerm<double>> terms;
  int means = 0;
  /// Whether packs of them are worth while.
  bool in_columns() const { return means >= 4 * static_cast<int>(runs.size()); }
};

/// `pieces`: goals in the order in which they are worked on.
MeanPlan plan_means(const Means& means, const std::vector<std::vector<Goal>>& pieces);

/// Every mean at its own number, in pieces of `size`.
std::vector<std::vector<Goal>> goals_in_order(const Means& means, int size);

/// A mean for each particle that a patch is the first to visit, at its place in the patch's memory.
std::vector<std::vector<Goal>> goals_by_patch(const std::vector<Patch>& patches, const std::vector<Segment>& segments);

/// Means of particles as sums of parts, each of places in the memory of the patch that is the last to visit them. The
/// first part of mean r is at r; further ones are at `means` and above.
struct MeanParts {
  MeanPlan plan;           // patch by patch
  std::vector<int> mean;   // means of several parts
  std::vector<int> begin;  // the further parts of each, and one more
};
MeanParts plan_parts(const Means& means, const std::vector<Patch>& patches, const std::vector<Segment>& segments);

}  // namespace malha
