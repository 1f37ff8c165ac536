// SPDX-License-Identifier: Apache-2.0
// Search for equal items of a list by hashing.
#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "malha/mesh.h"

namespace malha {

/// For each of `count` items the first item that equals it, which may be itself. It takes linear time, with an open
/// hash table that is at most half full. `hash(i)` returns 64 bits, which need not be well distributed; `equal(i, j)`
/// compares two items.
template <class Hash, class Equal>
std::vector<int> first_equal(int count, Hash hash, Equal equal) {
  const std::uint64_t slots = std::bit_ceil(2 * static_cast<std::uint64_t>(count) + 1);
  const int shift = 64 - std::countr_zero(slots);
  std::vector<int> table(slots, -1);
  std::vector<int> first(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    // In Fibonacci hashing the high bits of the product depend on all bits of the hash.
    std::uint64_t slot = shift < 64 ? (hash(i) * 0x9E3779B97F4A7C15u) >> shift : 0;
    while (table[slot] >= 0 && !equal(table[slot], i)) slot = (slot + 1) & (slots - 1);
    if (table[slot] < 0) table[slot] = i;
    first[i] = table[slot];
  }
  return first;
}

/// Combines a hash with a further value.
inline std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * 0xD6E8FEB86659FD93u;
  return hash ^ (hash >> 32);
}

/// For each point the first point with exactly the same position (-0 equals 0).
inline std::vector<int> first_at_same_position(const std::vector<Vec3>& points) {
  const auto hash = [&](int i) {
    std::uint64_t bits = 0;
    for (const double value : points[i]) bits = mix(bits, std::bit_cast<std::uint64_t>(value + 0.0));
    return bits;
  };
  const auto equal = [&](int i, int j) { return points[i] == points[j]; };
  return first_equal(static_cast<int>(points.size()), hash, equal);
}

/// For each face or side of one the first with the same corners, in any order.
template <class Corners>
std::vector<int> first_of_same_corners(std::vector<Corners> items) {
  for (Corners& corners : items) std::ranges::sort(corners);
  const auto hash = [&](int i) {
    std::uint64_t bits = 0;
    for (const int corner : items[i]) bits = mix(bits, static_cast<std::uint64_t>(corner));
    return bits;
  };
  const auto equal = [&](int i, int j) { return items[i] == items[j]; };
  return first_equal(static_cast<int>(items.size()), hash, equal);
}

}  // namespace malha
