// SPDX-License-Identifier: Apache-2.0
// Radix sort and prefix sums (kernels/parallel/sort.h), with their memory.
#pragma once
#include "host/base/scratch_buffer.h"
#include "kernels/parallel/sort.h"

namespace malha {

/// Partition of items, which depends on their number alone.
struct WorkParts {
  explicit WorkParts(int items) {
    count = items / kLeast < 1 ? 1 : items / kLeast < kMost ? items / kLeast : kMost;
    size = (items + count - 1) / count;
  }
  int count, size;
  static constexpr int kLeast = 8192, kMost = 64;
};

/// Exclusive prefix sum of the values in place; returns their total.
template <class Executor>
int running_sum(const Executor& executor, int* values, int count, ScratchBuffer<Executor, int>& memory) {
  const WorkParts parts(count);
  int* const of_part = memory.at_least(parts.count + 1);
  parallel_for(executor, parts.count, SumPart{values, count, parts.size, of_part}, 1);
  parallel_for(executor, 1, SumParts{parts.count, of_part});
  parallel_for(executor, parts.count, SumBefore{values, count, parts.size, of_part}, 1);
  int sum = 0;
  Memory<Executor>::copy_out(of_part + parts.count, 1, &sum);
  return sum;
}

/// Sorts items by keys, and finds the range of each key.
template <class Executor>
class Sorter {
 public:
  /// Buffer for `count` items, to be filled before sort().
  Keyed* items(int count) {
    from_ = 0;
    return sides_[0].at_least(count);
  }

  /// Sorts them; keys are below 2^bits and below `keys`.
  void sort(const Executor& executor, int count, int bits, int keys) {
    const WorkParts parts(count);
    int* const of_part = of_part_.at_least(std::size_t(parts.count) * kDigits);
    for (int shift = 0; shift < bits; shift += kDigitBits) {
      const Keyed* const items = sides_[from_].data();
      Keyed* const sorted = sides_[1 - from_].at_least(count);
      parallel_for(executor, parts.count, CountDigits{items, count, parts.size, shift, of_part}, 1);
      parallel_for(executor, 1, PlaceDigits{parts.count, of_part});
      parallel_for(executor, parts.count, MoveByDigit{items, sorted, count, parts.size, shift, of_part}, 1);
      from_ = 1 - from_;
    }
    parallel_for(executor, count + 1, FindBegins{sorted(), count, keys, begin_.at_least(std::size_t(keys) + 1)});
  }

  const Keyed* sorted() const { return sides_[from_].data(); }
  const int* begin() const { return begin_.data(); }
  std::size_t bytes() const { return sides_[0].bytes() + sides_[1].bytes() + of_part_.bytes() + begin_.bytes(); }

 private:
  ScratchBuffer<Executor, Keyed> sides_[2];
  ScratchBuffer<Executor, int> of_part_, begin_;
  int from_ = 0;
};

}  // namespace malha
