// SPDX-License-Identifier: Apache-2.0
// Gives free bodies back the momenta that their constraints' projections take: angular momentum, where a correction is
// too large to go along the gradient where the substep began (kernels/projection/direction.h), or comes after Desbrun's
// filter, and both by rounding.
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

  /// Between before() and after(), which may be called any number of times in a step, internal forces act, and gravity
  /// on every particle alike. The particles have their state x and v,
  void before(const Particles<R>& particles) { bodies_.template measure<R, false, false>(particles, Measured::Start); }
  /// `gained`: velocity by gravity since the start.
  void after(const Particles<R>& particles, const Vec3& gained) {
    bodies_.template measure<R, false, true>(particles, Measured::Loss, 1, gained);
  }
  /// or are in a substep of h seconds, at p.
  void before_projection(const Particles<R>& particles, double h) {
    bodies_.template measure<R, true, false>(particles, Measured::Start, h);
  }
  void after_projection(const Particles<R>& particles, double h) {
    bodies_.template measure<R, true, false>(particles, Measured::Loss, h);
  }

  /// Bodies of these particles get nothing back: something outside acts on them, or holds them. Between steps.
  void leave_out(const std::vector<int>& particles) {
    std::vector<bool> out;
    for (const FreeIsland& island : islands_)
      out.push_back(std::any_of(particles.begin(), particles.end(),
                                [&](int i) { return i >= island.first && i < island.first + island.count; }));
    bodies_.leave_out(out);
  }

  /// Gives back what was lost since the last time. `known`: the last that was called is after().
  void give_back(const Particles<R>& particles, bool known) {
    if (!known) bodies_.template measure<R, false, true>(particles, Measured::Now);
    bodies_.move(ComputeMomentumCorrection<R>{bodies_.bodies(), bodies_.motions()},
                 AddRigidMotion<R>{particles, bodies_.stretches(), bodies_.motions()});
  }

  std::size_t bytes() const { return bodies_.bytes(); }

 private:
  std::vector<FreeIsland> islands_;
  BodyMomenta<Executor, R> bodies_;
};

}  // namespace malha
