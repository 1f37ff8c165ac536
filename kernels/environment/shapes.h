// SPDX-License-Identifier: Apache-2.0
// Exact convex shapes of the environment: signed distances, and where a path first comes as near as wanted. Both hold
// for a pack of points as for one.
//
// The signed distance f of a convex set is convex, also along a straight path. Two things follow. The plane at a
// surface point that is closest to any point outside has the whole shape behind it, so that what stays before the plane
// stays outside, however far it moves. And Newton's method for f = level from the path's start never goes beyond the
// first solution, because each tangent lies below f: it is the conservative advancement of continuous collision
// detection with the best step there is, and wherever it ends the path before is free.
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/simd/pack.h"

namespace malha {

enum class ConvexKind : int { HalfSpace, RoundedBox, Cylinder };

/// A shape in its own frame, centred, with its axis along y. A half-space is y <= 0. A rounded box is all that is
/// within `radius` of a box: a sphere (half = 0), a capsule (half.y alone) or a box (radius = 0). A cylinder has the
/// radius and the half height half.y.
struct ConvexShape {
  ConvexKind kind = ConvexKind::HalfSpace;
  Vector3<double> half{0, 0, 0};  // m
  double radius = 0;              // m
};

/// Signed distance of a point (m; negative inside), and its gradient: the unit normal at the closest point.
template <class S>
struct SurfaceDistance {
  S distance;
  Vector3<S> normal;
};

template <class S>
KERNEL SurfaceDistance<S> distance_to_rounded_box(const ConvexShape& shape, const Vector3<S>& a) {
  const S zero(0.0), one(1.0);
  const Vector3<S> q{abs(a.x) - S(shape.half.x), abs(a.y) - S(shape.half.y), abs(a.z) - S(shape.half.z)};
  const Vector3<S> out{max(q.x, zero), max(q.y, zero), max(q.z, zero)};
  const S squared = dot(out, out), length = sqrt(squared);
  // Inside the box the nearest face counts; at the centre of a sphere that is the top.
  const auto outside = squared > S(tiny<double>());
  const S upright = select((q.x <= q.y) & (q.z <= q.y), one, zero);
  const S sideways = select(q.z <= q.x, one - upright, zero);
  const S scale = one / select(outside, length, one);
  const Vector3<S> n = select_vector(outside, out * scale, {sideways, upright, one - upright - sideways});
  return {select(outside, length, max(q.x, max(q.y, q.z))) - S(shape.radius),
          {select(a.x < zero, -n.x, n.x), select(a.y < zero, -n.y, n.y), select(a.z < zero, -n.z, n.z)}};
}

/// The same in the half-plane of the distance from the axis and y, where a cylinder is a rectangle.
template <class S>
KERNEL SurfaceDistance<S> distance_to_cylinder(const ConvexShape& shape, const Vector3<S>& a) {
  const S zero(0.0), one(1.0);
  const S squared = a.x * a.x + a.z * a.z, axial = sqrt(squared);
  const auto off_axis = squared > S(tiny<double>());
  const S inverse = one / select(off_axis, axial, one);
  const S x = select(off_axis, a.x * inverse, one), z = select(off_axis, a.z * inverse, zero);
  const S side = axial - S(shape.radius), cap = abs(a.y) - S(shape.half.y);
  const S out_side = max(side, zero), out_cap = max(cap, zero), out2 = out_side * out_side + out_cap * out_cap;
  const S length = sqrt(out2);
  const auto outside = out2 > S(tiny<double>());
  const S scale = one / select(outside, length, one), upright = select(side <= cap, one, zero);
  const S n_side = select(outside, out_side * scale, one - upright), n_cap = select(outside, out_cap * scale, upright);
  return {select(outside, length, max(side, cap)), {x * n_side, select(a.y < zero, -n_cap, n_cap), z * n_side}};
}

template <class S>
KERNEL SurfaceDistance<S> distance_to(const ConvexShape& shape, const Vector3<S>& a) {
  if (shape.kind == ConvexKind::HalfSpace) return {a.y, {S(0.0), S(1.0), S(0.0)}};
  if (shape.kind == ConvexKind::Cylinder) return distance_to_cylinder(shape, a);
  return distance_to_rounded_box(shape, a);
}

/// Lower bound of the signed distance of all points in an axis-aligned box of the shape's frame, where it is positive;
/// exact for half-spaces, spheres, capsules and boxes.
KERNEL double distance_to_box(const ConvexShape& shape, const Vector3<double>& centre, const Vector3<double>& half) {
  if (shape.kind == ConvexKind::HalfSpace) return centre.y - half.y;
  const auto beyond = [](double c, double extent) KERNEL_LAMBDA { return max(abs(c) - extent, 0.0); };
  const double y = beyond(centre.y, half.y + shape.half.y);
  if (shape.kind == ConvexKind::RoundedBox) {
    const double x = beyond(centre.x, half.x + shape.half.x), z = beyond(centre.z, half.z + shape.half.z);
    return sqrt(x * x + y * y + z * z) - shape.radius;
  }
  const double x = beyond(centre.x, half.x), z = beyond(centre.z, half.z);
  const double side = max(sqrt(x * x + z * z) - shape.radius, 0.0);
  return sqrt(side * side + y * y);
}

/// The point a + t way of a straight path at which a search ended, and the surface there.
template <class S>
struct PathPoint {
  S t;
  SurfaceDistance<S> at;
};

inline constexpr int kMaxAdvances = 32;  // of Newton's method; paths that graze a shape converge slowly

/// Follows the path from a (where the surface is `start`) along `way` until it is at the distance `level` of the shape,
/// leaves, or ends. What is left above the level is at most `tolerance` where it arrives.
template <class S>
KERNEL PathPoint<S> advance_to(const ConvexShape& shape, const Vector3<S>& a, const Vector3<S>& way,
                               const SurfaceDistance<S>& start, const S& level, double tolerance) {
  const S zero(0.0), one(1.0);
  PathPoint<S> point{zero, start};
  for (int k = 0; k < kMaxAdvances; ++k) {
    const S above = point.at.distance - level, slope = dot(point.at.normal, way);
    const auto goes_on = (above > S(tolerance)) & (slope < zero) & (point.t < one);
    if (movemask(goes_on) == 0) break;
    const S step = above / select(goes_on, -slope, one);
    point.t = select(goes_on, min(point.t + step, one), point.t);
    const SurfaceDistance<S> next = distance_to(shape, a + way * point.t);
    point.at.distance = select(goes_on, next.distance, point.at.distance);
    point.at.normal = select_vector(goes_on, next.normal, point.at.normal);
  }
  return point;
}

/// A shape of the environment in a substep.
struct MovingShape {
  ConvexShape shape;
  Pose before, after;                       // from the shape's frame to the world, at the substep's start and end
  Pose motion;                              // in the substep, world to world
  bool rests;                               // before and after are the same, and motion is the identity
  double turn;                              // bound of |R v - v| / |v| for the rotation R of the motion
  double thickness, friction, restitution;  // m
};

/// The box around a group's particles at the start of a substep, and a bound of their displacements, m.
struct GroupReach {
  Vector3<double> centre, half;
  double path;
  bool empty;  // no particle of the group can move

  /// Lower bound of the distance of the box from a shape at the start of the substep, m.
  KERNEL double distance(const MovingShape& of) const {
    const Pose& pose = of.before;
    if (!pose.moves) return distance_to_box(of.shape, centre, half);
    const auto extent = [&](int k) KERNEL_LAMBDA {
      return abs(pose.r[k]) * half.x + abs(pose.r[3 + k]) * half.y + abs(pose.r[6 + k]) * half.z;
    };
    return distance_to_box(of.shape, to_local(pose, centre), {extent(0), extent(1), extent(2)});
  }
  /// Tells whether any path of the group may come nearer to a shape than `range` (m), in the frame of the shape.
  KERNEL bool may_come_near(const MovingShape& of, double range) const {
    if (empty) return false;
    double length = path;
    if (!of.rests) length += norm(to_world(of.motion, centre) - centre) + of.turn * norm(half);
    return !(distance(of) > length + range);
  }
};

}  // namespace malha
