// SPDX-License-Identifier: Apache-2.0
// Excess over maximal lengths: those of distance limits after an iteration, and those at which edges tear after a step.
#pragma once
#include <vector>

#include "host/base/array.h"
#include "host/model/tear.h"
#include "kernels/constraints/constraint_registry.h"
#include "kernels/measure/over_elongation.h"
#include "kernels/projection/rest.h"

namespace malha {

template <class Executor, class R>
class LengthLimits {
 public:
  LengthLimits(const Executor& executor, const Model& model) : executor_(executor) {
    std::vector<int> ends;
    std::vector<R> longest;
    for (const ConstraintSet& set : model.sets) {
      if (set.type != DistanceLimit::name) continue;
      ends.insert(ends.end(), set.particles.begin(), set.particles.end());
      for (int c = 0; c < set.count(); ++c)
        longest.push_back(
            R(rest_value<DistanceLimit>(rest_positions(model, set), c, material_of<DistanceLimit>(set, c))));
    }
    ends_ = Array<Executor, int>(ends), longest_ = Array<Executor, R>(longest);
  }
  LengthLimits(const Executor& executor, const TearableEdges& edges) : executor_(executor) {
    std::vector<int> ends;
    for (const Edge& e : edges.ends) ends.insert(ends.end(), e.begin(), e.end());
    ends_ = Array<Executor, int>(ends);
    longest_ = Array<Executor, R>(std::vector<R>(edges.max_length.begin(), edges.max_length.end()));
  }

  /// The largest excess over a maximal length, relative to it; 0: none is exceeded.
  template <class At>
  double excess(const At& p) const {
    return parallel_reduce<Largest>(executor_, static_cast<int>(longest_.size()),
                                    MeasureExcess<R, At>{p, ends_.data(), longest_.data()})
        .value;
  }
  std::size_t bytes() const { return ends_.bytes() + longest_.bytes(); }

 private:
  Executor executor_;
  Array<Executor, int> ends_;
  Array<Executor, R> longest_;
};

}  // namespace malha
