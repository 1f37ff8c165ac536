// SPDX-License-Identifier: Apache-2.0
// What the host decides by while bodies are kept apart: launches find it, and it is read at once.
#pragma once
#include "kernels/self_collision/swept_bounds.h"
#include "kernels/self_collision/truncate.h"

namespace malha {

template <class R>
struct SelfChecks {
  MeanMotion mean;
  Vector3<R> common;  // as a motion in R, m
  BoundsViolations stay;
  ViolationCount left;
};

/// One item.
template <class R>
struct StoreCommonMotion {
  SelfChecks<R>* checks;
  KERNEL void operator()(int) const { checks->common = rounded<R>(checks->mean.value()); }
};

}  // namespace malha
