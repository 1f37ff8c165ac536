// SPDX-License-Identifier: Apache-2.0
// Contact caches as a saved state holds them: what later substeps depend on, of all pairs of particles and meshes.
#pragma once
#include <vector>

#include "kernels/environment/proximity_cache.h"

namespace malha {

/// Contact caches, mesh after mesh. Empty: nothing was queried.
struct ProximityMemory {
  std::vector<GroupBox> boxes;      // of each group; groups far away have nothing else
  std::vector<CacheEntry> entries;  // of each particle of the groups with entries
  std::vector<PairRecord> near;     // of particles with a slot, in ascending order of pairs

  std::size_t box_count() const { return boxes.size(); }
  std::size_t near_count() const { return near.size(); }
  std::size_t max_entries() const { return entries.size(); }
  /// Passes on the parts in the order in which a state holds them.
  template <class F>
  void for_each_part(const F& f) const {
    f(boxes), f(entries), f(near);
  }
  void add(const std::vector<GroupBox>& part) { boxes.insert(boxes.end(), part.begin(), part.end()); }
  void add(const std::vector<CacheEntry>& part) { entries.insert(entries.end(), part.begin(), part.end()); }
  void add(const std::vector<PairRecord>& part) { near.insert(near.end(), part.begin(), part.end()); }
};

/// The number of groups of this many particles.
inline std::size_t groups_of(std::size_t particles) { return (particles + kGroupSize - 1) / kGroupSize; }
/// The number of particles in a group.
inline int particles_in_group(std::size_t group, std::size_t particles) {
  const std::size_t left = particles - group * kGroupSize;
  return static_cast<int>(left < kGroupSize ? left : kGroupSize);
}

/// The number of entries of one mesh, whose first box is boxes[0].
inline std::size_t count_entries(const GroupBox* boxes, std::size_t particles) {
  std::size_t sum = 0;
  for (std::size_t group = 0; group < groups_of(particles); ++group)
    if (boxes[group].has_entries()) sum += static_cast<std::size_t>(particles_in_group(group, particles));
  return sum;
}

}  // namespace malha
