// SPDX-License-Identifier: Apache-2.0
// Damping of connected bodies that preserves rigid motion: one measurement, a 3 x 3 solve per body, one pass.
#pragma once
#include <vector>

#include "host/forces/body_momenta.h"
#include "host/model/model.h"
#include "host/projection/stiffness.h"
#include "kernels/forces/momenta.h"

namespace malha {

template <class Executor, class R>
class Damping {
 public:
  /// Damping of each body in [0, 1], per step of so many substeps. Pinned particles neither count nor move.
  Damping(const Executor& executor, const std::vector<DampedIsland>& islands, int substeps)
      : bodies_(executor, islands) {
    std::vector<R> k;
    for (const DampedIsland& island : islands) k.push_back(R(stiffness_per_projection(island.damping, substeps)));
    k_ = Array<Executor, R>(k);
  }

  /// Damps v in a substep. Sums are in double: in float they would change momenta.
  void damp(const Particles<R>& particles) {
    bodies_.template measure<double, false, true>(particles, Measured::Now);
    bodies_.move(ComputeRigidMotion<R>{bodies_.bodies(), bodies_.motions()},
                 DampTowardsRigid<R>{particles, bodies_.ranges(), bodies_.motions(), k_.data()});
  }

  std::size_t bytes() const { return bodies_.bytes() + k_.bytes(); }

 private:
  BodyMomenta<Executor, R> bodies_;
  Array<Executor, R> k_;
};

}  // namespace malha
