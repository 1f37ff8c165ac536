// SPDX-License-Identifier: Apache-2.0
// Intersection tests of an edge with a triangle that are safe against rounding.
#pragma once
#include "malha/mesh.h"

namespace malha {

/// True if the segment from p to q crosses the interior of the triangle a, b, c. Where rounding decides, it is false.
bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

/// True if the segment and the triangle have a point in common, including boundary points and coplanar ones. Where
/// rounding decides, it is true. A triangle without area touches nothing.
bool touches(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace malha
