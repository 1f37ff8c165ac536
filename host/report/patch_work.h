// What the patches of a plan have to do, and the particles that they share, for what counts and deals them.
#pragma once
#include <cstdint>
#include <vector>

#include "host/model/model.h"
#include "host/solver/patch_plan.h"

namespace malha {

/// Of each patch of the plan.
struct PatchWork {
  std::vector<std::int64_t> projections;  // one way, without the gaps of runs
  std::vector<int> phase, particles;      // particles: the movable ones that it is the last to visit

  explicit PatchWork(const PatchPlan& plan);
  /// In an iteration, where both take about as long.
  std::int64_t both(std::size_t patch) const { return 2 * projections[patch] + particles[patch] + 1; }
};

/// The movable particles that several patches visit, and their visits in the order of an iteration.
struct SharedParticles {
  struct Visit {
    int patch, of;  // of: which of visits_of(phases)
  };
  std::vector<int> begin{0};
  std::vector<Visit> visits;

  SharedParticles(const Model& model, const PatchPlan& plan);
  int count() const { return static_cast<int>(begin.size()) - 1; }
  /// The patch that visits it last.
  int last(int particle) const { return visits[begin[particle + 1] - 1].patch; }

  /// Calls work(before, visit) for every visit to each of them, and the patch of the visit before it: that of the last
  /// one for the first.
  template <class Work>
  void for_each(int particle, const Work& work) const {
    int before = last(particle);
    for (int k = begin[particle]; k < begin[particle + 1]; ++k) {
      work(before, visits[k]);
      before = visits[k].patch;
    }
  }
};

}  // namespace malha
