// SPDX-License-Identifier: Apache-2.0
// Kernels of a stable radix sort and of prefix sums. The partition depends on the number of items alone, so that
// results do not depend on the number of threads.
#pragma once
#include "kernels/parallel/compute.h"

namespace malha {

inline constexpr int kDigitBits = 11, kDigits = 1 << kDigitBits;

/// A sort key and its value.
struct Keyed {
  unsigned key;
  int value;
};

/// Histogram of a digit in each part.
struct CountDigits {
  const Keyed* items;
  int count, size, shift;  // size: items of a part
  int* of_part;            // kDigits per part
  KERNEL void operator()(int part) const {
    int* const own = of_part + part * kDigits;
    const int begin = part * size, end = begin + size < count ? begin + size : count;
    for (int d = 0; d < kDigits; ++d) own[d] = 0;
    for (int i = begin; i < end; ++i) ++own[(items[i].key >> shift) & (kDigits - 1)];
  }
};

/// Exclusive prefix sum of the histograms, digit by digit and part by part. Launched with one item.
struct PlaceDigits {
  int parts;
  int* of_part;
  KERNEL void operator()(int) const {
    int place = 0;
    for (int d = 0; d < kDigits; ++d)
      for (int part = 0; part < parts; ++part) {
        const int count = of_part[part * kDigits + d];
        of_part[part * kDigits + d] = place;
        place += count;
      }
  }
};

/// Scatters the items of each part to their sorted positions.
struct MoveByDigit {
  const Keyed* items;
  Keyed* sorted;
  int count, size, shift;
  int* of_part;
  KERNEL void operator()(int part) const {
    int* const own = of_part + part * kDigits;
    const int begin = part * size, end = begin + size < count ? begin + size : count;
    for (int i = begin; i < end; ++i) sorted[own[(items[i].key >> shift) & (kDigits - 1)]++] = items[i];
  }
};

/// Finds the range begin[key] .. begin[key + 1] - 1 of each key among the sorted items. Launched with `count` + 1
/// items.
struct FindBegins {
  const Keyed* sorted;
  int count, keys;
  int* begin;
  KERNEL void operator()(int i) const {
    const int from = i == 0 ? 0 : int(sorted[i - 1].key) + 1, to = i == count ? keys : int(sorted[i].key);
    for (int key = from; key <= to; ++key) begin[key] = i;
  }
};

/// Sum of each part's values.
struct SumPart {
  const int* values;
  int count, size;
  int* of_part;
  KERNEL void operator()(int part) const {
    const int begin = part * size, end = begin + size < count ? begin + size : count;
    int sum = 0;
    for (int i = begin; i < end; ++i) sum += values[i];
    of_part[part] = sum;
  }
};

/// Exclusive prefix sum of the parts, with the total behind the last. Launched with one item.
struct SumParts {
  int parts;
  int* of_part;
  KERNEL void operator()(int) const {
    int sum = 0;
    for (int part = 0; part <= parts; ++part) {
      const int own = part < parts ? of_part[part] : 0;
      of_part[part] = sum;
      sum += own;
    }
  }
};

/// Exclusive prefix sum of the values, from those of the parts.
struct SumBefore {
  int* values;
  int count, size;
  const int* of_part;
  KERNEL void operator()(int part) const {
    const int begin = part * size, end = begin + size < count ? begin + size : count;
    int sum = of_part[part];
    for (int i = begin; i < end; ++i) {
      const int own = values[i];
      values[i] = sum;
      sum += own;
    }
  }
};

}  // namespace malha
