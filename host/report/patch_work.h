// What the patches of a plan have to do, and the particles that they share, for what counts and deals them.
#pragma once
#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "host/solver/patch_plan.h"

namespace malha {

/// Of each patch of the plan.
struct PatchWork {
  std::vector<std::int64_t> projections;  // without the gaps of runs
  std::vector<int> phase, particles;      // particles: the movable ones that it is the last to visit

  explicit PatchWork(const PatchPlan& plan);
  /// Where both take about as long.
  std::int64_t both(std::size_t patch) const { return projections[patch] + particles[patch] + 1; }
};

/// The movable particles that several patches visit, and those patches in the order of a sweep.
struct SharedParticles {
  std::vector<int> begin{0}, patch;

  SharedParticles(const Model& model, const PatchPlan& plan);
  int count() const { return static_cast<int>(begin.size()) - 1; }

  /// Calls visit(before, patch, first) for every visit to each of them, and the patch of the visit before it: that of
  /// the last one for the first.
  template <class Visit>
  void for_each(int particle, const Visit& visit) const {
    int before = patch[begin[particle + 1] - 1];
    for (int k = begin[particle]; k < begin[particle + 1]; ++k) {
      visit(before, patch[k], k == begin[particle]);
      before = patch[k];
    }
  }
};

}  // namespace malha
