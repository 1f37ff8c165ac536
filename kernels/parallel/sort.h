// SPDX-License-Identifier: Apache-2.0
// Integers sorted and summed in parallel. The parts are fixed by the number of items, so that the same comes out of any
// number of threads; sorting is stable.
#pragma once
#include "kernels/parallel/compute.h"

namespace malha {

inline constexpr int kDigitBits = 11, kDigits = 1 << kDigitBits;

/// A key, and what it belongs to.
struct Keyed {
  unsigned key;
  int value;
};

/// How often each value of a digit occurs in each part.
struct CountDigits {
  const Keyed* items;
  int count, size, shift;  // size: items of a part
  int* of_part;            // kDigits a part
  KERNEL void operator()(int part) const {
    int* const own = of_part + part * kDigits;
    const int begin = part * size, end = begin + size < count ? begin + size : count;
    for (int d = 0; d < kDigits; ++d) own[d] = 0;
    for (int i = begin; i < end; ++i) ++own[(items[i].key >> shift) & (kDigits - 1)];
  }
};

/// Turns the counts into places: of a digit, part by part. One item.
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

/// Where the items of each key begin among the sorted ones: begin[key] to begin[key + 1]. `count` + 1 items.
struct FindBegins {
  const Keyed* sorted;
  int count, keys;
  int* begin;
  KERNEL void operator()(int i) const {
    const int from = i == 0 ? 0 : int(sorted[i - 1].key) + 1, to = i == count ? keys : int(sorted[i].key);
    for (int key = from; key <= to; ++key) begin[key] = i;
  }
};

/// The sum of each part's numbers.
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

/// Turns them into the sums of the parts before, and the sum of all behind the last. One item.
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

/// values[i] becomes the sum of those before it.
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
