// SPDX-License-Identifier: Apache-2.0
// Sleep: the velocities of a scene in which nothing has moved for a while are cleared, and its steps do nothing until
// it is woken. The whole scene sleeps at once, with everything that its bodies touch or are attached to.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "host/attachments/object_motion.h"
#include "host/attachments/pose.h"
#include "host/mesh/bounding_box.h"
#include "host/model/model.h"
#include "kernels/forces/sleep.h"

namespace malha {

/// Bounding sphere of a moving environment object.
struct Mover {
  const EnvironmentMesh* deforming;  // null: it moves rigidly
  std::vector<Keyframe> motion;
  Vector3<double> centre;  // in the mesh's frame, m
  double radius, reach;    // of the sphere; range of its contacts beyond the surface (m)
  VertexBuffer before{}, after{};
};

inline std::vector<Mover> movers_of(const Model& model) {
  std::vector<Mover> movers;
  for (const EnvironmentMesh& object : model.environment) {
    if (!moves(object)) continue;
    const auto [low, high] = bounds_of(object.mesh.points);
    const Vector3<double> a{low[0], low[1], low[2]}, b{high[0], high[1], high[2]};
    const bool infinite = object.exact && object.exact->shape.kind == ConvexKind::HalfSpace;
    movers.push_back({deforms(object) ? &object : nullptr, object.spec.motion, (a + b) * 0.5,
                      infinite ? INFINITY : norm(b - a) / 2, 2 * object.spec.thickness});
  }
  const auto add_everywhere = [&](const auto& sets) {  // pins and attachments act wherever the box is
    for (const auto& set : sets)
      if (!set.target.motion.empty()) movers.push_back({nullptr, set.target.motion, {0, 0, 0}, INFINITY, 0});
  };
  add_everywhere(model.moved), add_everywhere(model.attached);
  return movers;
}

/// Times at which pins or attachments are released (s).
inline std::vector<double> releases_of(const Model& model) {
  std::vector<double> releases;
  const auto add = [&](const auto& sets) {
    for (const auto& set : sets)
      if (set.release_time) releases.push_back(*set.release_time);
  };
  add(model.moved), add(model.attached);
  return releases;
}

inline bool same(const Pose& a, const Pose& b) {
  return std::equal(a.r, a.r + 9, b.r) && a.t.x == b.t.x && a.t.y == b.t.y && a.t.z == b.t.z;
}

/// Tells whether an object moves within its range of the box between two times (s).
inline bool moves_near(Mover& mover, const Bounds& box, double start, double end) {
  if (mover.deforming)
    return points_at(*mover.deforming, start, mover.before) != points_at(*mover.deforming, end, mover.after);
  const Pose before = pose_at(mover.motion, start), after = pose_at(mover.motion, end);
  if (same(before, after)) return false;
  const Vector3<double> a = to_world(before, mover.centre), b = to_world(after, mover.centre);
  const Vector3<double> way = b - a;
  // The whole path, straight or curved, is inside the sphere about the start that is larger by twice its length.
  const double far = mover.radius + mover.reach + 2 * sqrt(dot(way, way));
  double distance2 = 0;
  const double at[3] = {a.x, a.y, a.z};
  for (int k = 0; k < 3; ++k) {
    const double out = std::max({box.lower[k] - at[k], at[k] - box.upper[k], 0.0});
    distance2 += out * out;
  }
  return distance2 <= far * far;
}

template <class Executor, class R>
class Sleeper {
 public:
  Sleeper(const Executor& executor, const Model& model)
      : executor_(executor),
        speed_(model.scene.sleep->speed),
        calm_enough_(
            std::max<std::int64_t>(1, std::llround(std::min(model.scene.sleep->after / model.scene.solver.dt, 1e15)))),
        movers_(movers_of(model)),
        releases_(releases_of(model)) {}

  bool asleep() const { return since_ >= 0; }
  /// The step after which it fell asleep; -1: awake.
  std::int64_t since() const { return since_; }
  void wake() { calm_ = 0, since_ = -1; }
  /// Must be called after the motion of an object has changed.
  void change_environment(const Model& model) { movers_ = movers_of(model); }

  /// Tells whether the scene sleeps through the step from `start` to `end` (s). Objects that move nearby wake it.
  bool sleeps_through(const Particles<R>& particles, double start, double end) {
    if (asleep() && disturbed(particles, start, end)) wake();
    return asleep();
  }

  /// Called after a step that was computed.
  void watch(const Particles<R>& particles, double start, double end, std::int64_t steps) {
    const double fastest2 = parallel_reduce<Largest>(executor_, particles.count, MeasureSpeed<R>{particles}).value;
    const bool calm = fastest2 < speed_ * speed_ && !disturbed(particles, start, end);
    calm_ = calm ? calm_ + 1 : 0;
    if (calm_ < calm_enough_) return;
    parallel_for(executor_, particles.count, ClearVelocity<R>{particles.v});
    since_ = steps;
  }

  /// State for checkpoints.
  std::vector<std::int64_t> save_state() const { return {calm_, since_}; }
  void restore_state(const std::vector<std::int64_t>& saved) { calm_ = saved[0], since_ = saved[1]; }

 private:
  bool disturbed(const Particles<R>& particles, double start, double end) {
    const double dt = end - start;  // releases count in both adjacent steps, however time is rounded
    if (std::ranges::any_of(releases_, [&](double time) { return time > start - dt && time < end + dt; })) return true;
    if (movers_.empty()) return false;
    const Bounds box = parallel_reduce<Bounds>(executor_, particles.count, MeasureBounds<R>{particles.x});
    return std::ranges::any_of(movers_, [&](Mover& mover) { return moves_near(mover, box, start, end); });
  }

  Executor executor_;
  double speed_;              // m/s
  std::int64_t calm_enough_;  // steps
  std::vector<Mover> movers_;
  std::vector<double> releases_;  // s
  std::int64_t calm_ = 0, since_ = -1;
};

}  // namespace malha
