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
class OverlapHostQueries {
 public:
  /// The visits of a sweep to what does not wait for the answers.
  void begin(const Executor& executor, const Sweep<Executor, R>& sweep, const SolvePatch<R>& solve,
             const ActiveMask& questions) {
    if (deferred_.size() == 0) deferred_ = Array<Executor, bool>(static_cast<std::size_t>(sweep.facts().patches));
    parallel_for(executor, sweep.facts().patches,
                 MarkDeferredPatches{solve.patches, solve.segments, questions, deferred_.data()});
    sweep.region([&](const auto& team) {
      sweep.solve_first_phase(team, MaskedSolvePatch<R>{solve, deferred_.data(), false});
    });
    begun_ = true;
  }

  /// All visits of a sweep, but for those that were begun.
  void go_on(const Sweep<Executor, R>& sweep, const SolvePatch<R>& solve) {
    const auto key = [&] {
      const Particles<R>& all = solve.particles;
      const Vector3<R>& g = solve.gravity;
      return key_from(all.x.x, all.v.x, all.p.d.x, all.w, solve.dt, g.x, g.y, g.z, solve.first_iteration, begun_);
    };
    sweep.region(recorded_, key, [&](const auto& team) {
      if constexpr (!Memory<Executor>::kOfTheHost)
        if (begun_) {
          sweep.solve_first_phase(team, MaskedSolvePatch<R>{solve, deferred_.data(), true});
          return sweep.solve_other_phases(team, solve);
        }
      sweep(team, solve);
    });
    begun_ = false;
  }

 private:
  Array<Executor, bool> deferred_;  // of each patch
  Recording<Executor> recorded_;    // visits that go on
  bool begun_ = false;
};

}  // namespace malha
