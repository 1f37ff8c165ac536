// Which pairs (a particle and a triangle, or two edges) can come nearer than is wanted while every particle stays in
// the box of its search.
#pragma once
#include "kernels/pair_block.h"
#include "kernels/pair_units.h"

namespace malha {

/// What a core needs while it finds the pairs of a unit: of each particle its place in a list of those that have a
/// pair, below 0 before and after, that list, and in which open blocks each of them is.
struct DirectPlaces {
  int particles;

  struct Places {
    int *place, *list;
    OpenBlocks* taken;
    KERNEL void start() const {}
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
  KERNEL Places of(const PairPatch&, int* /*touched*/, void* memory) const {
    int *const place = static_cast<int*>(memory), *const list = place + whole(particles);
    return {place, list, reinterpret_cast<OpenBlocks*>(list + whole(particles))};
  }
  static size_t bytes(int particles) { return whole(particles) * (2 * sizeof(int) + sizeof(OpenBlocks)); }

 private:
  KERNEL static size_t whole(int particles) { return (size_t(particles) + 1 + 15) / 16 * 16; }
};

/// The same for a device, where all units are searched at once: each has a table of what it lists, which is hashed, as
/// far as its list has room.
struct HashedPlaces {
  static constexpr int kEntries = 4;  // a particle that there is room for: at most half of the table is full
  int* table;                         // 0, or a place and 1
  OpenBlocks* taken;                  // of each of them

  struct Places {
    int *table, *list;
    OpenBlocks* taken;
    int mask, room;
    KERNEL void start() const {
      for (int k = 0; k <= mask; ++k) table[k] = 0;
    }
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
  KERNEL Places of(const PairPatch& patch, int* touched, void*) const {
    int size = 4;
    while (2 * size <= kEntries * patch.room) size *= 2;
    return {table + size_t(kEntries) * patch.touched, touched + patch.touched, taken + patch.touched, size - 1,
            patch.room};
  }
};

/// Where particles may go in the frame of their common motion: from where they were at the search.
template <class R>
struct Reach {
  Vec4<R>* from;  // w: how far beyond the way, in every direction
  Vec4<R>* way;
  Vec4<R>* rest;  // positions at the start of the scene; w: the body
};

/// Which pairs of bodies cross, a bit each: with up to eight bodies a bit of their own.
using CrossingBodies = unsigned long long;
KERNEL CrossingBodies crossing_bit(int one, int other) {
  const int low = smaller(one, other), high = larger(one, other);
  return 1ull << (8 * low + high) % 64;
}

/// Pairs that wait until there are as many as a block holds: the particles of each.
struct Waiting {
  int of[4][2 * kPairBlock], count = 0;
  KERNEL void add(const int (&i)[4], bool counts) {
    for (int j = 0; j < 4; ++j) of[j][count] = i[j];
    count += counts;
  }
  KERNEL void take(const Waiting& from, int k) {
    for (int j = 0; j < 4; ++j) of[j][count] = from.of[j][k];
    ++count;
  }
  /// Fills up the first block.
  KERNEL void pad(int padding) {
    for (int k = count; k < kPairBlock; ++k)
      for (int j = 0; j < 4; ++j) of[j][k] = padding;
  }
  /// A bit for each of k, k + 1, ... that is there.
  KERNEL unsigned there(int k, int lanes) const {
    const int left = count - k;
    return left <= 0 ? 0 : left >= lanes ? ~0u : (1u << left) - 1;
  }
  /// Takes the first block away.
  KERNEL void drop() {
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < kPairBlock; ++k) of[j][k] = of[j][kPairBlock + k];
    count = count > kPairBlock ? count - kPairBlock : 0;
  }
};

/// Finds the pairs of each unit with itself and with those that it owns pairs with: of two units every other one.
template <class R, class MakePlaces>
struct FindPairs {
  Units<R> units;
  Reach<R> reach;
  R thickness;
  bool has_bare;                  // whether any edge has no triangle
  const CrossingBodies* crosses;  // at each particle; none: nothing crosses
  Pairs<R> pairs;
  MakePlaces places;

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
    PairPatch patch;
    const typename MakePlaces::Places places;
    PairPacker packer;
    int listed = 0;              // particles
    bool full = false;           // whether there was no room for one
    Waiting candidates, near;    // near: of the candidates, what comes as near as the thickness
    R least_of[2 * kPairBlock];  // and how near

    KERNEL Finder(const FindPairs& find, int unit, void* bytes)
        : of(find),
          u(unit),
          patch(find.pairs.patches[unit]),
          places(find.places.of(patch, find.pairs.touched, bytes)),
          packer{places.taken} {
      places.start();
      patch.pairs = patch.candidates = 0;
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
          for_each_meeting<Isa>(units, one, kOne, other, kOther, [&](int i, int first, unsigned bits) KERNEL_LAMBDA {
            for (; bits != 0; bits &= bits - 1) add<kind>(i, first + lowest_bit(bits), bare);
            if (candidates.count >= kPairBlock) look<kind>();
          });
        }
      });
      if (candidates.count > 0) look<kind>();
      if (near.count > 0) keep<kind>();
      close();
      patch.blocks[section] = packer.first - before;
    }

    /// A candidate, unless its sides share a particle: without a branch, because many do.
    template <PairKind kind>
    KERNEL void add(int i, int j, bool bare) {
      const Units<R>& units = of.units;
      bool apart;
      int c[4];
      if constexpr (kind == PairKind::Face) {
        c[0] = units.point[i], c[1] = units.corner[0][j], c[2] = units.corner[1][j], c[3] = units.corner[2][j];
        apart = (c[0] != c[1]) & (c[0] != c[2]) & (c[0] != c[3]);
      } else {
        c[0] = units.end[0][i], c[1] = units.end[1][i], c[2] = units.end[0][j], c[3] = units.end[1][j];
        apart = (c[0] != c[2]) & (c[0] != c[3]) & (c[1] != c[2]) & (c[1] != c[3]);
        if (of.has_bare) apart = apart && bool(units.bare[i] | units.bare[j]) == bare;
      }
      candidates.add(c, apart);
    }

    /// Of the candidates, those that can come as near as the thickness.
    template <PairKind kind>
    KERNEL void look() {
      candidates.pad(of.pairs.padding);
      patch.candidates += candidates.count < kPairBlock ? candidates.count : kPairBlock;
      for (int k = 0; k < kPairBlock; k += lanes) {
        const S least = nearest<kind>(k);
        for (unsigned bits = bits_of(least <= S(of.thickness)) & candidates.there(k, lanes); bits != 0;
             bits &= bits - 1) {
          const int l = lowest_bit(bits);
          least_of[near.count] = lane(least, l);
          near.take(candidates, k + l);
        }
      }
      candidates.drop();
      if (near.count >= kPairBlock) keep<kind>();
    }

    /// Of those, the ones that can come as near as is wanted get places.
    template <PairKind kind>
    KERNEL void keep() {
      near.pad(of.pairs.padding);
      for (int k = 0; k < kPairBlock; k += lanes) {
        S least;
        load(least_of + k, least);
        const S wanted = wanted_of<kind>(k);
        for (unsigned bits = bits_of(least <= wanted) & near.there(k, lanes); bits != 0; bits &= bits - 1) {
          const int l = lowest_bit(bits);
          place<kind>(k + l, lane(wanted, l));
        }
      }
      near.drop();
      for (int k = 0; k < kPairBlock; ++k) least_of[k] = least_of[kPairBlock + k];
    }

    template <PairKind kind>
    KERNEL void place(int k, R wanted) {
      int i[4], local[4];
      for (int j = 0; j < 4; ++j) i[j] = near.of[j][k] / kIndexScale<R>;
      if (of.crosses != nullptr && crosses<kind>(i)) return;
      for (int j = 0; j < 4; ++j) {
        local[j] = places.of(i[j], listed);
        full = full || local[j] < 0;
      }
      if (full) return;
      int slot = packer.place(local);
      if (slot < 0) close(), slot = packer.place(local);
      ++patch.pairs;
      if (slot / kPairBlock >= patch.capacity) return;
      PairBlock<R>& block = of.pairs.blocks[patch.begin + slot / kPairBlock];
      for (int j = 0; j < 4; ++j) block.i[j][slot % kPairBlock] = near.of[j][k];
      block.wanted[slot % kPairBlock] = wanted;
    }

    /// Whether their bodies cross at both sides: such pairs must be able to part.
    template <PairKind kind>
    KERNEL bool crosses(const int (&i)[4]) const {
      const CrossingBodies both = crossing_bit(int(of.reach.rest[i[0]].w), int(of.reach.rest[i[3]].w));
      CrossingBodies one = 0, other = 0;
      for (int j = 0; j < 4; ++j) (j < first_side(kind) ? one : other) |= of.crosses[i[j]];
      return (one & other & both) != 0;
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

    /// How near candidates k, k + 1, ... can come, at least.
    template <PairKind kind>
    KERNEL S nearest(int k) const {
      const S zero(R(0));
      Vector3<S> x[4];
      S beyond[4], unused, w[4];
      for (int j = 0; j < 4; ++j) gather_rows(of.reach.from, candidates.of[j] + k, x[j], beyond[j]);
      weigh<kind>(x, w);
      const Vector3<S> apart = apart_by(x, w);
      const Vector3<S> n = apart * (S(R(1)) / root(dot(apart, apart)));
      const S diagonal = magnitude(n.x) + magnitude(n.y) + magnitude(n.z);
      // Along whatever n, the sides come no nearer than this.
      S side[4], size2 = zero;
      for (int j = 0; j < 4; ++j) {
        Vector3<S> way;
        gather_rows(of.reach.way, candidates.of[j] + k, way, unused);
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
      return select(least == least, least, -S(R(INFINITY)));  // no number: where the sides touch
    }

    /// The thickness, or half as far as at rest where that is less.
    template <PairKind kind>
    KERNEL S wanted_of(int k) const {
      Vector3<S> x[4];
      S body[4], w[4];
      for (int j = 0; j < 4; ++j) gather_rows(of.reach.rest, near.of[j] + k, x[j], body[j]);
      weigh<kind>(x, w);
      const Vector3<S> there = apart_by(x, w);
      const S wanted(of.thickness);
      return select(body[0] == body[3], smaller(wanted, root(dot(there, there)) * S(R(0.5))), wanted);
    }

    /// Of a list without room for all, that it needs more.
    KERNEL void finish() {
      places.finish(listed, patch, of.pairs.touched);
      patch.touches = full ? 2 * listed : listed;
      of.pairs.patches[u] = patch;
    }
  };
};

}  // namespace malha
