// SPDX-License-Identifier: Apache-2.0
// The memory of contacts: of pairs of particles and environment meshes, what a state of a run holds for later substeps.
#pragma once
#include <vector>

#include "kernels/environment/contact_cache.h"

namespace malha {

/// Mesh after mesh. Empty: nothing has been seen.
struct ContactMemory {
  std::vector<GroupBox> boxes;     // of each word: what is far has nothing else
  std::vector<CacheEntry> places;  // of each particle of the words that no box tells of
  std::vector<PairRecord> near;   // of what is near, ascending

  std::size_t box_count() const { return boxes.size(); }
  std::size_t near_count() const { return near.size(); }
  std::size_t max_entries() const { return places.size(); }
  /// Part after part, as a state holds them.
  template <class Take>
  void tell(const Take& take) const {
    take(boxes), take(places), take(near);
  }
  void add(const std::vector<GroupBox>& part) { boxes.insert(boxes.end(), part.begin(), part.end()); }
  void add(const std::vector<CacheEntry>& part) { places.insert(places.end(), part.begin(), part.end()); }
  void add(const std::vector<PairRecord>& part) { near.insert(near.end(), part.begin(), part.end()); }
};

/// The number of words that hold so many particles.
inline std::size_t words_of(std::size_t particles) { return (particles + kGroupSize - 1) / kGroupSize; }
/// The number of them in one of the words.
inline int particles_in(std::size_t word, std::size_t particles) {
  const std::size_t left = particles - word * kGroupSize;
  return static_cast<int>(left < kGroupSize ? left : kGroupSize);
}

/// The number of places of one mesh, whose first box this is.
inline std::size_t places_of(const GroupBox* boxes, std::size_t particles) {
  std::size_t sum = 0;
  for (std::size_t word = 0; word < words_of(particles); ++word)
    if (boxes[word].has_entries()) sum += static_cast<std::size_t>(particles_in(word, particles));
  return sum;
}

}  // namespace malha
