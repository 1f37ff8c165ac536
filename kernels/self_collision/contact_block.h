// SPDX-License-Identifier: Apache-2.0
// Pairs (a particle and a triangle, or two edges) in blocks of sixteen that share no particle, so that a block is
// looked at and projected at once; and patches, the blocks of one unit.
#pragma once
#include "kernels/geometry/closest_point.h"

namespace malha {

/// The most lanes of a pack, whatever the lanes: all instruction sets give the same bits.
inline constexpr int kPairBlock = 16;
/// Kernels over many blocks ask for the memory of one so many before they read it.
inline constexpr int kBlocksAhead = 4;

/// Pairs and their contacts. C(p) = n . sum of w_j moved_j - bias >= 0, an inequality over four particles, with n
/// and w from x0, where nothing crosses. Padding has particles of the last row, and wants minus infinity.
template <class R>
struct alignas(64) ContactBlock {
  int i[4][kPairBlock];        // kIndexScale times the particles
  R min_distance[kPairBlock];  // m
  R gap[kPairBlock];           // m, between planes of normal n that hold the sides apart at x0; without planes infinity
  R n[3][kPairBlock];          // from the other side to the one
  R w[3][kPairBlock];          // of particles 1, 2 and 3; that of particle 0 is what their sum lacks of 0
  R bias[kPairBlock];          // wanted distance less that at x0, m; minus infinity: not near
  R lambda[kPairBlock];        // accumulated push, kg m
  R friction_impulse[3][kPairBlock];  // accumulated friction against the sliding, kg m, at most mu lambda
};

/// Of a block that kernels over planes will read: its particles, gaps and normals.
template <class R>
KERNEL void prefetch_planes(const ContactBlock<R>* block) {
  prefetch(block->i, int(sizeof(block->i))), prefetch(block->gap, int(sizeof(block->gap) + sizeof(block->n)));
}

/// Of a block, a bit a pair.
struct PairBits {
  unsigned short near;      // may push
  unsigned short rim;       // of those, where the closest point lies at the rim of a side
  unsigned short crossing;  // about to cross
};

/// Sections of a patch: pairs with triangles, of edges, and of edges of which one at least has no triangle.
inline constexpr int kSections = 3;

/// The pairs that a unit owns: blocks from `begin` on, section after section.
struct PairPatch {
  int begin = 0, capacity = 0;   // blocks
  int blocks[kSections] = {};    // of each section
  int pairs = 0;                 // in all of them
  int candidates = 0;            // that were looked at for them
  int touched = 0, touches = 0;  // where its particles are listed, and how many; what that list has room for
  int room = 0;

  KERNEL int all() const { return blocks[0] + blocks[1] + blocks[2]; }
  /// Of the block `begin + k`.
  KERNEL int section_of(int k) const { return k < blocks[0] ? 0 : k < blocks[0] + blocks[1] ? 1 : 2; }
  /// Calls f(block, section) for every block.
  template <class F>
  KERNEL void for_each_block(const F& f) const {
    int block = begin;
    for (int section = 0; section < kSections; ++section)
      for (const int last = block + blocks[section]; block < last; ++block) f(block, section);
  }
};

/// Of a section's pairs, how many particles are the one side.
KERNEL int first_side_of(int section) { return section == 0 ? 1 : 2; }

/// All of them.
template <class R>
struct Pairs {
  PairPatch* patches;
  ContactBlock<R>* blocks;
  PairBits* bits;
  int* touched;  // particles of patches
  int padding;   // the last row, scaled
};

/// Calls f(block, k, first) for every place of a pair in the blocks of a patch; `first`: particles of the one side. Of
/// a block of threads each has some of the places.
template <class R, class Group, class F>
KERNEL void for_each_pair(const Group& group, const Pairs<R>& pairs, const F& f) {
  pairs.patches[group.index].for_each_block([&](int b, int section) KERNEL_LAMBDA {
    group.for_each(kPairBlock, [&](int k) KERNEL_LAMBDA { f(pairs.blocks[b], k, first_side_of(section)); });
  });
}

/// Where the motions of particles are found: x0, from an origin near them, whose w is the contact distance
/// (kernels/self_collision/contact_distance.h), and how far they have moved since; its w is the inverse mass.
template <class R>
struct Trajectories {
  Vec4<R>*x0, *moved;
  Vector3<R> origin{R(0), R(0), R(0)};  // m
};

/// In which of the open blocks a particle is: a bit a block.
struct OpenBlocks {
  static constexpr int kWords = 8, kMost = 64 * kWords;
  unsigned long long word[kWords];
};

/// Places for pairs: of the blocks that are open, the first that is not full and has none of their particles. Many may
/// be open, because pairs of one particle come one after the other.
struct PairPacker {
  OpenBlocks* taken;        // of each particle that is listed
  int first = 0, open = 0;  // blocks
  OpenBlocks full = {};
  unsigned char filled[OpenBlocks::kMost] = {};

  /// The slot of a pair of these particles (by their places in the list), from the first block's first on; below 0:
  /// none, the open blocks must be closed.
  KERNEL int place(const int (&i)[4]) {
    for (int q = 0; 64 * q <= open && q < OpenBlocks::kWords; ++q) {
      const unsigned long long used =
          full.word[q] | taken[i[0]].word[q] | taken[i[1]].word[q] | taken[i[2]].word[q] | taken[i[3]].word[q];
      if (~used == 0) continue;
      const int bit = lowest_bit(~used), block = 64 * q + bit;
      if (block >= open) filled[open++] = 0;  // the first of those that are not open: none before it has place
      for (const int particle : i) taken[particle].word[q] |= 1ull << bit;
      if (filled[block] + 1 == kPairBlock) full.word[q] |= 1ull << bit;
      return kPairBlock * (first + block) + filled[block]++;
    }
    return -1;
  }
  KERNEL void close(int listed) {
    for (int k = 0; k < listed; ++k) taken[k] = {};
    first += open, open = 0, full = {};
  }
};

}  // namespace malha
