// What the host decides by while bodies are kept apart: launches find it, and it is read at once.
#pragma once
#include "kernels/pair_hold.h"
#include "kernels/pair_reach.h"

namespace malha {

template <class R>
struct SelfChecks {
  MeanMotion mean;
  Vector3<R> common;  // as a motion in R, m
  Stay stay;
  PairsLeft left;
};

/// One item.
template <class R>
struct FindCommon {
  SelfChecks<R>* checks;
  KERNEL void operator()(int) const { checks->common = rounded<R>(checks->mean.value()); }
};

}  // namespace malha
