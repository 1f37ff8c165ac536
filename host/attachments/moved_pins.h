// SPDX-License-Identifier: Apache-2.0
// Kinematic pins: pins that follow keyframes or are released. Made only for scenes that have some.
#pragma once
#include <deque>
#include <string>
#include <vector>

#include "host/attachments/pose.h"
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

/// Anchors of particles that start at x, in the target's moving frame.
inline std::vector<Vector3<double>> anchors(const Target& target, const std::vector<int>& particles,
                                            const std::vector<Vec3>& x) {
  const Pose start = target.environment.empty() ? Pose{} : pose_at(target.motion, 0);
  std::vector<Vector3<double>> places;
  for (const int i : particles) {
    const Vec3& at = target.point ? *target.point : x[i];
    places.push_back(to_local(start, {at[0], at[1], at[2]}));
  }
  return places;
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
      set.target = pins.target, set.release_time = pins.release_time;
      set.list = Array<Executor, int>(pins.particles);
      if (pins.target.moves())
        set.start = Array<Executor, Vector3<double>>(anchors(pins.target, pins.particles, model.x));
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
      if (set.released || !set.target.moves()) continue;
      parallel_for(executor_, count(set),
                   MoveToTarget<R>{all, set.list.data(), set.start.data(), pose_at(set.target.motion, end)});
    }
  }
  /// Sets positions and velocities of moved pins at the end of a substep.
  void arrive(const Particles<R>& all, double start, double end) {
    for (Set& set : sets_)
      if (!set.released && set.target.moves())
        parallel_for(executor_, count(set),
                     ArriveAtTarget<R>{all, set.list.data(), set.start.data(), pose_at(set.target.motion, start),
                                       pose_at(set.target.motion, end), 1 / (end - start)});
  }

  /// Returns true if keyframes move the particle, or its pin was released.
  bool refuses(int particle) const {
    for (const Set& set : sets_) {
      const std::vector<int> list = set.list.download();
      if (set.released || set.target.moves())
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
    for (const Set& set : sets_) sum += set.list.bytes() + set.start.bytes() + set.free.bytes();
    return sum;
  }

 private:
  struct Set {
    Target target;
    std::optional<double> release_time;
    Array<Executor, int> list;
    Array<Executor, Vector3<double>> start;
    Array<Executor, R> free;
    bool released = false;
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
