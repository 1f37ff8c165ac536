// SPDX-License-Identifier: Apache-2.0
// Momentum correction of free bodies under Desbrun's filter, one body after the other: two reductions, a 3 x 3 solve,
// one pass.
#pragma once
#include "host/base/array.h"
#include "kernels/filter/corrector.h"
#include "malha/scene.h"

namespace malha {

template <class Executor, class R>
class FilterCorrector {
 public:
  explicit FilterCorrector(const Executor& executor) : executor_(executor), net_(1, NetMotion{}) {}

  /// Removes the mean and, depending on `how`, the net torque from the accelerations of a body by internal forces,
  /// without synchronisation.
  void correct(const FilteredBody<R>& body, int count, Corrector how) {
    NetMotion* const net = net_.data();
    measure(body, count, how, net);
    parallel_for(executor_, count, RemoveRigid<R>{body, net, how == Corrector::Paper});
  }

  /// Measures the rigid part of the accelerations, or of another field in their place.
  void measure(const FilteredBody<R>& body, int count, Corrector how, NetMotion* net) {
    parallel_reduce_into(executor_, count, SumMass<R>{body}, &net->mass);
    parallel_for(executor_, 1, ComputeMeanMotion{net});
    if (how == Corrector::Off) return;
    parallel_reduce_into(executor_, count, SumTorque<R>{body, net}, &net->spin);
    parallel_for(executor_, 1, ComputeAngularAcceleration{net, how == Corrector::Paper});
  }

 private:
  Executor executor_;
  Array<Executor, NetMotion> net_;
};

}  // namespace malha
