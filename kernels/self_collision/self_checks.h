// SPDX-License-Identifier: Apache-2.0
// Results of checks in self-collision that a device computes in several launches and the host reads at once.
#pragma once
#include "kernels/self_collision/mean_motion.h"
#include "kernels/self_collision/swept_bounds.h"
#include "kernels/self_collision/truncate.h"

namespace malha {

template <class R>
struct SelfChecks {
  MeanMotion mean;
  Vector3<R> common;  // the mean, rounded to R, m
  BoundsViolations stay;
  ViolationCount violations;
};

/// Rounds the mean motion; one item.
template <class R>
struct StoreCommonMotion {
  SelfChecks<R>* checks;
  KERNEL void operator()(int) const { checks->common = rounded<R>(checks->mean.value()); }
};

}  // namespace malha
