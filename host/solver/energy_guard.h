// SPDX-License-Identifier: Apache-2.0
// Energy guard: stops a run whose kinetic energy exceeds what forces, pins and stored energy can explain. The kinetic
// energy of a body that falls, is thrown, blown or dragged is at most the work on it plus the energy that its
// constraints stored; many times as much is an explosion, finite or not.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
#include "host/model/ordering/particle_runs.h"
#include "kernels/measure/motion_energy.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// The energy group of each particle (the solver's order). A body is a group of its own; all bodies of self-collision
/// form one group, as they can exchange energy.
std::vector<int> groups_of(const Model& model);

/// Energy that a group of bodies may have: mass, kg; kinetic and potential energy at the start, J; and energy that it
/// may have at any time, J.
struct Allowance {
  double mass = 0, motion = 0, height = 0, always = 0;
};
std::vector<Allowance> allowances(const Model& model, const std::vector<int>& group_of);

/// Energies stored in the constraints, by set and group, J: C^2 / (2 (alpha + h^2 sum w |grad C|^2)), which is the
/// energy of a compliance alpha, and for a stiff constraint what projecting it in one substep releases.
class StoredEnergies {
 public:
  /// Allocates what compute() needs, for this many groups.
  void allocate(const Model& model, int groups);
  /// Computes them at `x` (the solver's order) in substeps of h seconds.
  void compute(const Model& model, const std::vector<Vec3>& x, double h, const std::vector<int>& group_of, int groups);
  /// Returns the sum over all sets, J.
  double of_group(int group) const;

  struct OfSet {
    std::string_view kind;       // of the model
    std::vector<double> energy;  // of each group, J
  };
  /// Sets, stencils, springs, pressures and attachments, in this order.
  const std::vector<OfSet>& sets() const { return sets_; }

 private:
  std::vector<OfSet> sets_;
  std::vector<Vector3<double>> gradient_;  // of a pressure, by particle
};

/// Largest speed of anything on keyframes, or of the wind, at any time, m/s. A jump counts as a motion in h seconds.
double fastest_driven(const Model& model, double h);
/// Largest speed of environment objects alone, m/s.
double fastest_object(const Model& model, double h);

/// The last steps before pins and attachments are released, and the steps before keyframes of their paths, these at
/// least `apart` steps from each other; sorted.
std::vector<std::int64_t> motion_change_steps(const Model& model, std::int64_t apart);

/// Message about an explosion: how much energy there is, which particle is fastest, and which kind gained most.
struct Explosion {
  int group;
  const std::vector<int>& of;  // the group of each particle
  double kinetic, explained;   // J
};
std::string explosion(const Model& model, const Explosion& seen, const std::vector<Vec3>& x, const std::vector<Vec3>& v,
                      const StoredEnergies& before, const StoredEnergies& now);

/// A body may move by 1 % of its size in a step, or in this time if that is longer, s. (Steps may be short for frequent
/// output, which says nothing about the speed of bodies.)
inline constexpr double kBrief = 1.0 / 60;

/// The guard only reads, every 32nd step (128th where a step is one projection), which costs less than 1 %, and on
/// demand. It checks each group of bodies separately, because a light one can explode beside a heavy one. The kinetic
/// energy of a group is explained by the sum of:
/// - its kinetic energy at the start, or where a state was restored,
/// - its largest potential energy so far less the present one (lifting counts as explained),
/// - twice the kinetic energy of the group at the largest speed of air, and of pins, attachments and objects on
///   keyframes,
/// - that of the fall in a step, and of every body moving by 1 % of its size (see kBrief), for rounding and contacts,
/// - the energy stored in constraints at the start and, if anything drives the bodies, later. As this is expensive, it
///   is only computed where the rest does not explain a motion, and for driven bodies after 32, 64, 128 ... steps, at
///   keyframes (at most every 32nd step), and before releases, where a drawn band stores most.
/// All terms are upper bounds: a late alarm is better than a false one.
/// kFactor: stable settings are below 1, the study of stability finds settings that are bounded but wrong up to 10, and
/// an explosion exceeds any factor soon. 100 is ten times the speed that can be explained.
template <class Executor, class R>
class EnergyGuard {
 public:
  static constexpr double kFactor = 100;

  EnergyGuard(const Executor& executor, const Model& model)
      : executor_(executor), model_(model), h_(model.scene.solver.dt / model.scene.solver.substeps) {
    const SolverSpec& solver = model.scene.solver;
    while (every_ * solver.substeps * solver.iterations < 128) every_ *= 2;
    drives_ = fastest_driven(model, h_) > 0;
    if (drives_) motion_changes_ = motion_change_steps(model, every_);
    const std::vector<int> of = groups_of(model);
    for (const Allowance& one : allowances(model, of)) groups_.push_back({one, one.height});
    runs_ = particle_runs(of);
    device_runs_ = Array<Executor, ParticleRun>(runs_);
    sums_ = Array<Executor, MotionEnergy>(runs_.size(), MotionEnergy{});
    now_.reserve(groups_.size());
    group_of_ = of;
    for (StoredEnergies* stored : {&stored_at_start_, &stored_now_}) stored->allocate(model, int(groups_.size()));
  }

  /// Restarts from a state other than that of the scene.
  void restart(const Particles<R>& particles, std::vector<Vec3> x) {
    const std::vector<MotionEnergy>& now = measure(particles);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      Group& group = groups_[g];
      group.may.motion = now[g].kinetic, group.highest = now[g].potential, group.explained = group.max_stored = 0;
    }
    start_ = std::move(x), knows_start_ = false;
  }
  /// Steps between two checks.
  std::int64_t every() const { return every_; }
  /// Accounts for a pin that was moved by this distance, m.
  void add_pin_move(double distance) { add_driven_speed(distance / h_); }
  /// Accounts for pins or wind that move at this speed from now on, m/s, or for gravity that adds it in a step.
  void add_driven_speed(double speed) {
    for (Group& group : groups_) group.may.always += group.may.mass * speed * speed;
    drives_ = true;
  }
  /// Exempts the groups of these particles: user constraints may do any work, as a motor does.
  void exempt(const std::vector<int>& particles) {
    for (const int i : particles) groups_[group_of_[i]].may.always = std::numeric_limits<double>::infinity();
  }
  /// Exempts those of all particles i for which acts(i).
  template <class Acts>
  void exempt_where(const Acts& acts) {
    if (std::ranges::all_of(groups_, [](const Group& one) { return std::isinf(one.may.always); })) return;
    for (std::size_t i = 0; i < group_of_.size(); ++i)
      if (acts(i)) groups_[group_of_[i]].may.always = std::numeric_limits<double>::infinity();
  }

  /// Accounts for work of a handle on the group of a particle, J.
  void add_work(int particle, double joules) {
    const auto after = std::find_if(runs_.begin(), runs_.end(),
                                    [particle](const ParticleRun& run) { return particle < run.first + run.count; });
    groups_[after->group].may.always += joules;
    drives_ = true;
  }

  /// Checks the state after step `steps`, if a check is due or `now`. Returns a message about an explosion, if any.
  template <class Positions, class Velocities>
  std::optional<std::string> check(const Particles<R>& particles, std::int64_t steps, const Positions& positions,
                                   const Velocities& velocities, bool now = false) {
    if (drives_ && ((steps >= every_ && (steps & (steps - 1)) == 0) ||
                    std::binary_search(motion_changes_.begin(), motion_changes_.end(), steps))) {
      compute(stored_now_, positions());
      for (std::size_t g = 0; g < groups_.size(); ++g)
        groups_[g].max_stored = std::max(groups_[g].max_stored, stored_now_.of_group(int(g)));
    }
    if (steps % every_ != 0 && !now) return std::nullopt;
    const std::vector<MotionEnergy>& energy = measure(particles);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      Group& group = groups_[g];
      group.highest = std::max(group.highest, energy[g].potential);
      group.explained =
          std::max(group.explained, group.may.always + group.may.motion + group.highest - energy[g].potential);
      if (!(energy[g].kinetic > kFactor * (group.explained + group.max_stored))) continue;
      if (!knows_start_) compute(stored_at_start_, start_.empty() ? model_.x : start_), knows_start_ = true;
      group.max_stored = std::max(group.max_stored, stored_at_start_.of_group(int(g)));
      if (!(energy[g].kinetic > kFactor * (group.explained + group.max_stored))) continue;
      const std::vector<Vec3>& x = positions();
      compute(stored_now_, x);
      return explosion(model_, {int(g), group_of_, energy[g].kinetic, group.explained + group.max_stored}, x,
                       velocities(), stored_at_start_, stored_now_);
    }
    return std::nullopt;
  }

 private:
  struct Group {
    Allowance may;
    double highest;  // largest potential energy so far, J
    double explained = 0, max_stored = 0;
  };

  const std::vector<MotionEnergy>& measure(const Particles<R>& particles) {
    const Vec3& g = model_.scene.gravity;
    parallel_for(executor_, int(runs_.size()),
                 MeasureRuns<R>{{particles, {g[0], g[1], g[2]}}, device_runs_.data(), sums_.data()}, 8);
    const std::span<const MotionEnergy> sums = sums_.on_host(staging_);
    now_.assign(groups_.size(), MotionEnergy{});
    for (std::size_t r = 0; r < runs_.size(); ++r) now_[runs_[r].group] += sums[r];
    return now_;
  }
  void compute(StoredEnergies& stored, const std::vector<Vec3>& x) {
    stored.compute(model_, x, h_, group_of_, int(groups_.size()));
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
  std::vector<std::int64_t> motion_changes_;  // steps before keyframes and releases
  std::vector<Vec3> start_;                   // empty: the positions of the scene
  StoredEnergies stored_at_start_;
  bool knows_start_ = false;  // whether these are computed
  StoredEnergies stored_now_;
  std::vector<int> group_of_;          // of each particle
  std::vector<MotionEnergy> now_;      // of each group
  std::vector<MotionEnergy> staging_;  // sums_ of a device
};

}  // namespace malha
