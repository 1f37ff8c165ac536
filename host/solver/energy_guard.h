// SPDX-License-Identifier: Apache-2.0
// Stops a run whose kinetic energy exceeds what forces, pins and stored energy can explain. A body that falls, is
// thrown, blown or dragged has no more energy of motion than that gave it, and constraints give back what they held;
// what has many times as much is an explosion, finite or not.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
#include "host/model/ordering/particle_runs.h"
#include "kernels/measure/motion_energy.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// The group of each particle (the solver's order). A body is one; those that self-collision lets touch are one
/// together, as they may give each other all that they have.
std::vector<int> groups_of(const Model& model);

/// What a group of bodies may have without a question: kg; J of motion and of height at the start, and at any time.
struct Allowance {
  double mass = 0, motion = 0, height = 0, always = 0;
};
std::vector<Allowance> allowances(const Model& model, const std::vector<int>& group_of);

/// J in the constraints of each kind at `x` (the solver's order), in substeps of h seconds: C^2 / (2 (alpha + h^2 sum w
/// |grad C|^2)), which is the energy of a compliance alpha, and of a stiff one what meeting it in a substep gives.
/// Of each group. In the order of sets, stencils, springs, pressures, attachments.
struct HeldEnergy {
  std::string kind;
  std::vector<double> energy;
};
std::vector<HeldEnergy> held_energies(const Model& model, const std::vector<Vec3>& x, double h,
                                      const std::vector<int>& group_of, int groups);
double sum_of(const std::vector<HeldEnergy>& held, int group);

/// The fastest that anything which moves by keyframes, or the air, ever moves (m/s). A jump counts as made in h
/// seconds.
double fastest_driven(const Model& model, double h);
/// Of the environment alone.
double fastest_object(const Model& model, double h);

/// The last steps before pins and attachments let go; and those before keyframes of their paths, at least `apart`
/// steps from each other.
std::vector<std::int64_t> turns_of(const Model& model, std::int64_t apart);

/// What the guard says of an explosion: how much energy, where it is fastest, and which kind gained most.
struct Explosion {
  int group;
  const std::vector<int>& of;  // the group of each particle
  double kinetic, given;       // J
};
std::string explosion(const Model& model, const Explosion& seen, const std::vector<Vec3>& x, const std::vector<Vec3>& v,
                      const std::vector<HeldEnergy>& before, const std::vector<HeldEnergy>& now);

/// Of its own size a body may go 1 % in a step, or in so many seconds if that is longer: a step says how often a run is
/// looked at, not how fast bodies are.
inline constexpr double kBrief = 1.0 / 60;

/// Reads only, every 32nd step (128th where a step is one projection), which is less than 1 % of them, and where it is
/// told to. Each group of bodies by itself: a light one explodes beside a heavy one. Given to a group is:
/// - the energy of motion at the start, or where a state was restored,
/// - height: the most potential energy that was seen less that of now (whoever lifts gives it),
/// - twice the energy of all going with the fastest of what drives: air, pins, attachments and objects on keyframes,
/// - that of a step's fall, and of every body going 1 % of its size (see kBrief), which is rounding's and contacts'
/// own,
/// - what constraints hold at the start; and, if something drives them, hold later. This is dear, and is only added up
///   where the others do not explain a motion, or, for what is driven, after 32, 64, 128 ... steps, where a path has a
///   keyframe (at most every 32nd step), and before anything is let go: a band that is drawn holds most there.
/// All of it errs on the side of what is given: a late alarm is better than a false one.
/// kFactor: stable settings are below 1, the study of stability finds settings that are bounded but wrong up to 10, and
/// an explosion passes any factor soon. 100 is ten times the speed that can be explained.
template <class Executor, class R>
class EnergyGuard {
 public:
  static constexpr double kFactor = 100;

  EnergyGuard(const Executor& executor, const Model& model)
      : executor_(executor), model_(model), h_(model.scene.solver.dt / model.scene.solver.substeps) {
    const SolverSpec& solver = model.scene.solver;
    while (every_ * solver.substeps * solver.iterations < 128) every_ *= 2;
    drives_ = fastest_driven(model, h_) > 0;
    if (drives_) turns_ = turns_of(model, every_);
    const std::vector<int> of = groups_of(model);
    for (const Allowance& one : allowances(model, of)) groups_.push_back({one, one.height});
    runs_ = particle_runs(of);
    device_runs_ = Array<Executor, ParticleRun>(runs_);
    sums_ = Array<Executor, MotionEnergy>(runs_.size(), MotionEnergy{});
  }

  /// Starts anew from a state that is not that of the scene.
  void restart(const Particles<R>& particles, std::vector<Vec3> x) {
    const std::vector<MotionEnergy> now = measure(particles);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      Group& group = groups_[g];
      group.may.motion = now[g].kinetic, group.highest = now[g].potential, group.given = group.held_most = 0;
    }
    start_ = std::move(x), held_.clear();
  }
  /// Steps between two looks.
  std::int64_t every() const { return every_; }
  /// A pin was moved by hand, by so many m.
  void moved(double way) { driven(way / h_); }
  /// Pins or the air move at so many m/s from now on, or gravity adds that much in a step.
  void driven(double speed) {
    for (Group& group : groups_) group.may.always += group.may.mass * speed * speed;
    drives_ = true;
  }
  /// What acts on these particles may give any energy, as a motor does.
  void trust(const std::vector<int>& particles) {
    const std::vector<int> of = group_of();
    for (const int i : particles) groups_[of[i]].may.always = std::numeric_limits<double>::infinity();
  }

  /// A hand gave so many J to the group of a particle.
  void gave(int particle, double joules) {
    const auto after = std::find_if(runs_.begin(), runs_.end(),
                                    [particle](const ParticleRun& run) { return particle < run.first + run.count; });
    groups_[after->group].may.always += joules;
    drives_ = true;
  }

  /// After step `steps`, if it is one to look at or `now`: what is wrong, if anything is.
  template <class Positions, class Velocities>
  std::optional<std::string> watch(const Particles<R>& particles, std::int64_t steps, const Positions& positions,
                                   const Velocities& velocities, bool now = false) {
    if (drives_ &&
        ((steps >= every_ && (steps & (steps - 1)) == 0) || std::binary_search(turns_.begin(), turns_.end(), steps))) {
      const std::vector<HeldEnergy> present = held(positions());
      for (std::size_t g = 0; g < groups_.size(); ++g)
        groups_[g].held_most = std::max(groups_[g].held_most, sum_of(present, int(g)));
    }
    if (steps % every_ != 0 && !now) return std::nullopt;
    const std::vector<MotionEnergy> energy = measure(particles);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      Group& group = groups_[g];
      group.highest = std::max(group.highest, energy[g].potential);
      group.given = std::max(group.given, group.may.always + group.may.motion + group.highest - energy[g].potential);
      if (!(energy[g].kinetic > kFactor * (group.given + group.held_most))) continue;
      if (held_.empty()) held_ = held(start_.empty() ? model_.x : start_);
      group.held_most = std::max(group.held_most, sum_of(held_, int(g)));
      if (!(energy[g].kinetic > kFactor * (group.given + group.held_most))) continue;
      const std::vector<Vec3> x = positions();
      const std::vector<int> of = group_of();
      return explosion(model_, {int(g), of, energy[g].kinetic, group.given + group.held_most}, x, velocities(), held_,
                       held(x));
    }
    return std::nullopt;
  }

 private:
  struct Group {
    Allowance may;
    double highest;  // J of height, the most seen
    double given = 0, held_most = 0;
  };

  std::vector<MotionEnergy> measure(const Particles<R>& particles) const {
    const Vec3& g = model_.scene.gravity;
    parallel_for(executor_, int(runs_.size()),
                 MeasureRuns<R>{{particles, {g[0], g[1], g[2]}}, device_runs_.data(), sums_.data()}, 8);
    const std::vector<MotionEnergy> sums = sums_.download();
    std::vector<MotionEnergy> of(groups_.size());
    for (std::size_t r = 0; r < runs_.size(); ++r) of[runs_[r].group] += sums[r];
    return of;
  }
  std::vector<int> group_of() const {
    std::vector<int> of;
    for (const ParticleRun& run : runs_) of.insert(of.end(), run.count, run.group);
    return of;
  }
  std::vector<HeldEnergy> held(const std::vector<Vec3>& x) const {
    return held_energies(model_, x, h_, group_of(), int(groups_.size()));
  }

  Executor executor_;
  const Model& model_;
  std::int64_t every_ = 32;
  double h_;  // s
  std::vector<Group> groups_;
  std::vector<ParticleRun> runs_;
  Array<Executor, ParticleRun> device_runs_;
  Array<Executor, MotionEnergy> sums_;
  bool drives_ = false;
  std::vector<std::int64_t> turns_;  // steps after which pins and attachments turn or let go
  std::vector<Vec3> start_;          // empty: that of the scene
  std::vector<HeldEnergy> held_;     // at the start; empty: not asked for yet
};

}  // namespace malha
