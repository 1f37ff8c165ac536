// SPDX-License-Identifier: Apache-2.0
// Layout of a set's rest values: once per batch where all are the same, otherwise by slot.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/projection/patch.h"

namespace malha {

template <class R>
struct RestValues {
  std::vector<R> each, common;
  std::vector<unsigned short> valid;

  /// `by_slot`: rest values of set `set`, `rest_values` per slot, NaN for padding. Sets the offsets in its batches.
  RestValues(const std::vector<R>& by_slot, int rest_values, int set, std::vector<Batch>& batches)
      : rest_values_(rest_values) {
    for (Batch& batch : batches)
      if (batch.set == set) add(by_slot.data() + std::size_t(batch.slot) * rest_values, batch);
  }

 private:
  void add(const R* rest, Batch& batch) {
    const int words = (batch.count + kSlotPack - 1) / kSlotPack;
    batch.uniform_rest = batch.run && all_alike(rest, batch.count);
    batch.rests = static_cast<int>(batch.uniform_rest ? valid.size() : each.size());
    if (batch.uniform_rest) {
      batch.common = static_cast<int>(common.size());
      common.insert(common.end(), rest, rest + rest_values_);
    }
    for (int word = 0; word < words; ++word) {
      const R* of = rest + word * kSlotPack * rest_values_;
      if (batch.uniform_rest)
        valid.push_back(bits(of));
      else
        for (int k = 0; k < rest_values_; ++k)
          for (int i = 0; i < kSlotPack; ++i) each.push_back(of[i * rest_values_ + k]);
    }
  }

  unsigned short bits(const R* of) const {
    unsigned set = 0;
    for (int i = 0; i < kSlotPack; ++i) set |= unsigned(!std::isnan(of[i * rest_values_])) << i;
    return static_cast<unsigned short>(set);
  }

  /// A run does not begin with padding.
  bool all_alike(const R* rest, int count) const {
    for (int i = 1; i < count; ++i) {
      const R* of = rest + i * rest_values_;
      if (!std::isnan(of[0]) && !std::equal(of, of + rest_values_, rest)) return false;
    }
    return true;
  }

  int rest_values_;
};

}  // namespace malha
