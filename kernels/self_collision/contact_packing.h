// SPDX-License-Identifier: Apache-2.0
// Packing of a cluster's pairs into contact blocks, and the list of their particles that is built on the way.
#pragma once
#include "kernels/self_collision/contact_block.h"
#include "kernels/self_collision/swept_distance.h"

namespace malha {

/// Index map of a core while it packs the pairs of a cluster: for each particle its index in the list of particles with
/// a pair (below 0 before and after), that list, and the open blocks that contain each listed particle.
struct DirectIndexMap {
  int particles;

  struct Map {
    int *index, *list;
    OpenBlocks* open_blocks;
    /// Returns the index of a particle in the list, to which it is added if it is not in it. (A HashIndexMap returns a
    /// number below 0 if the list is full.)
    KERNEL int of(int particle, int& listed) const {
      if (index[particle] < 0) index[particle] = listed, list[listed] = particle, open_blocks[listed++] = {};
      return index[particle];
    }
    KERNEL void finish(int listed, const PairPatch& patch, int* patch_particles) const {
      for (int k = 0; k < listed; ++k) {
        index[list[k]] = -1;
        if (listed <= patch.particle_capacity) patch_particles[patch.particles_begin + k] = list[k];
      }
    }
  };
  /// `memory`: scratch memory of a core.
  KERNEL Map of(void* memory) const {
    int *const index = static_cast<int*>(memory), *const list = index + rounded_up(particles);
    return {index, list, reinterpret_cast<OpenBlocks*>(list + rounded_up(particles))};
  }
  static size_t bytes(int particles) { return rounded_up(particles) * (2 * sizeof(int) + sizeof(OpenBlocks)); }

 private:
  KERNEL static size_t rounded_up(int particles) { return (size_t(particles) + 1 + 15) / 16 * 16; }
};

/// Index map for a device, where all clusters are processed at once: each has a hash table of the particles that it
/// lists, sized by the capacity of its list.
struct HashIndexMap {
  static constexpr int kEntries = 4;  // per particle of the capacity: at most half of the table is full
  int* table;                         // 0: empty; otherwise the index plus 1
  OpenBlocks* open_blocks;            // of each listed particle

  struct Map {
    int *table, *list;  // the table is zero at the start
    OpenBlocks* open_blocks;
    int mask, capacity;
    KERNEL int of(int particle, int& listed) const {
      for (unsigned at = unsigned(particle) * 2654435761u >> 7;; ++at) {
        int& entry = table[at & unsigned(mask)];
        if (entry > 0 && list[entry - 1] == particle) return entry - 1;
        if (entry > 0) continue;
        if (listed == capacity) return -1;
        list[listed] = particle, open_blocks[listed] = {};
        return (entry = ++listed) - 1;
      }
    }
    KERNEL void finish(int, const PairPatch&, int*) const {}
  };
  KERNEL Map of(const PairPatch& patch, int* patch_particles) const {
    int size = 4;
    while (2 * size <= kEntries * patch.particle_capacity) size *= 2;
    return {table + size_t(kEntries) * patch.particles_begin, patch_particles + patch.particles_begin,
            open_blocks + patch.particles_begin, size - 1, patch.particle_capacity};
  }
};

/// Appends the pairs of a cluster to its blocks, one after the other.
template <class R, class Map>
struct ContactBlockBuilder {
  Pairs<R> pairs;
  PairPatch patch;
  Map index_map;
  PairPacker packer;
  int listed, before;  // particles; blocks of earlier sections
  bool full;           // whether the list of particles overflowed

  KERNEL void start(const Pairs<R>& all, int cluster, const Map& map) {
    pairs = all, patch = all.patches[cluster], index_map = map;
    packer.open_blocks = map.open_blocks, packer.first = packer.open = 0, packer.full = {};
    listed = before = 0, full = false;
    patch.pairs = patch.candidates = 0;
    for (int& blocks : patch.blocks) blocks = 0;
  }

  /// Adds a pair of four particles, kIndexScale times each.
  KERNEL void add(const int (&scaled)[4], R min_distance) {
    int local[4];
    for (int j = 0; j < 4; ++j) {
      local[j] = index_map.of(scaled[j] / kIndexScale<R>, listed);
      full = full || local[j] < 0;
    }
    if (full) return;
    int slot = packer.find_slot(local);
    if (slot < 0) close(), slot = packer.find_slot(local);
    ++patch.pairs;
    if (slot / kPairBlock >= patch.capacity) return;
    ContactBlock<R>& block = pairs.blocks[patch.begin + slot / kPairBlock];
    for (int j = 0; j < 4; ++j) block.i[j][slot % kPairBlock] = scaled[j];
    block.min_distance[slot % kPairBlock] = min_distance;
  }

  KERNEL void end_section(int section) {
    close();
    patch.blocks[section] = packer.first - before, before = packer.first;
  }

  /// Requests twice the capacity if the list overflowed.
  KERNEL void finish(int cluster) {
    index_map.finish(listed, patch, pairs.patch_particles);
    patch.particle_count = full ? 2 * listed : listed;
    pairs.patches[cluster] = patch;
  }

 private:
  /// Pads the open blocks.
  KERNEL void close() {
    for (int b = 0; b < packer.open && packer.first + b < patch.capacity; ++b) {
      ContactBlock<R>& block = pairs.blocks[patch.begin + packer.first + b];
      for (int k = packer.filled[b]; k < kPairBlock; ++k) {
        for (int j = 0; j < 4; ++j) block.i[j][k] = pairs.padding;
        block.min_distance[k] = -R(INFINITY);
      }
    }
    packer.close(listed);
  }
};

}  // namespace malha
