// SPDX-License-Identifier: Apache-2.0
// Points that follow the surface of an object that deforms.
#pragma once
#include <array>
#include <vector>

#include "host/attachments/object_motion.h"
#include "kernels/simd/vec.h"

namespace malha {

/// Points of which each follows the triangle that is closest at the start: its weights in it stay, and its offset from
/// it turns with the triangle's first edge and normal.
class SurfacePoints {
 public:
  /// `places` are those of the points at the start, m. Triangles without area are left out.
  SurfacePoints(const EnvironmentMesh& object, const std::vector<Vector3<double>>& places);

  /// Returns the positions of the points at a time (s), m, until the next call.
  const std::vector<Vector3<double>>& at(double time);

 private:
  struct Point {
    std::array<std::size_t, 3> corner;  // among the vertices
    double wb = 0, wc = 0;              // weights of the second and the third corner
    Vector3<double> offset{};           // m, along the first edge, across it in the plane, and along the normal
  };
  struct Followed {  // the vertices that the points need, and the points
    std::vector<int> vertices;
    std::vector<Point> points;
  };
  static Followed follow(const EnvironmentMesh& object, const std::vector<Vector3<double>>& places);
  SurfacePoints(const EnvironmentMesh& object, Followed followed);

  SomeVertices vertices_;
  std::vector<Point> points_;
  std::vector<Vector3<double>> at_;  // m, at the time of the last call
};

}  // namespace malha
