// The rest values of a set as its batches read them: once a batch where they are all alike.
#pragma once
#include <cmath>
#include <vector>

#include "kernels/patch.h"

namespace malha {

template <class R>
struct RestValues {
  std::vector<R> each;
  std::vector<unsigned short> held;

  /// `by_slot`: of set `set`, NaN for padding. Notes in its batches where they find theirs.
  RestValues(const std::vector<R>& by_slot, int set, std::vector<Batch>& batches) {
    for (Batch& batch : batches)
      if (batch.set == set) add(by_slot.data() + batch.slot, batch);
  }

 private:
  void add(const R* rest, Batch& batch) {
    const int words = (batch.count + kSlotPack - 1) / kSlotPack, slots = words * kSlotPack;
    batch.alike = batch.run && all_alike(rest, batch.count);
    batch.rests = static_cast<int>(batch.alike ? held.size() : each.size());
    if (!batch.alike) {
      each.insert(each.end(), rest, rest + slots);
      return;
    }
    batch.rest = rest[0];
    for (int word = 0; word < words; ++word) {
      unsigned bits = 0;
      for (int i = 0; i < kSlotPack; ++i) bits |= unsigned(!std::isnan(rest[word * kSlotPack + i])) << i;
      held.push_back(static_cast<unsigned short>(bits));
    }
  }

  /// A run does not begin with padding.
  static bool all_alike(const R* rest, int count) {
    for (int i = 1; i < count; ++i)
      if (!std::isnan(rest[i]) && rest[i] != rest[0]) return false;
    return true;
  }
};

}  // namespace malha
