// SPDX-License-Identifier: Apache-2.0
// Loops over a range of particles in packs, and the maximum over such a loop.
#pragma once
#include "kernels/parallel/compute.h"
#include "kernels/simd/pack.h"

namespace malha {

/// Calls work(i, T()) for packs that cover 0 .. count - 1. The last pack may overlap the one before it, so that `work`
/// has to be idempotent. A count below the lanes of a pack is done one by one, with T = R.
template <class R, class Group, class Work>
KERNEL void for_each_pack(const Group& group, int count, const Work& work) {
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

/// The same with every index once: whole packs, and then what is left one by one.
template <class R, class Group, class Work>
KERNEL void for_each_pack_once(const Group& group, int count, const Work& work) {
  using Isa = typename Group::Isa;
  constexpr int lanes = kLanes<R, Isa>;
  const int packs = count / lanes;
  group.for_each(packs, [&](int pack) KERNEL_LAMBDA { work(pack * lanes, Lane<R, Isa>()); });
  group.for_each(count - packs * lanes, [&](int i) KERNEL_LAMBDA { work(packs * lanes + i, R()); });
}

/// Maximum over packs and single numbers.
template <class R, class Isa>
struct PackMax {
  Lane<R, Isa> packs;
  R singles;
  KERNEL explicit PackMax(R least) : packs(least), singles(least) {}

  template <class T>
  KERNEL void add(const T& number) {
    if constexpr (sizeof(T) == sizeof(packs))
      packs = max(packs, number);
    else
      singles = max(singles, number);
  }
  KERNEL R value() const {
    R all = singles;
    for (int l = 0; l < kLanes<R, Isa>; ++l) all = max(all, lane(packs, l));
    return all;
  }
};

}  // namespace malha
