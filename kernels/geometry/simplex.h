// SPDX-License-Identifier: Apache-2.0
// Simplices (triangles, edges of no triangle, loose particles), bounding boxes, and candidate pairs.
#pragma once
#include "kernels/parallel/sort.h"
#include "kernels/simd/particles.h"

namespace malha {

/// A triangle, an edge of no triangle (a, b, b), or a loose particle (a, a, a). Every particle and every edge belongs
/// to one simplex, so that pairs of them are found once (Curtis, Tamstorf, Manocha, "Fast Collision Detection for
/// Deformable Models using Representative-Triangles", 2008).
struct Simplex {
  int corner[3];
  int has;  // bits: 0 to 2 owned corners, 3 to 5 owned edges (corner k to the next), 6: is a face
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
KERNEL Box<R> merge(const Box<R>& a, const Box<R>& b) {
  return {{min(a.low.x, b.low.x), min(a.low.y, b.low.y), min(a.low.z, b.low.z), R(0)},
          {max(a.high.x, b.high.x), max(a.high.y, b.high.y), max(a.high.z, b.high.z), R(0)}};
}

/// Swept bounds of the particles in a substep: from x along d, larger by `margin` in every direction.
template <class R>
struct ParticleBounds {
  ScatteredPoints<R> x, d;
  R margin;
  Box<R>* boxes;  // of the particles
};

template <class R>
struct ComputeParticleBounds {
  ParticleBounds<R> bounds;
  KERNEL void operator()(int i) const {
    const Vector3<R> a = bounds.x[i], b = a + bounds.d[i];
    const R m = bounds.margin;
    bounds.boxes[i] = {{min(a.x, b.x) - m, min(a.y, b.y) - m, min(a.z, b.z) - m, R(0)},
                       {max(a.x, b.x) + m, max(a.y, b.y) + m, max(a.z, b.z) + m, R(0)}};
  }
};

/// A candidate pair: a particle and a triangle (i, then three corners), or two edges (~i and its end, two ends).
struct Candidate {
  int i[4];
  KERNEL bool are_edges() const { return i[0] < 0; }
  KERNEL int particle(int j) const { return j == 0 && i[0] < 0 ? ~i[0] : i[j]; }
};

}  // namespace malha
