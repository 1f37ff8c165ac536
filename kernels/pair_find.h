// Which pairs (a particle and a triangle, or two edges) can come nearer than is wanted while every particle stays in
// the box of its search.
#pragma once
#include "kernels/pair_block.h"
#include "kernels/pair_units.h"

namespace malha {

/// Where particles may go in the frame of their common motion: from where they were at the search.
template <class R>
struct Reach {
  Vec4<R>* from;  // w: how far beyond the way, in every direction
  Vec4<R>* way;
  Vec4<R>* rest;  // positions at the start of the scene; w: the body
};

/// What a thread needs while it finds the pairs of a unit: of each particle its place in a list of those that have a
/// pair, below 0 before and after, that list, and in which open blocks each of them is.
struct FindMemory {
  int *place, *list;
  OpenBlocks* taken;
  KERNEL FindMemory(void* memory, int particles)
      : place(static_cast<int*>(memory)),
        list(place + whole(particles)),
        taken(reinterpret_cast<OpenBlocks*>(list + whole(particles))) {}
  KERNEL static size_t bytes(int particles) { return whole(particles) * (2 * sizeof(int) + sizeof(OpenBlocks)); }

 private:
  KERNEL static size_t whole(int particles) { return (size_t(particles) + 1 + 15) / 16 * 16; }
};

/// Finds the pairs of each unit with itself and with those that it owns pairs with: of two units every other one.
template <class R>
struct FindPairs {
  Units<R> units;
  Reach<R> reach;
  R thickness;
  bool has_bare;  // whether any edge has no triangle
  int particles;
  Pairs<R> pairs;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    Finder<typename Group::Isa> finder(*this, group.index, group.memory);
    finder.template find<PairKind::Face>(0, false);
    finder.template find<PairKind::Edges>(1, false);
    if (has_bare) finder.template find<PairKind::Edges>(2, true);
    finder.finish();
  }

 private:
  template <class Isa>
  struct Finder {
    using S = Lane<R, Isa>;
    static constexpr int lanes = kLanes<R, Isa>;

    const FindPairs& of;
    const int u;
    const FindMemory memory;
    PairPatch patch;
    PairPacker packer;
    int listed = 0;   // particles
    int waiting = 0;  // candidates
    int candidate[4][kPairBlock];

    KERNEL Finder(const FindPairs& find, int unit, void* bytes)
        : of(find), u(unit), memory(bytes, find.particles), patch(find.pairs.patches[unit]), packer{memory.taken} {
      patch.pairs = 0;
      for (int& blocks : patch.blocks) blocks = 0;
    }

    template <PairKind kind>
    KERNEL void find(int section, bool bare) {
      const Units<R>& units = of.units;
      const int before = packer.first;
      for_each_unit<Isa>(units, u, [&](int v) KERNEL_LAMBDA {
        if (v != u && (((u + v) & 1) == 1) != (u < v)) return;  // v owns their pairs
        const int turns = kind == PairKind::Face && v != u ? 2 : 1;
        for (int turn = 0; turn < turns; ++turn) {
          const int one = turn == 0 ? u : v, other = turn == 0 ? v : u;
          constexpr int kOne = kind == PairKind::Face ? kPoints : kEdges;
          constexpr int kOther = kind == PairKind::Face ? kTriangles : kEdges;
          for_each_meeting<Isa>(units, one, kOne, other, kOther, [&](int i, int j) KERNEL_LAMBDA {
            int c[4];
            if constexpr (kind == PairKind::Face) {
              c[0] = units.point[i], c[1] = units.corner[0][j], c[2] = units.corner[1][j], c[3] = units.corner[2][j];
              if (c[0] == c[1] || c[0] == c[2] || c[0] == c[3]) return;
            } else {
              if (bool(units.bare[i] | units.bare[j]) != bare) return;
              c[0] = units.end[0][i], c[1] = units.end[1][i], c[2] = units.end[0][j], c[3] = units.end[1][j];
              if (c[0] == c[2] || c[0] == c[3] || c[1] == c[2] || c[1] == c[3]) return;
            }
            for (int k = 0; k < 4; ++k) candidate[k][waiting] = c[k];
            if (++waiting == kPairBlock) keep<kind>();
          });
        }
      });
      if (waiting > 0) keep<kind>();
      close();
      patch.blocks[section] = packer.first - before;
    }

    /// Of those that wait, the ones that can come near enough.
    template <PairKind kind>
    KERNEL void keep() {
      for (int k = waiting; k < kPairBlock; ++k)
        for (int j = 0; j < 4; ++j) candidate[j][k] = of.pairs.padding;
      for (int k = 0; k < waiting; k += lanes) {
        S wanted;
        unsigned kept = filter<kind>(k, wanted);
        if (waiting - k < lanes) kept &= (1u << (waiting - k)) - 1;
        for (; kept != 0; kept &= kept - 1) {
          const int l = lowest_bit(kept);
          const int i[4] = {candidate[0][k + l], candidate[1][k + l], candidate[2][k + l], candidate[3][k + l]};
          int local[4];
          for (int j = 0; j < 4; ++j) local[j] = place_of(i[j] / kIndexScale<R>);
          int slot = packer.place(local);
          if (slot < 0) close(), slot = packer.place(local);
          ++patch.pairs;
          if (slot / kPairBlock >= patch.capacity) continue;
          PairBlock<R>& block = of.pairs.blocks[patch.begin + slot / kPairBlock];
          for (int j = 0; j < 4; ++j) block.i[j][slot % kPairBlock] = i[j];
          block.wanted[slot % kPairBlock] = lane(wanted, l);
        }
      }
      waiting = 0;
    }

    KERNEL int place_of(int particle) {
      int& place = memory.place[particle];
      if (place < 0) {
        place = listed, memory.list[listed] = particle, memory.taken[listed] = {};
        ++listed;
      }
      return place;
    }

    /// Pads the open blocks.
    KERNEL void close() {
      for (int b = 0; b < packer.open && packer.first + b < patch.capacity; ++b) {
        PairBlock<R>& block = of.pairs.blocks[patch.begin + packer.first + b];
        for (int k = packer.filled[b]; k < kPairBlock; ++k) {
          for (int j = 0; j < 4; ++j) block.i[j][k] = of.pairs.padding;
          block.wanted[k] = -R(INFINITY);
        }
      }
      packer.close(listed);
    }

    /// Of candidates k, k + 1, ...: a bit for those that can come as near as is wanted, which is less than the
    /// thickness for what is nearer at rest: half as far as there.
    template <PairKind kind>
    KERNEL unsigned filter(int k, S& wanted) const {
      const S zero(R(0));
      Vector3<S> x[4];
      S beyond[4], unused, w[4];
      for (int j = 0; j < 4; ++j) gather_rows(of.reach.from, candidate[j] + k, x[j], beyond[j]);
      weigh<kind>(x, w);
      const Vector3<S> apart = apart_by(x, w);
      const Vector3<S> n = apart * (S(R(1)) / root(dot(apart, apart)));
      const S diagonal = magnitude(n.x) + magnitude(n.y) + magnitude(n.z);
      // Along whatever n, the sides come no nearer than this.
      S side[4], size2 = zero;
      for (int j = 0; j < 4; ++j) {
        Vector3<S> way;
        gather_rows(of.reach.way, candidate[j] + k, way, unused);
        const Vector3<S> from = x[j] - x[0], along{n.x * way.x, n.y * way.y, n.z * way.z};
        size2 = larger(size2, dot(from, from));
        if (j < first_side(kind))
          side[j] = dot(n, from) + smaller(along.x, zero) + smaller(along.y, zero) + smaller(along.z, zero) -
                    beyond[j] * diagonal;
        else
          side[j] = dot(n, from) + larger(along.x, zero) + larger(along.y, zero) + larger(along.z, zero) +
                    beyond[j] * diagonal;
      }
      constexpr R kRounding = sizeof(R) == 4 ? R(2e-6) : R(1e-14);
      const S least = between_sides<kind>(side) - S(kRounding) * root(size2);
      wanted = S(of.thickness);
      unsigned far = bits_of(least > wanted);
      constexpr unsigned all = (1ull << lanes) - 1;
      if (far == all) return 0;
      S body[4];
      for (int j = 0; j < 4; ++j) gather_rows(of.reach.rest, candidate[j] + k, x[j], body[j]);
      weigh<kind>(x, w);
      const Vector3<S> there = apart_by(x, w);
      wanted = select(body[0] == body[3], smaller(wanted, root(dot(there, there)) * S(R(0.5))), wanted);
      far |= bits_of(least > wanted);
      return all & ~far;
    }

    KERNEL void finish() {
      for (int k = 0; k < listed; ++k) {
        memory.place[memory.list[k]] = -1;
        if (listed <= patch.room) of.pairs.touched[patch.touched + k] = memory.list[k];
      }
      patch.touches = listed;
      of.pairs.patches[u] = patch;
    }
  };
};

}  // namespace malha
