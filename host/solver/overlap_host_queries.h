// SPDX-License-Identifier: Apache-2.0
// While the host asks Embree about some particles, a device goes on with the patches that have none of them: with the
// first phase of the visits that come next. On the host there is nothing of this.
#pragma once
#include "host/patch/sweep.h"
#include "kernels/patch/solve_patch.h"

namespace malha {

/// Whether nothing of the method moves particles between contacts with meshes and the first visits.
inline bool solve_is_next(const Model& model, const SolverStats& facts) {
  return !model.sets.empty() && facts.levels.empty() && !facts.filter;
}

template <class Executor, class R>
class EarlyVisits {
 public:
  /// The visits of a sweep to what does not wait for the answers.
  void begin(const Executor& executor, const Sweep<Executor, R>& sweep, const SolvePatch<R>& visit,
             const ActiveMask& questions) {
    if (waits_.size() == 0) waits_ = Array<Executor, bool>(static_cast<std::size_t>(sweep.facts().patches));
    parallel_for(executor, sweep.facts().patches,
                 MarkDeferredPatches{visit.patches, visit.segments, questions, waits_.data()});
    sweep.region([&](const auto& team) { sweep.visit_first(team, MaskedSolvePatch<R>{visit, waits_.data(), false}); });
    begun_ = true;
  }

  /// All visits of a sweep, but for those that were begun.
  void go_on(const Sweep<Executor, R>& sweep, const SolvePatch<R>& visit) {
    const auto key = [&] {
      const Particles<R>& all = visit.particles;
      const Vector3<R>& g = visit.gravity;
      return key_from(all.x.x, all.v.x, all.p.d.x, all.w, visit.dt, g.x, g.y, g.z, visit.first_iteration, begun_);
    };
    sweep.region(recorded_, key, [&](const auto& team) {
      if constexpr (!Memory<Executor>::kOfTheHost)
        if (begun_) {
          sweep.visit_first(team, MaskedSolvePatch<R>{visit, waits_.data(), true});
          return sweep.visit_others(team, visit);
        }
      sweep(team, visit);
    });
    begun_ = false;
  }

 private:
  Array<Executor, bool> waits_;   // of each patch
  Recording<Executor> recorded_;  // visits that go on
  bool begun_ = false;
};

}  // namespace malha
