// Which simplices (triangles, edges of no triangle, loose particles) may meet: their boxes in a uniform grid whose
// cells are hashed, and sorted by their hash.
#pragma once
#include "kernels/particles.h"
#include "kernels/sort.h"

namespace malha {

/// A triangle, or what there is without one: an edge (a, b, b), a loose particle (a, a, a). Every particle and every
/// edge belongs to one simplex, so that pairs of them are found once (Curtis, Tamstorf, Manocha, "Fast Collision
/// Detection for Deformable Models using Representative-Triangles", 2008).
struct Simplex {
  int corner[3];
  int has;  // bits: 0 to 2 its corners, 3 to 5 its edges (corner k to the next), 6: it is a face
  KERNEL bool owns_corner(int k) const { return (has >> k) & 1; }
  KERNEL bool owns_edge(int k) const { return (has >> (3 + k)) & 1; }
  KERNEL bool is_face() const { return (has >> 6) & 1; }
  KERNEL int from(int k) const { return corner[k]; }
  KERNEL int to(int k) const { return corner[k == 2 ? 0 : k + 1]; }
};

template <class R>
struct Box {
  Vec4<R> low, high;
};
template <class R>
KERNEL bool overlap(const Box<R>& a, const Box<R>& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}
template <class R>
KERNEL R smaller(R a, R b) {
  return a < b ? a : b;
}
template <class R>
KERNEL Box<R> around(const Box<R>& a, const Box<R>& b) {
  return {{smaller(a.low.x, b.low.x), smaller(a.low.y, b.low.y), smaller(a.low.z, b.low.z), R(0)},
          {larger(a.high.x, b.high.x), larger(a.high.y, b.high.y), larger(a.high.z, b.high.z), R(0)}};
}

/// Where the particles may go in a substep: from x along d and `margin` further in every direction.
template <class R>
struct Reaches {
  ScatteredPoints<R> x, d;
  Vector3<R> origin;  // near the particles: boxes are relative to it
  R margin;
  Box<R>* boxes;  // of the particles
};

template <class R>
struct BoxParticles {
  Reaches<R> reaches;
  KERNEL void operator()(int i) const {
    const Vector3<R> a = reaches.x[i] - reaches.origin, b = a + reaches.d[i];
    const R m = reaches.margin;
    reaches.boxes[i] = {{smaller(a.x, b.x) - m, smaller(a.y, b.y) - m, smaller(a.z, b.z) - m, R(0)},
                        {larger(a.x, b.x) + m, larger(a.y, b.y) + m, larger(a.z, b.z) + m, R(0)}};
  }
};

struct Extent {
  double sum = 0;
  KERNEL Extent& operator+=(const Extent& o) {
    sum += o.sum;
    return *this;
  }
};

/// Stores the boxes; returns their mean sides.
template <class R>
struct BoxSimplices {
  const Box<R>* particles;
  const Simplex* simplices;
  Box<R>* boxes;
  KERNEL Extent operator()(int e) const {
    const Simplex simplex = simplices[e];
    const int* const i = simplex.corner;
    const Box<R> box = around(around(particles[i[0]], particles[i[1]]), particles[i[2]]);
    boxes[e] = box;
    return {(double(box.high.x - box.low.x) + double(box.high.y - box.low.y) + double(box.high.z - box.low.z)) / 3};
  }
};

struct Cell {
  int x, y, z;
};
struct CellRange {
  Cell low, high;
};

template <class R>
struct Grid {
  R per_cell;  // 1/m
  int bits;    // of a hash
  KERNEL int cell_of(R x) const {
    constexpr R kFar = R(1 << 30);
    const R c = floor_of(x * per_cell);
    return c > -kFar ? (c < kFar ? int(c) : 1 << 30) : -(1 << 30);
  }
  KERNEL CellRange cells(const Box<R>& b) const {
    return {{cell_of(b.low.x), cell_of(b.low.y), cell_of(b.low.z)},
            {cell_of(b.high.x), cell_of(b.high.y), cell_of(b.high.z)}};
  }
  KERNEL unsigned hash(const Cell& c) const {
    unsigned h = unsigned(c.x) * 73856093u ^ unsigned(c.y) * 19349663u ^ unsigned(c.z) * 83492791u;
    h ^= h >> 15;
    h *= 0x9e3779b1u;
    return h >> (32 - bits);
  }

 private:
  KERNEL static float floor_of(float a) { return floorf(a); }
  KERNEL static double floor_of(double a) { return floor(a); }
};

/// How many cells a simplex's box touches.
template <class R>
struct CountCells {
  Grid<R> grid;
  const Box<R>* boxes;
  int* counts;
  KERNEL Extent operator()(int e) const {
    const CellRange r = grid.cells(boxes[e]);
    const double count =
        (double(r.high.x) - r.low.x + 1) * (double(r.high.y) - r.low.y + 1) * (double(r.high.z) - r.low.z + 1);
    counts[e] = count < 1e9 ? int(count) : 1000000000;
    return {count};
  }
};

template <class R>
struct EnterCells {
  Grid<R> grid;
  const Box<R>* boxes;
  const int* place;
  Keyed* entries;
  KERNEL void operator()(int e) const {
    const CellRange r = grid.cells(boxes[e]);
    Keyed* to = entries + place[e];
    for (int z = r.low.z; z <= r.high.z; ++z)
      for (int y = r.low.y; y <= r.high.y; ++y)
        for (int x = r.low.x; x <= r.high.x; ++x) *to++ = {grid.hash({x, y, z}), e};
  }
};

/// Calls meet(other) once for every later simplex whose box overlaps that of simplex e, in the cell of the lower corner
/// of the boxes' intersection.
template <class R, class Meet>
KERNEL void for_each_neighbour(int e, const Grid<R>& grid, const Box<R>* boxes, const Keyed* entries, const int* begin,
                               const Meet& meet) {
  const Box<R> box = boxes[e];
  const CellRange r = grid.cells(box);
  for (int z = r.low.z; z <= r.high.z; ++z)
    for (int y = r.low.y; y <= r.high.y; ++y)
      for (int x = r.low.x; x <= r.high.x; ++x) {
        const unsigned key = grid.hash({x, y, z});
        int last = -1;
        for (int k = begin[key + 1] - 1; k >= begin[key] && entries[k].value > e; --k) {
          const int other = entries[k].value;
          if (other == last || !overlap(box, boxes[other])) continue;  // two of its cells may share a hash
          last = other;
          const Box<R>& theirs = boxes[other];
          if (grid.cell_of(larger(box.low.x, theirs.low.x)) != x ||
              grid.cell_of(larger(box.low.y, theirs.low.y)) != y || grid.cell_of(larger(box.low.z, theirs.low.z)) != z)
            continue;
          meet(other);
        }
      }
}

/// A pair that may meet: a particle and a triangle (i, then three corners), or two edges (~i and its end, two ends).
struct Candidate {
  int i[4];
  KERNEL bool are_edges() const { return i[0] < 0; }
  KERNEL int particle(int j) const { return j == 0 && i[0] < 0 ? ~i[0] : i[j]; }
  KERNEL bool before(const Candidate& o) const {
    for (int j = 0; j < 3; ++j)
      if (i[j] != o.i[j]) return i[j] < o.i[j];
    return i[3] < o.i[3];
  }
};

/// Finds the candidates of a simplex: counts them, or lays them down where their count said, in an order that is the
/// same whatever the grid.
template <class R, bool kLays>
struct FindCandidates {
  Grid<R> grid;
  const Box<R>* particles;
  const Simplex* simplices;
  const Box<R>* boxes;
  const Keyed* entries;
  const int* begin;  // of the entries of a hash
  int* place;        // counts to fill in, or places
  Candidate* candidates;

  KERNEL void operator()(int e) const {
    const Simplex mine = simplices[e];
    const Box<R> edge[3] = {of_edge(mine, 0), of_edge(mine, 1), of_edge(mine, 2)};
    int found = 0;
    Candidate* const to = kLays ? candidates + place[e] : nullptr;
    const auto add = [&](const Candidate& candidate) KERNEL_LAMBDA {
      if (kLays) to[found] = candidate;
      ++found;
    };
    for_each_neighbour(e, grid, boxes, entries, begin, [&](int other) KERNEL_LAMBDA {
      const Simplex theirs = simplices[other];
      corners_and_face(mine, theirs, boxes[other], add);
      corners_and_face(theirs, mine, boxes[e], add);
      for (int l = 0; l < 3; ++l) {
        if (!theirs.owns_edge(l)) continue;
        const Box<R> their_edge = of_edge(theirs, l);
        for (int k = 0; k < 3; ++k)
          if (mine.owns_edge(k) && overlap(edge[k], their_edge) && apart(mine, k, theirs, l))
            add({{~mine.from(k), mine.to(k), theirs.from(l), theirs.to(l)}});
      }
    });
    if (!kLays)
      place[e] = found;
    else
      sort(to, found);
  }

 private:
  KERNEL Box<R> of_edge(const Simplex& s, int k) const { return around(particles[s.from(k)], particles[s.to(k)]); }
  KERNEL static bool apart(const Simplex& a, int k, const Simplex& b, int l) {
    return a.from(k) != b.from(l) && a.from(k) != b.to(l) && a.to(k) != b.from(l) && a.to(k) != b.to(l);
  }
  template <class Add>
  KERNEL void corners_and_face(const Simplex& mine, const Simplex& face, const Box<R>& box, const Add& add) const {
    if (!face.is_face()) return;
    for (int k = 0; k < 3; ++k) {
      const int i = mine.corner[k];
      const int* const of = face.corner;
      if (mine.owns_corner(k) && overlap(particles[i], box) && i != of[0] && i != of[1] && i != of[2])
        add({{i, of[0], of[1], of[2]}});
    }
  }
  KERNEL static void sort(Candidate* of, int count) {
    for (int k = 1; k < count; ++k) {
      const Candidate moving = of[k];
      int at = k;
      for (; at > 0 && moving.before(of[at - 1]); --at) of[at] = of[at - 1];
      of[at] = moving;
    }
  }
};

}  // namespace malha
