// SPDX-License-Identifier: Apache-2.0
// Kinematic pins: pins that follow keyframes or are released. Made only for scenes that have some.
#pragma once
#include <cmath>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "host/attachments/pose.h"
#include "host/attachments/surface_points.h"
#include "host/base/array.h"
#include "host/model/model.h"
#include "host/model/ordering/index_map.h"
#include "kernels/attachments/attachment.h"
#include "malha/error.h"

namespace malha {

/// Returns true if the release time has passed at the start of a substep at `time` (s), up to rounding.
inline bool is_over(const std::optional<double>& release_time, double time, double h) {
  return release_time && time >= *release_time - 1e-6 * h;
}

/// Anchor of a particle that starts at x, in the target's moving frame.
inline Vector3<double> anchor_of(const Target& target, const Vec3& x) {
  const Vec3& at = target.point ? *target.point : x;
  return to_local(target.environment.empty() ? Pose{} : pose_at(target.motion, 0), {at[0], at[1], at[2]});
}
/// Anchors of particles that start at x.
inline std::vector<Vector3<double>> anchors(const Target& target, const std::vector<int>& particles,
                                            const std::vector<Vec3>& x) {
  std::vector<Vector3<double>> places;
  for (const int i : particles) places.push_back(anchor_of(target, x[i]));
  return places;
}

/// The targets as points of an object that deforms; none: they move rigidly.
inline std::optional<SurfacePoints> surface_points(const Model& model, const Target& target,
                                                   const std::vector<int>& particles) {
  if (!target.deforms) return std::nullopt;
  const auto object = std::ranges::find(model.environment, target.environment,
                                        [](const EnvironmentMesh& one) { return one.spec.name; });
  std::vector<Vector3<double>> places = anchors(target, particles, model.x);
  const Pose start = pose_at(target.motion, 0);
  for (Vector3<double>& at : places) at = to_world(start, at);
  return SurfacePoints(*object, places);
}

/// Converts the user's particle numbers to the solver's. Throws InputError for a particle that is not `good`.
template <class Good>
std::vector<int> pins_of(const Model& model, const std::vector<int>& particles, const Good& good) {
  const std::vector<int> of = solver_of(model.user_index);
  std::vector<int> list;
  for (const int user : particles) {
    if (user < 0 || user >= model.count() || !good(of[user]))
      throw InputError("move_pin: found particle " + std::to_string(user) +
                       ", which is not pinned; allowed: one that is, and that no keyframes move");
    list.push_back(of[user]);
  }
  return list;
}

/// Pins that will be released are laid out as movable particles and pinned by w = 0 until then, so that no layout
/// changes.
template <class Executor, class R>
class KinematicPins {
 public:
  KinematicPins(const Executor& executor, const Model& model) : executor_(executor), substep_(substep_of(model)) {
    for (const MovedPins& pins : model.moved) {
      Set& set = sets_.emplace_back();
      set.target = &pins.target, set.release_time = pins.release_time;
      set.list = Array<Executor, int>(pins.particles);
      if (pins.target.moves())
        set.start = Array<Executor, Vector3<double>>(anchors(pins.target, pins.particles, model.x));
      set.surface = surface_points(model, pins.target, pins.particles);
      if (set.surface) set.end = Array<Executor, Vector3<double>>(pins.particles.size(), Vector3<double>{0, 0, 0});
      std::vector<R> w;
      for (const int i : pins.particles) w.push_back(R(model.w[i]));
      if (pins.release_time) set.free = Array<Executor, R>(w);
    }
  }

  /// Pins or releases particles as at a substep that starts at `time`: for the start of a run, and after a state is
  /// restored.
  void set_pinned(double time, R* w) {
    for (Set& set : sets_) {
      if (!set.release_time) continue;
      set.released = is_over(set.release_time, time, substep_);
      set_inverse_mass(set, w);
    }
  }

  /// Releases pins and moves the others at the start of a substep.
  void move(const Particles<R>& all, R* w, double start, double end) {
    for (Set& set : sets_) {
      if (!set.released && is_over(set.release_time, start, substep_)) set.released = true, set_inverse_mass(set, w);
      if (set.released || !set.target->moves()) continue;
      if (set.surface) set.follow(start, end);
      parallel_for(executor_, count(set), MoveToTarget<R>{all, set.list.data(), set.end_places(), set.pose(end)});
    }
  }
  /// Sets positions and velocities of moved pins at the end of a substep.
  void arrive(const Particles<R>& all, double start, double end) {
    for (Set& set : sets_)
      if (!set.released && set.target->moves())
        parallel_for(executor_, count(set),
                     ArriveAtTarget<R>{all, set.list.data(), set.start.data(), set.end_places(), set.pose(start),
                                       set.pose(end), 1 / (end - start)});
  }

  /// Returns true if keyframes move the particle, or its pin was released.
  bool refuses(int particle) const {
    for (const Set& set : sets_) {
      const std::vector<int> list = set.list.download();
      if (set.released || set.target->moves())
        if (std::ranges::find(list, particle) != list.end()) return true;
    }
    return false;
  }

  /// Number of sets that were released.
  int released() const {
    return static_cast<int>(std::ranges::count_if(sets_, [](const Set& set) { return set.released; }));
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Set& set : sets_) sum += set.list.bytes() + set.start.bytes() + set.end.bytes() + set.free.bytes();
    return sum;
  }

 private:
  struct Set {
    const Target* target;  // of the model, whose motion the program may change
    std::optional<double> release_time;
    Array<Executor, int> list;
    Array<Executor, Vector3<double>> start;  // in the target's frame; of a surface: at the start of the substep, m
    std::optional<SurfacePoints> surface;    // of an object that deforms
    Array<Executor, Vector3<double>> end;    // of a surface: at the end of the substep
    double time = NAN;                       // of `end`, s
    Array<Executor, R> free;
    bool released = false;

    Pose pose(double at) const { return surface ? Pose{} : pose_at(target->motion, at); }
    const Vector3<double>* end_places() const { return surface ? end.data() : start.data(); }
    /// Moves the places on a surface to those of a substep.
    void follow(double from, double to) {
      std::swap(start, end);
      if (time != from) start.upload(surface->at(from));
      end.upload(surface->at(to)), time = to;
    }
  };
  static double substep_of(const Model& model) { return model.scene.solver.dt / model.scene.solver.substeps; }
  static int count(const Set& set) { return static_cast<int>(set.list.size()); }
  void set_inverse_mass(const Set& set, R* w) {
    parallel_for(executor_, count(set),
                 SetInverseMass<R>{w, set.list.data(), set.released ? set.free.data() : nullptr});
  }

  Executor executor_;
  double substep_;  // s
  std::deque<Set> sets_;
};

}  // namespace malha
