// SPDX-License-Identifier: Apache-2.0
// Whether an edge goes through a triangle, or touches it.
#pragma once
#include "malha/mesh.h"

namespace malha {

/// Whether the segment from p to q properly crosses the triangle; where rounding could have made it, it does not.
bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

/// Whether they have a point in common, or rounding could have parted them: at a rim, a corner or in one plane too. A
/// triangle without area touches nothing.
bool touches(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace malha
