// SPDX-License-Identifier: Apache-2.0
// The momenta of free bodies under Desbrun's filter, one after the other: two reductions, a 3 x 3 solve, one pass.
#pragma once
#include "host/base/array.h"
#include "kernels/filter/corrector.h"
#include "malha/scene.h"

namespace malha {

template <class Executor, class R>
class FilterCorrector {
 public:
  explicit FilterCorrector(const Executor& executor) : executor_(executor), net_(1, NetMotion{}) {}

  /// Takes the mean, and as `how` says the torque, from the accelerations that internal forces gave a body. Nobody
  /// waits for it.
  void correct(const FilteredBody<R>& body, int count, Corrector how) {
    NetMotion* const net = net_.data();
    parallel_reduce_into(executor_, count, SumMass<R>{body}, &net->mass);
    parallel_for(executor_, 1, FindMean{net});
    if (how != Corrector::Off) {
      parallel_reduce_into(executor_, count, SumTorque<R>{body, net}, &net->spin);
      parallel_for(executor_, 1, FindTurn{net, how == Corrector::Paper});
    }
    if (how == Corrector::Paper)
      parallel_for(executor_, count, RemoveAsPublished<R>{body, net});
    else
      parallel_for(executor_, count, RemoveRigid<R>{body, net});
  }

 private:
  Executor executor_;
  Array<Executor, NetMotion> net_;
};

}  // namespace malha
