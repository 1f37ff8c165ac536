// Energy that nothing gave ends a run. A body that falls, is thrown, blown or dragged has no more energy of motion than
// that gave it, and constraints give back what they held; what has many times as much is an explosion, finite or not.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/model/model.h"
#include "kernels/compute.h"
#include "kernels/motion_energy.h"

namespace malha {

/// J in the constraints of each kind at `x` (the solver's order), in substeps of h seconds: C^2 / (2 (alpha + h^2 sum w
/// |grad C|^2)), which is the energy of a compliance alpha, and of a stiff one what meeting it in a substep gives.
/// In the order of sets, springs, pressures, attachments.
struct HeldEnergy {
  std::string kind;
  double energy;
};
std::vector<HeldEnergy> held_energies(const Model& model, const std::vector<Vec3>& x, double h);
double sum_of(const std::vector<HeldEnergy>& held);

/// The fastest that anything which moves by keyframes, or the air, ever moves (m/s). A jump counts as made in h
/// seconds.
double fastest_driven(const Model& model, double h);

/// What the guard says of an explosion: how much energy, where it is fastest, and which kind gained most.
std::string explosion(const Model& model, const std::vector<Vec3>& x, const std::vector<Vec3>& v, double kinetic,
                      double given, const std::vector<HeldEnergy>& before, const std::vector<HeldEnergy>& now);

/// Reads only, every 32nd step (128th where a step is one projection): less than 1 % of them. Given is:
/// - the energy of motion at the start, or where a state was restored,
/// - height: the most potential energy that was seen less that of now (whoever lifts gives it),
/// - twice the energy of all going with the fastest of what drives: air, pins, attachments and objects on keyframes,
/// - that of a substep's fall, and of every body going 1 % of its size a step, which is rounding's and contacts' own,
/// - what constraints hold at the start; and, if something drives them, hold later. This is dear, and is only added up
///   where the others do not explain a motion, or, for what is driven, after 32, 64, 128 ... steps.
/// All of it errs on the side of what is given: a late alarm is better than a false one.
/// kFactor: stable settings are below 1, the study of stability finds settings that are bounded but wrong up to 10, and
/// an explosion passes any factor soon. 100 is ten times the speed that can be explained.
template <class Executor, class R>
class EnergyGuard {
 public:
  static constexpr double kFactor = 100;

  EnergyGuard(const Executor& executor, const Model& model) : executor_(executor), model_(model) {
    const SolverSpec& solver = model.scene.solver;
    const Vec3& g = model.scene.gravity;
    h_ = solver.dt / solver.substeps;
    while (every_ * solver.substeps * solver.iterations < 128) every_ *= 2;
    struct Body {
      Vec3 low, high;
      double mass = 0;
    };
    std::vector<Body> bodies(model.look.body_begin.size() - 1);
    for (std::size_t b = 0; b < bodies.size(); ++b)
      bodies[b].low = bodies[b].high = model.look.points.at(model.look.body_begin[b]);
    for (std::size_t i = 0; i < model.x.size(); ++i) {
      const Vec3 &x = model.x[i], &v = model.v[i];
      const double m = model.w[i] > 0 ? 1 / model.w[i] : 0;
      const auto next = std::upper_bound(model.look.body_begin.begin(), model.look.body_begin.end(), model.user_of[i]);
      Body& body = bodies[next - model.look.body_begin.begin() - 1];
      body.mass += m;
      for (int k = 0; k < 3; ++k) {
        motion_ += m / 2 * v[k] * v[k], highest_ -= m * g[k] * x[k];
        body.low[k] = std::min(body.low[k], x[k]), body.high[k] = std::max(body.high[k], x[k]);
      }
    }
    double sizes = 0, g2 = 0;  // mass times size^2
    for (int k = 0; k < 3; ++k) {
      g2 += g[k] * g[k];
      for (const Body& body : bodies) sizes += body.mass * (body.high[k] - body.low[k]) * (body.high[k] - body.low[k]);
    }
    for (const Body& body : bodies) mass_ += body.mass;
    const double driven = fastest_driven(model, h_), dt = solver.dt;
    drives_ = driven > 0;
    floor_ = mass_ / 2 * g2 * dt * dt + 1e-4 * sizes / (2 * dt * dt) + mass_ * driven * driven;
  }

  /// Starts anew from a state that is not that of the scene.
  void restart(const Particles<R>& particles, std::vector<Vec3> x) {
    const MotionEnergy now = measure(particles);
    motion_ = now.kinetic, highest_ = now.potential, given_ = held_most_ = 0;
    start_ = std::move(x), held_.clear();
  }
  /// Steps between two looks.
  std::int64_t every() const { return every_; }
  /// A pin was moved by hand, by so many m.
  void moved(double way) { floor_ += mass_ * (way / h_) * (way / h_), drives_ = true; }

  /// After step `steps`: what is wrong, if anything is.
  template <class Positions, class Velocities>
  std::optional<std::string> watch(const Particles<R>& particles, std::int64_t steps, const Positions& positions,
                                   const Velocities& velocities) {
    if (steps % every_ != 0) return std::nullopt;
    const MotionEnergy now = measure(particles);
    highest_ = std::max(highest_, now.potential);
    given_ = std::max(given_, floor_ + motion_ + highest_ - now.potential);
    if (now.kinetic > kFactor * (given_ + held_most_)) {
      if (held_.empty()) held_ = held_energies(model_, start_.empty() ? model_.x : start_, h_);
      held_most_ = std::max(held_most_, sum_of(held_));
      if (now.kinetic > kFactor * (given_ + held_most_)) {
        const std::vector<Vec3> x = positions();
        return explosion(model_, x, velocities(), now.kinetic, given_ + held_most_, held_,
                         held_energies(model_, x, h_));
      }
    }
    if (drives_ && (steps & (steps - 1)) == 0)
      held_most_ = std::max(held_most_, sum_of(held_energies(model_, positions(), h_)));
    return std::nullopt;
  }

 private:
  MotionEnergy measure(const Particles<R>& particles) const {
    const Vec3& g = model_.scene.gravity;
    return parallel_reduce<MotionEnergy>(executor_, particles.count,
                                         MeasureMotionEnergy<R>{particles, {g[0], g[1], g[2]}});
  }

  Executor executor_;
  const Model& model_;
  std::int64_t every_ = 32;
  double h_, mass_ = 0;  // s, kg
  double floor_ = 0;     // J that may be there at any time
  double motion_ = 0;    // J of motion at the start
  double highest_ = 0;   // J of height, the most seen
  double given_ = 0, held_most_ = 0;
  bool drives_ = false;
  std::vector<Vec3> start_;       // empty: that of the scene
  std::vector<HeldEnergy> held_;  // at the start; empty: not asked for yet
};

}  // namespace malha
