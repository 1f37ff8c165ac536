// SPDX-License-Identifier: Apache-2.0
// Rest and sleep: a scene in which nothing has moved for a while is stilled, and its steps do nothing until something
// wakes it. The whole scene at once: whatever its bodies touch or are tied to sleeps with them.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "host/attachments/pose.h"
#include "host/model/model.h"
#include "kernels/forces/sleep.h"

namespace malha {

/// An environment object that moves, as a ball about its mesh.
struct Mover {
  std::vector<Keyframe> motion;
  Vector3<double> centre;  // in the mesh's frame, m
  double radius, reach;    // of the ball; how far from the surface it acts (m)
};

/// Pins and attachments that move act wherever they are.
inline Mover everywhere(const std::vector<Keyframe>& motion) { return {motion, {0, 0, 0}, INFINITY, 0}; }

inline std::vector<Mover> movers_of(const Model& model) {
  std::vector<Mover> movers;
  for (const EnvironmentMesh& object : model.environment) {
    if (object.spec.motion.empty()) continue;
    Bounds box;
    for (const Vec3& p : object.mesh.points) box += Bounds{{p[0], p[1], p[2]}, {p[0], p[1], p[2]}};
    const Vector3<double> low{box.lower[0], box.lower[1], box.lower[2]}, high{box.upper[0], box.upper[1], box.upper[2]};
    const Vector3<double> across = high - low;
    movers.push_back(
        {object.spec.motion, (low + high) * 0.5, sqrt(dot(across, across)) / 2, 2 * object.spec.thickness});
  }
  for (const MovedPins& pins : model.moved) movers.push_back(everywhere(pins.target.motion));
  for (const AttachmentSet& set : model.attached) movers.push_back(everywhere(set.target.motion));
  std::erase_if(movers, [](const Mover& mover) { return mover.motion.empty(); });
  return movers;
}

/// When something is let go (s).
inline std::vector<double> releases_of(const Model& model) {
  std::vector<double> releases;
  for (const MovedPins& pins : model.moved)
    if (pins.release_time) releases.push_back(*pins.release_time);
  for (const AttachmentSet& set : model.attached)
    if (set.release_time) releases.push_back(*set.release_time);
  return releases;
}

inline bool same(const Pose& a, const Pose& b) {
  return std::equal(a.r, a.r + 9, b.r) && a.t.x == b.t.x && a.t.y == b.t.y && a.t.z == b.t.z;
}

/// Whether it moves within its reach of the box between two times (s).
inline bool moves_near(const Mover& mover, const Bounds& box, double start, double end) {
  const Pose before = pose_at(mover.motion, start), after = pose_at(mover.motion, end);
  if (same(before, after)) return false;
  const Vector3<double> a = to_world(before, mover.centre), b = to_world(after, mover.centre);
  const Vector3<double> way = b - a;
  // Everywhere on its way, straight or bent: the ball about the start, wider by twice the way.
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

  /// Whether the step from `start` to `end` (s) is slept through. What moves near wakes.
  bool sleeps_through(const Particles<R>& particles, double start, double end) {
    if (asleep() && disturbed(particles, start, end)) wake();
    return asleep();
  }

  /// After a step that was not slept through.
  void watch(const Particles<R>& particles, double start, double end, std::int64_t steps) {
    const double fastest2 = parallel_reduce<Largest>(executor_, particles.count, MeasureSpeed<R>{particles}).value;
    const bool calm = fastest2 < speed_ * speed_ && !disturbed(particles, start, end);
    calm_ = calm ? calm_ + 1 : 0;
    if (calm_ < calm_enough_) return;
    parallel_for(executor_, particles.count, Still<R>{particles.v});
    since_ = steps;
  }

  /// What a later step depends on, for checkpoints.
  std::vector<std::int64_t> save_state() const { return {calm_, since_}; }
  void restore_state(const std::vector<std::int64_t>& saved) { calm_ = saved[0], since_ = saved[1]; }

 private:
  bool disturbed(const Particles<R>& particles, double start, double end) const {
    const double dt = end - start;  // a release counts in the steps at both of its sides, however time is rounded
    if (std::any_of(releases_.begin(), releases_.end(),
                    [&](double time) { return time > start - dt && time < end + dt; }))
      return true;
    if (movers_.empty()) return false;
    const Bounds box = parallel_reduce<Bounds>(executor_, particles.count, MeasureBounds<R>{particles.x});
    return std::any_of(movers_.begin(), movers_.end(),
                       [&](const Mover& mover) { return moves_near(mover, box, start, end); });
  }

  Executor executor_;
  double speed_;              // m/s
  std::int64_t calm_enough_;  // steps
  std::vector<Mover> movers_;
  std::vector<double> releases_;  // s
  std::int64_t calm_ = 0, since_ = -1;
};

}  // namespace malha
