// SPDX-License-Identifier: Apache-2.0
// The closest of all triangles, for set-up: each query visits all of them.
#pragma once
#include <cstddef>
#include <vector>

#include "kernels/simd/vec.h"
#include "malha/mesh.h"

namespace malha {

struct ClosestOfTriangles {
  std::size_t triangle;    // the first of those that are equally close
  double wb, wc;           // weights of the second and the third corner at the closest point
  Vector3<double> offset;  // m, from the closest point
};

/// The closest of `triangles`, of which there is one at least, to the point p (m). `x`: their vertices, m.
ClosestOfTriangles closest_of_triangles(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x,
                                        const Vector3<double>& p);

}  // namespace malha
