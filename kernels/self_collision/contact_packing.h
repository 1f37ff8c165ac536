// SPDX-License-Identifier: Apache-2.0
// The pairs of a unit as they get their places in its blocks, and the particles that it lists on the way.
#pragma once
#include "kernels/self_collision/contact_block.h"
#include "kernels/self_collision/swept_distance.h"

namespace malha {

/// What a core needs while it finds the pairs of a unit: of each particle its place in a list of those that have a
/// pair, below 0 before and after, that list, and in which open blocks each of them is.
struct DirectIndexMap {
  int particles;

  struct Places {
    int *place, *list;
    OpenBlocks* taken;
    /// Below 0: there is no room.
    KERNEL int of(int particle, int& listed) const {
      if (place[particle] < 0) place[particle] = listed, list[listed] = particle, taken[listed++] = {};
      return place[particle];
    }
    KERNEL void finish(int listed, const PairPatch& patch, int* touched) const {
      for (int k = 0; k < listed; ++k) {
        place[list[k]] = -1;
        if (listed <= patch.room) touched[patch.touched + k] = list[k];
      }
    }
  };
  /// `memory`: of a core.
  KERNEL Places of(void* memory) const {
    int *const place = static_cast<int*>(memory), *const list = place + whole(particles);
    return {place, list, reinterpret_cast<OpenBlocks*>(list + whole(particles))};
  }
  static size_t bytes(int particles) { return whole(particles) * (2 * sizeof(int) + sizeof(OpenBlocks)); }

 private:
  KERNEL static size_t whole(int particles) { return (size_t(particles) + 1 + 15) / 16 * 16; }
};

/// The same for a device, where all units are searched at once: each has a table of what it lists, which is hashed, as
/// far as its list has room.
struct HashIndexMap {
  static constexpr int kEntries = 4;  // a particle that there is room for: at most half of the table is full
  int* table;                         // 0, or a place and 1
  OpenBlocks* taken;                  // of each of them

  struct Places {
    int *table, *list;  // the table is full of zeros at the start
    OpenBlocks* taken;
    int mask, room;
    KERNEL int of(int particle, int& listed) const {
      for (unsigned at = unsigned(particle) * 2654435761u >> 7;; ++at) {
        int& entry = table[at & unsigned(mask)];
        if (entry > 0 && list[entry - 1] == particle) return entry - 1;
        if (entry > 0) continue;
        if (listed == room) return -1;
        list[listed] = particle, taken[listed] = {};
        return (entry = ++listed) - 1;
      }
    }
    KERNEL void finish(int, const PairPatch&, int*) const {}
  };
  KERNEL Places of(const PairPatch& patch, int* touched) const {
    int size = 4;
    while (2 * size <= kEntries * patch.room) size *= 2;
    return {table + size_t(kEntries) * patch.touched, touched + patch.touched, taken + patch.touched, size - 1,
            patch.room};
  }
};

/// The pairs of a unit, one after the other.
template <class R, class Places>
struct ContactBlockBuilder {
  Pairs<R> pairs;
  PairPatch patch;
  Places places;
  PairPacker packer;
  int listed, before;  // particles; blocks of the sections before
  bool full;           // whether there was no room for a particle

  KERNEL void start(const Pairs<R>& all, int unit, const Places& own) {
    pairs = all, patch = all.patches[unit], places = own;
    packer.taken = own.taken, packer.first = packer.open = 0, packer.full = {};
    listed = before = 0, full = false;
    patch.pairs = patch.candidates = 0;
    for (int& blocks : patch.blocks) blocks = 0;
  }

  /// Four particles, kIndexScale times each.
  KERNEL void add(const int (&scaled)[4], R min_distance) {
    int local[4];
    for (int j = 0; j < 4; ++j) {
      local[j] = places.of(scaled[j] / kIndexScale<R>, listed);
      full = full || local[j] < 0;
    }
    if (full) return;
    int slot = packer.place(local);
    if (slot < 0) close(), slot = packer.place(local);
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
  KERNEL void finish(int unit) {
    places.finish(listed, patch, pairs.touched);
    patch.touches = full ? 2 * listed : listed;
    pairs.patches[unit] = patch;
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
