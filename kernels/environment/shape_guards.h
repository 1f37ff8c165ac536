// SPDX-License-Identifier: Apache-2.0
// Guards of exact shapes of the environment: no path of a particle enters one, whatever moved it there; and how far
// particles are from all of them.
#pragma once
#include "kernels/environment/clearance.h"
#include "kernels/environment/edge_detection.h"
#include "kernels/environment/shape_contacts.h"

namespace malha {

/// Where the path of a particle enters a shape.
struct ShapeCrossing {
  bool hit;
  Vector3<double> q, normal;  // in the shape's frame
};

/// Paths of the particles of a group, and the shapes that they enter.
template <class R>
struct PathsIntoShapes : ShapeView<R> {
  /// Calls work(i) for the particles whose path may enter a shape, one at a time.
  template <class Group, class Work>
  KERNEL void for_each_candidate(const Group& group, const Work& work) const {
    const int begin = group.index * kGroupSize;
    const GroupReach reach = reach_of(group, static_cast<const ShapeView<R>&>(*this));
    for (int k = 0; k < this->count; ++k) {
      const MovingShape& moving = this->shapes[k];
      if (!reach.may_come_near(moving, 0)) continue;
      for_each_pack_once<double>(group, this->group_count(group.index), [&](int lane, auto t) KERNEL_LAMBDA {
        unsigned rest = candidates(moving, begin + lane, t);
        for (; rest != 0; rest &= rest - 1) work(begin + lane + lowest_bit(rest));
      });
    }
  }

  /// The path of particle i into shape k. One that starts inside may go no deeper.
  KERNEL ShapeCrossing crossing(int i, int k) const {
    const MovingShape& moving = this->shapes[k];
    const Vector3<double> x = this->start(i, double()), p = x + this->displacement(i, double());
    const Vector3<double> a = to_local(moving.before, x), way = to_local(moving.after, p) - a;
    const SurfaceDistance<double> start = distance_to(moving.shape, a);
    const double tolerance = kTouches * moving.thickness,
                 level = start.distance >= 0 ? 0 : start.distance - kDeeper * moving.thickness;
    const PathPoint<double> end = advance_to(moving.shape, a, way, start, level, tolerance);
    // A path that leaves or ends outside has not entered. (One that still advances grazes the shape, and counts.)
    if (end.t >= 1 ? !(end.at.distance < level) : !(dot(end.at.normal, way) < 0)) return {false, {}, {}};
    return {true, a + way * end.t - end.at.normal * end.at.distance, end.at.normal};
  }

 private:
  static constexpr double kTouches = 1e-9, kDeeper = 1e-3;  // of the thickness

  template <class S>
  KERNEL unsigned candidates(const MovingShape& moving, int i, S t) const {
    const S zero(0.0);
    const Vector3<S> x = this->start(i, t), a = to_local(moving.before, x),
                     b = to_local(moving.after, x + this->displacement(i, t)), way = b - a;
    const S at_a = distance_to(moving.shape, a).distance, at_b = distance_to(moving.shape, b).distance;
    // The distance changes by at most the length of the way.
    const auto clear = (at_a > zero) & (at_b > zero) & (sqrt(dot(way, way)) <= at_a + at_b);
    const auto moves = this->can_move(i, t);
    return movemask(moves) & ~movemask(clear);
  }
};

/// Clamps the particles whose paths enter shapes: in front of them, and in front of all of them where there are
/// several; others stay where the substep began. Counts the particles that it moves, and marks them with their owner.
template <class R>
struct ClampAtShapes : PathsIntoShapes<R> {
  using Shared = void;
  bool move_with_shapes;  // a particle that enters a shape moves with it first, from where the substep began
  KinematicMarks<R> marks;
  int* moved;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    this->for_each_candidate(group, [this](int i) KERNEL_LAMBDA { clamp(i); });
  }

 private:
  static constexpr int kRounds = 8;  // as ClampTunnelling has

  KERNEL void clamp(int i) const {
    int entered = 0;
    while (entered < this->count && !this->crossing(i, entered).hit) ++entered;
    if (entered == this->count) return;
    const Vector3<R> before = this->particles.p.d[i];
    if (move_with_shapes) this->particles.p.d.set(i, rigid_displacement(entered, i));
    if (!clamp_to_all(i)) {
      // Each shape pushes it into another one: it stays where the substep began, unless a moving shape pushes it from
      // there.
      this->particles.p.clear_displacement(i);
      clamp_to_all(i);
    }
    if (same(before, this->particles.p.d[i])) return;
    atomic_increment(moved);
    if (!marks.is_enabled()) return;
    KinematicOwner owner = 0;
    while (owner < this->count && !same(this->particles.p.d[i], rigid_displacement(owner, i))) ++owner;
    marks.w[i] = R(0), marks.owner[i] = owner < this->count ? marks.number + owner : kNoOwner;
  }

  KERNEL Vector3<R> rigid_displacement(int k, int i) const {
    if (this->shapes[k].rests) return {R(0), R(0), R(0)};
    const Vector3<double> x = in_double(this->particles.x[i]);
    return rounded<R>(to_world(this->shapes[k].motion, x) - x);
  }

  /// Clamps a particle in front of every shape in turn until it enters none. Returns false if it still does.
  KERNEL bool clamp_to_all(int i) const {
    for (int round = 0; round < kRounds; ++round) {
      bool entered = false;
      for (int k = 0; k < this->count; ++k) entered = clamp_to(i, k) || entered;
      if (!entered) return true;
    }
    return false;
  }

  KERNEL bool clamp_to(int i, int k) const {
    const ShapeCrossing at = this->crossing(i, k);
    if (!at.hit) return false;
    const MovingShape& moving = this->shapes[k];
    const R* const overlaps = this->kept.find(i / kGroupSize, this->count, k);
    const double height = moving.thickness - (overlaps ? double(overlaps[i % kGroupSize]) : 0.0);
    const Vector3<double> p = this->start(i, double()) + this->displacement(i, double());
    const double lift = height - dot(at.normal, to_local(moving.after, p) - at.q);
    this->particles.p.add_displacement(i, rounded<R>(rotate(moving.after, at.normal) * lift));
    return true;
  }
};

/// Cancels the motion by restitution of particles that it would move into a shape, which rests at its pose at the
/// substep's end.
template <class R>
struct CancelMotionIntoShapes : PathsIntoShapes<R> {
  using Shared = void;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    this->for_each_candidate(group, [this](int i) KERNEL_LAMBDA {
      for (int k = 0; k < this->count; ++k)
        if (this->crossing(i, k).hit) return this->particles.p.clear_displacement(i);
    });
  }
};

/// Measures the clearance of a group from all shapes at rest, and its largest speed.
template <class R>
struct MeasureShapeClearance : ShapeView<R> {
  using Shared = void;
  double rounding;  // relative error of positions
  Clearance* clearance;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const GroupReach reach =
        bounds_of(group, static_cast<const ShapeView<R>&>(*this), [this](int i, auto t) KERNEL_LAMBDA {
          const auto v = load_points<decltype(t)>(this->particles.v, i);
          return dot(v, v);
        });
    double distance = INFINITY;
    for (int k = 0; k < this->count && !reach.empty; ++k) {
      const double near = reach.distance(this->shapes[k]) - 2 * this->shapes[k].thickness;
      distance = near < distance ? near : distance;
    }
    const auto size = [](const Vector3<double>& a) KERNEL_LAMBDA { return abs(a.x) + abs(a.y) + abs(a.z); };
    if (!reach.empty) distance = distance - rounding * (size(reach.centre) + size(reach.half) + abs(distance));
    group.for_each(1, [&](int) KERNEL_LAMBDA {
      clearance[group.index] = {float(distance), reach.empty ? 0.0f : float(reach.path)};
    });
  }
};

/// Depth of a particle in the shapes.
template <class R>
struct MeasureDepthInShapes {
  Particles<R> particles;
  const MovingShape* shapes;
  int count;
  KERNEL Deepest operator()(int i) const {
    Deepest deepest;
    if (!(particles.w[i] > R(0))) return deepest;
    Vector3<double> x = in_double(particles.x[i]);
    if constexpr (kCompensated<R>) x = x + in_double(particles.p.low[i]);
    for (int k = 0; k < count; ++k) deepest += {-distance_to(shapes[k].shape, to_local(shapes[k].before, x)).distance};
    return deepest;
  }
};

}  // namespace malha
