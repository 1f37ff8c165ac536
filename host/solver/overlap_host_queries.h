// SPDX-License-Identifier: Apache-2.0
// Overlaps contact queries on the host with patch solves on a device: while the host runs Embree on some particles, the
// device solves the patches of the first colour that have none of them. The host executor does not use this.
#pragma once
#include "host/patch/sweep.h"
#include "kernels/patch/solve_patch.h"

namespace malha {

template <class Executor, class R>
class OverlapHostQueries {
 public:
  /// Launches the solves of a sweep's first colour that do not depend on the queried particles.
  void begin(const Executor& executor, const Sweep<Executor, R>& sweep, const SolvePatch<R>& solve,
             const ActiveMask& queried) {
    if (deferred_.size() == 0) deferred_ = Array<Executor, bool>(static_cast<std::size_t>(sweep.facts().patches));
    parallel_for(executor, sweep.facts().patches,
                 MarkDeferredPatches{solve.patches, solve.segments, queried, deferred_.data()});
    sweep.region([&](const auto& team) {
      sweep.solve_first_colour(team, MaskedSolvePatch<R>{solve, deferred_.data(), false});
    });
    begun_ = true;
  }

  /// Launches a sweep, without the solves that were begun.
  void finish(const Sweep<Executor, R>& sweep, const SolvePatch<R>& solve) {
    const auto key = [&] {
      const Particles<R>& all = solve.particles;
      const Vector3<R>& g = solve.gravity;
      return key_from(all.x.x, all.v.x, all.p.d.x, all.w, solve.dt, g.x, g.y, g.z, solve.first_iteration, begun_);
    };
    sweep.region(recorded_, key, [&](const auto& team) {
      if constexpr (!Memory<Executor>::kOnHost)
        if (begun_) {
          sweep.solve_first_colour(team, MaskedSolvePatch<R>{solve, deferred_.data(), true});
          return sweep.solve_other_colours(team, solve);
        }
      sweep(team, solve);
    });
    begun_ = false;
  }

 private:
  Array<Executor, bool> deferred_;  // of each patch
  Recording<Executor> recorded_;    // the rest of a sweep
  bool begun_ = false;
};

}  // namespace malha
