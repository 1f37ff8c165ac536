// SPDX-License-Identifier: Apache-2.0
// Points of an environment mesh that deforms, in a pose, for contacts with its edges and corners.
#pragma once
#include <cmath>
#include <vector>

#include "host/attachments/object_motion.h"
#include "kernels/simd/particles.h"

namespace malha {

struct DeformingPoints {
  double time = NAN;                 // s
  VertexBuffer at;                   // in the object's frame, m
  std::vector<Vec4<double>> normal;  // unit, or zero where there is none
  Vector3<double> centre{};          // mean of the points, m

  /// Sets them to those of an object at a time (s). `triangles`: of its mesh.
  void sample(const EnvironmentMesh& object, const std::vector<Triangle>& triangles, double at_time);
};

}  // namespace malha
