// SPDX-License-Identifier: Apache-2.0
// Pairs (a particle and a triangle, or two edges) in blocks of sixteen that share no particle, so that the pairs of a
// block are evaluated and projected side by side; and patches, the blocks of one cluster.
#pragma once
#include "kernels/geometry/closest_point.h"
#include "kernels/simd/rows.h"

namespace malha {

/// The largest number of lanes of a pack; the same for all instruction sets, so that they give the same bits.
inline constexpr int kPairBlock = 16;
/// Prefetch distance of kernels over many blocks.
inline constexpr int kBlocksAhead = 4;

/// Pairs and their contacts. C(p) = n . sum of w_j moved_j - bias >= 0, an inequality over four particles, with n and w
/// from x0, where nothing intersects. Padding has the particle of the last row and a min_distance of minus infinity.
template <class R>
struct alignas(64) ContactBlock {
  int i[4][kPairBlock];        // kIndexScale times the particle
  R min_distance[kPairBlock];  // m
  R gap[kPairBlock];           // m, between the planes of normal n that separate the sides at x0; infinity: no planes
  R n[3][kPairBlock];          // from the other side to the one
  R w[3][kPairBlock];          // of particles 1, 2 and 3; that of particle 0 is minus their sum
  R bias[kPairBlock];          // minimum distance minus that at x0, m; minus infinity: no contact
  R lambda[kPairBlock];        // accumulated push times dt, kg m
  R friction_impulse[3][kPairBlock];  // accumulated friction times dt, kg m, at most mu lambda
};

/// Prefetches what kernels over planes read of a block: its particles, gaps and normals.
template <class R>
KERNEL void prefetch_planes(const ContactBlock<R>* block) {
  prefetch(block->i, int(sizeof(block->i))), prefetch(block->gap, int(sizeof(block->gap) + sizeof(block->n)));
}

/// Flags of a block, a bit for each pair.
struct PairBits {
  unsigned short near;      // is a contact
  unsigned short rim;       // of those, pairs whose closest point lies on the boundary of a side
  unsigned short crossing;  // would intersect
};

/// Sections of a patch: particle-triangle pairs, edge pairs, and edge pairs with at least one wire edge (no triangle).
inline constexpr int kSections = 3;

/// The pairs that a cluster owns: blocks from `begin` on, section after section.
struct PairPatch {
  int begin = 0, capacity = 0;                  // blocks
  int blocks[kSections] = {};                   // of each section
  int pairs = 0;                                // in all of them
  int candidates = 0;                           // that were tested for them
  int particles_begin = 0, particle_count = 0;  // its list of particles
  int particle_capacity = 0;

  KERNEL int all() const { return blocks[0] + blocks[1] + blocks[2]; }
  /// Section of block `begin + k`.
  KERNEL int section_of(int k) const { return k < blocks[0] ? 0 : k < blocks[0] + blocks[1] ? 1 : 2; }
  /// Calls f(block, section) for every block.
  template <class F>
  KERNEL void for_each_block(const F& f) const {
    int block = begin;
    for (int section = 0; section < kSections; ++section)
      for (const int last = block + blocks[section]; block < last; ++block) f(block, section);
  }
};

/// Number of particles on the first side of a section's pairs.
KERNEL int first_side_of(int section) { return section == 0 ? 1 : 2; }

/// View of all pairs.
template <class R>
struct Pairs {
  PairPatch* patches;
  ContactBlock<R>* blocks;
  PairBits* bits;
  int* patch_particles;  // the particles of the patches, one patch after the other
  int padding;           // the last row, scaled
};

/// Calls f(block, k, first) for every slot of the blocks of a patch; `first`: number of particles on the first side.
/// The threads of a block share the slots.
template <class R, class Group, class F>
KERNEL void for_each_pair(const Group& group, const Pairs<R>& pairs, const F& f) {
  pairs.patches[group.index].for_each_block([&](int b, int section) KERNEL_LAMBDA {
    group.for_each(kPairBlock, [&](int k) KERNEL_LAMBDA { f(pairs.blocks[b], k, first_side_of(section)); });
  });
}

/// Motions of the particles: x0, from an origin near them, whose w is the contact distance
/// (kernels/self_collision/contact_distance.h), and the displacement since; its w is the inverse mass.
template <class R>
struct Trajectories {
  Vec4<R>*x0, *moved;
  Vector3<R> origin{R(0), R(0), R(0)};  // m
};

/// The open blocks that contain a particle, a bit each.
struct OpenBlocks {
  static constexpr int kWords = 8, kMost = 64 * kWords;
  unsigned long long word[kWords];
};

/// Packs pairs into blocks: a pair goes to the first open block that is not full and has none of its particles. Many
/// blocks may be open, because the pairs of one particle come one after the other.
struct PairPacker {
  OpenBlocks* open_blocks;  // of each listed particle
  int first = 0, open = 0;  // blocks
  OpenBlocks full = {};
  unsigned char filled[OpenBlocks::kMost] = {};

  /// The slot for a pair of these particles (by their indices in the list), counted from the first block's first; below
  /// 0: there is none, and the open blocks must be closed.
  KERNEL int find_slot(const int (&i)[4]) {
    for (int q = 0; 64 * q <= open && q < OpenBlocks::kWords; ++q) {
      const unsigned long long used = full.word[q] | open_blocks[i[0]].word[q] | open_blocks[i[1]].word[q] |
                                      open_blocks[i[2]].word[q] | open_blocks[i[3]].word[q];
      if (~used == 0) continue;
      const int bit = lowest_bit(~used), block = 64 * q + bit;
      if (block >= open) filled[open++] = 0;  // opens a block: none of the open ones fits
      for (const int particle : i) open_blocks[particle].word[q] |= 1ull << bit;
      if (filled[block] + 1 == kPairBlock) full.word[q] |= 1ull << bit;
      return kPairBlock * (first + block) + filled[block]++;
    }
    return -1;
  }
  KERNEL void close(int listed) {
    for (int k = 0; k < listed; ++k) open_blocks[k] = {};
    first += open, open = 0, full = {};
  }
};

}  // namespace malha
