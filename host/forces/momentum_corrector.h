// SPDX-License-Identifier: Apache-2.0
// Momentum correction of free bodies: restores the momenta that projections of constraints change. They change angular
// momentum where a correction is too large for the gradient at the start of the substep
// (kernels/projection/direction.h), or follows Desbrun's filter, and both momenta by rounding.
#pragma once
#include <algorithm>
#include <vector>

#include "host/forces/body_momenta.h"
#include "host/model/model.h"

namespace malha {

template <class Executor, class R>
class MomentumCorrector {
 public:
  MomentumCorrector(const Executor& executor, const Model& model) : islands_(model.free), bodies_(executor, islands_) {}

  /// Only internal forces, and gravity, may act between before() and after(), which may be called any number of times
  /// in a step. Both measure the state x and v.
  void before(const Particles<R>& particles) { bodies_.template measure<R, false, false>(particles, Measured::Start); }
  /// `gained`: change of velocity by gravity since before(), m/s.
  void after(const Particles<R>& particles, const Vec3& gained) {
    bodies_.template measure<R, false, true>(particles, Measured::Loss, 1, gained);
  }
  /// The same within a substep of h seconds, measured at p.
  void before_projection(const Particles<R>& particles, double h) {
    bodies_.template measure<R, true, false>(particles, Measured::Start, h);
  }
  void after_projection(const Particles<R>& particles, double h) {
    bodies_.template measure<R, true, false>(particles, Measured::Loss, h);
  }

  /// Excludes the bodies of these particles, on which external forces or constraints act. Called between steps.
  void exclude(const std::vector<int>& particles) {
    std::vector<bool> out;
    for (const FreeIsland& island : islands_)
      out.push_back(std::any_of(particles.begin(), particles.end(),
                                [&](int i) { return i >= island.first && i < island.first + island.count; }));
    bodies_.exclude(out);
  }

  /// Restores the momenta that were lost since the last call. `known`: the last measurement was after().
  void restore_momenta(const Particles<R>& particles, bool known) {
    if (!known) bodies_.template measure<R, false, true>(particles, Measured::Now);
    bodies_.move(ComputeMomentumCorrection<R>{bodies_.bodies(), bodies_.motions()},
                 AddRigidMotion<R>{particles, bodies_.ranges(), bodies_.motions()});
  }

  std::size_t bytes() const { return bodies_.bytes(); }

 private:
  std::vector<FreeIsland> islands_;
  BodyMomenta<Executor, R> bodies_;
};

}  // namespace malha
