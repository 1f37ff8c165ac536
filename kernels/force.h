// Multipliers handed down: the force of a coarse constraint, shared by the finer ones that it stands for.
#pragma once
#include "kernels/means.h"

namespace malha {

/// lambda of slot i = sum of weight * (the coarse lambda at `from`) over the terms begin[i] .. begin[i + 1] - 1.
template <class R>
struct HandDownForces {
  const int* begin;
  const MeanTerm<R>* terms;
  const R* coarse;
  R* lambda;
  KERNEL void operator()(int i) const {
    R sum(0);
    for (int t = begin[i]; t < begin[i + 1]; ++t) sum += terms[t].weight * coarse[terms[t].from];
    lambda[i] = sum;
  }
};

}  // namespace malha
