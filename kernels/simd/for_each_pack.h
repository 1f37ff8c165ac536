// SPDX-License-Identifier: Apache-2.0
// Packs and single particles that cover a number of them.
#pragma once
#include "kernels/parallel/compute.h"
#include "kernels/simd/pack.h"

namespace malha {

/// Calls work(i, T()) for the packs and single particles that cover `count`, some twice.
template <class R, class Group, class Work>
KERNEL void cover(const Group& group, int count, const Work& work) {
  using Isa = typename Group::Isa;
  constexpr int lanes = kLanes<R, Isa>;
  if (count < lanes)
    group.for_each(count, [&](int i) KERNEL_LAMBDA { work(i, R()); });
  else
    group.for_each((count + lanes - 1) / lanes, [&](int pack) KERNEL_LAMBDA {
      const int i = pack * lanes;
      work(i + lanes <= count ? i : count - lanes, Lane<R, Isa>());
    });
}

/// The same, each once.
template <class R, class Group, class Work>
KERNEL void cover_once(const Group& group, int count, const Work& work) {
  using Isa = typename Group::Isa;
  constexpr int lanes = kLanes<R, Isa>;
  const int packs = count / lanes;
  group.for_each(packs, [&](int pack) KERNEL_LAMBDA { work(pack * lanes, Lane<R, Isa>()); });
  group.for_each(count - packs * lanes, [&](int i) KERNEL_LAMBDA { work(packs * lanes + i, R()); });
}

/// The largest of what covers it.
template <class R, class Isa>
struct LargestCovered {
  Lane<R, Isa> of_packs;
  R largest;
  KERNEL explicit LargestCovered(R least) : of_packs(least), largest(least) {}

  template <class T>
  KERNEL void add(const T& number) {
    if constexpr (sizeof(T) == sizeof(of_packs))
      of_packs = max(of_packs, number);
    else
      largest = max(largest, number);
  }
  KERNEL R value() const {
    R all = largest;
    for (int l = 0; l < kLanes<R, Isa>; ++l) all = max(all, lane(of_packs, l));
    return all;
  }
};

}  // namespace malha
