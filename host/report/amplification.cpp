// SPDX-License-Identifier: Apache-2.0
#include "host/report/amplification.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "host/solver/solver.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

constexpr int kRoundsOfPower = 3;
constexpr int kFewestSteps = 12, kMostSteps = 180;
constexpr int kMostMeasured = 20'000;   // particles of a body, which is in memory twice while it is measured
constexpr double kSettled = 1e-3;       // of the displacement of the first step
constexpr double kPerturbation = 1e4;   // in small motions
constexpr double kSmallMotion = 1e-6;   // of the spacing of particles, per step
constexpr double kCertainGrowth = 0.5;  // 1/s
constexpr double kMostDamping = 0.5;    // the largest damping of a step that is worth advising
constexpr double kStepsOfAStep =
    4;  // of the scene: double precision costs twice as much, and settling takes as many steps
// The time of set-up in steps of the scene, measured: 1 to 15 steps, and 4 to 90 with filters.
constexpr double kStepsOfSetUp = 16, kStepsOfSetUpWithFilter = 100;
constexpr double kProjectionsOfPlan = 5e8;
constexpr double kProjectionsOfASpring =
    10;  // by Desbrun's method, with the spring's share of the product with the filter

using Motion = Eigen::VectorXd;

/// Returns a scene of this body alone, in which only its constraints and pins act.
Scene isolated_body(const Scene& of, std::size_t body) {
  Scene scene = of;
  scene.gravity = {0, 0, 0}, scene.seams.clear(), scene.environment.clear(), scene.expect = {}, scene.outputs = {};
  scene.wind.reset(), scene.sleep.reset(), scene.self_collision.reset();
  scene.solver.precision = Precision::Double;
  DesbrunSpec& desbrun = scene.solver.desbrun;
  desbrun.filter = FilterKind::Sparse, desbrun.storage.reset();  // the same accelerations with a cheaper set-up
  desbrun.time_budget.reset();                                   // the measurement must not depend on the clock
  scene.bodies = {of.bodies[body]};
  BodySpec& spec = scene.bodies[0];
  spec.velocity = spec.spin = {0, 0, 0}, spec.damping = 0, spec.tear.reset();
  for (Pin& pin : spec.pins) pin.motion.clear(), pin.release_time.reset();
  std::erase_if(spec.attachments, [](const Attachment& one) { return !one.environment.empty(); });
  for (Attachment& one : spec.attachments) one.motion.clear(), one.release_time.reset();
  return scene;
}

/// Returns points as a vector of three coordinates a particle.
Motion flat(const std::vector<Vec3>& points) {
  return Eigen::Map<const Motion>(points.data()->data(), 3 * static_cast<Eigen::Index>(points.size()));
}

/// The linearisation of a step about the rest state, by finite differences.
class StepAtRest {
 public:
  StepAtRest(const Scene& scene, int settling, int threads, const PatchBounds& bounds)
      : model_(build_model(scene, threads, bounds)), solver_(make_solver(model_, threads)) {
    rest_ = solver_->positions(), w_ = solver_->inverse_masses();
    const Eigen::Map<const Eigen::Matrix3Xd> points(rest_.data()->data(), 3, static_cast<Eigen::Index>(rest_.size()));
    const double extent = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).maxCoeff();
    small_ = kSmallMotion * extent / std::sqrt(model_.count());
    const std::vector<Vec3> still(rest_.size(), {0, 0, 0});
    const auto step_from_rest = [&] { take_step(rest_, still), x_ = flat(solver_->positions()); };
    const auto moved = [&] { return (x_ - flat(rest_)).lpNorm<Eigen::Infinity>(); };
    step_from_rest();
    if (const double first = moved(); first > small_) {
      // Steps from velocity zero bring the body to its rest state, for example one that pressure inflates. An
      // equilibrium that a small perturbation ends, as of a sheet that is compressed in its plane, does not count.
      for (double& a : rest_[rest_.size() / 2]) a += kPerturbation * small_;
      step_from_rest();
      for (int step = 0; step < settling && moved() > kSettled * first; ++step)
        rest_ = solver_->positions(), step_from_rest();
      rests_ = moved() <= kSettled * first;
    }
    v_ = flat(solver_->velocities());
  }
  bool rests() const { return rests_; }
  Eigen::Index coordinates() const { return x_.size(); }
  bool moves(Eigen::Index coordinate) const { return w_[coordinate / 3] > 0; }
  double least_inverse_mass() const {  // of the movable particles
    double least = 0;
    for (const double w : w_)
      if (w > 0) least = least > 0 ? std::min(least, w) : w;
    return least;
  }
  double small() const { return small_; }  // m

  /// Applies the linearised step to displacements from rest `x` (m) and velocities `v` (m/s).
  void apply(Motion& x, Motion& v) {
    std::vector<Vec3> from = rest_, at(rest_.size());
    for (Eigen::Index i = 0; i < x.size(); ++i)
      if (moves(i)) from[i / 3][i % 3] += x[i], at[i / 3][i % 3] = v[i];
    take_step(from, at);
    x = flat(solver_->positions()) - x_, v = flat(solver_->velocities()) - v_;
  }

 private:
  void take_step(const std::vector<Vec3>& x, const std::vector<Vec3>& v) {
    solver_->set_state(0, x, v), solver_->step();
  }

  Model model_;  // referenced by the solver
  std::unique_ptr<Solver> solver_;
  std::vector<Vec3> rest_;
  std::vector<double> w_;  // 1/kg
  Motion x_, v_;           // after a step from rest
  double small_ = 0;
  bool rests_ = true;
};

/// Power iteration: follows how the velocities of a motion grow from step to step. Positions and velocities are scaled
/// by the same factor.
class PowerIteration {
 public:
  PowerIteration(StepAtRest& step, double dt) : step_(step), dt_(dt) {
    Motion v(step.coordinates());
    std::uint32_t random = 1;  // the same numbers on every machine (Numerical Recipes' linear congruence)
    for (Eigen::Index i = 0; i < v.size(); ++i)
      random = random * 1664525u + 1013904223u, v[i] = step.moves(i) ? random / 2147483648.0 - 1 : 0;
    start(v);
    rescale();
    const Motion before = v_;
    advance();
    start(v_ - before);  // the difference removes zero modes, which keep their velocities
  }

  /// Starts at the rest state with these velocities.
  void start(const Motion& v) { x_ = Motion::Zero(v.size()), v_ = v, log_ = 0; }

  /// Takes one step and returns the logarithm of the velocities' norm relative to the start; NaN if nothing moves.
  double advance() {
    rescale();
    const double before = v_.norm();
    step_.apply(x_, v_);
    return log_ += std::log(v_.norm() / before);
  }
  const Motion& velocities() const { return v_; }

 private:
  void rescale() {
    const double most = std::max(x_.lpNorm<Eigen::Infinity>(), dt_ * v_.lpNorm<Eigen::Infinity>());
    if (most > 0) x_ *= step_.small() / most, v_ *= step_.small() / most;
  }

  StepAtRest& step_;
  double dt_, log_ = 0;
  Motion x_, v_;
};

struct Peak {
  int step = 0;
  double log = 0;
  double growth_from(const Peak& before) const { return (log - before.log) / (step - before.step); }  // a step
};

double rate_of(double share, double dt) { return share < 1 ? -std::log1p(-share) / dt : INFINITY; }

/// Returns the cost of a step of the scene in projections of one constraint.
double projections_of_a_step(const Model& model) {
  const SolverSpec& solver = model.scene.solver;
  double projections = 0, springs = 0;
  for (const ConstraintSet& set : model.sets) projections += set.count();
  for (const SpringSet& set : model.springs) springs += static_cast<double>(set.ends.size());
  return solver.substeps * (2 * solver.iterations * projections +
                            kProjectionsOfASpring * (1 + solver.desbrun.refinement_iterations) * springs);
}

double steps_of_set_up(const Model& model) {
  return model.scene.solver.type == "desbrun" ? kStepsOfSetUpWithFilter : kStepsOfSetUp;
}

}  // namespace

double Amplification::of_a_substep(const SolverSpec& solver) const {
  return std::exp(growth * solver.dt / solver.substeps);
}

bool Amplification::grows() const { return growth > damping + kCertainGrowth + 1 / seconds; }

std::optional<Amplification> measure_amplification(const Scene& of, std::size_t body, int steps, int threads,
                                                   const PatchBounds& bounds) try {
  const Scene scene = isolated_body(of, body);
  const double dt = scene.solver.dt;
  StepAtRest step(scene, steps, threads, bounds);
  if (!step.rests() || step.least_inverse_mass() == 0) return std::nullopt;
  Amplification found;
  found.damping = rate_of(of.bodies[body].damping, dt);
  if (of.wind) found.damping += of.wind->drag * step.least_inverse_mass();
  PowerIteration iteration(step, dt);
  for (int round = 0; round < kRoundsOfPower; ++round) {
    // The velocities of a mode oscillate. From rest they exceed their start only if the mode grows, and then their
    // peaks grow. The rate of a decaying mode follows from the peaks of the last two quarters.
    const int length = std::max(4, steps / kRoundsOfPower);
    Peak early, third{0, -INFINITY}, last{0, -INFINITY};
    Motion at_peak = iteration.velocities();
    for (int k = 1; k <= length; ++k) {
      const double log = iteration.advance();
      if (!std::isfinite(log)) return found;  // all motion has ended
      Peak& peak = 2 * k <= length ? early : 4 * k <= 3 * length ? third : last;
      if (log <= peak.log) continue;
      peak = {k, log};
      if (&peak == &last) at_peak = iteration.velocities();
    }
    const Peak& late = third.log > last.log ? third : last;
    found.growth = late.log > early.log ? late.growth_from(early) / dt : std::min(0.0, last.growth_from(third) / dt);
    found.seconds += dt * length;
    iteration.start(at_peak);
  }
  return found;
} catch (const InputError&) {  // such as tethers to pins that only the environment holds
  return std::nullopt;
} catch (const Diverged&) {
  return std::nullopt;
}

std::vector<std::optional<Amplification>> measure_amplifications(const Model& model, double steps, int threads) {
  const std::vector<int>& begin = model.render_mesh.body_begin;
  std::vector<std::optional<Amplification>> all(model.scene.bodies.size());
  // Each body costs its share of a step's time, so the number of bodies does not matter.
  const double affordable = (steps - steps_of_set_up(model)) / kStepsOfAStep;
  if (affordable < kFewestSteps) return all;
  const int taken = static_cast<int>(std::min<double>(kMostSteps, affordable));
  for (std::size_t body = 0; body < all.size(); ++body)
    if (begin[body + 1] - begin[body] <= kMostMeasured)
      all[body] = measure_amplification(model.scene, body, taken, threads, model.patches.bounds);
  return all;
}

double amplification_steps_of_plan(const Model& model) {
  return std::min(steps_of_set_up(model) + kMostSteps * kStepsOfAStep,
                  kProjectionsOfPlan / std::max(1.0, projections_of_a_step(model)));
}

std::vector<std::string> growth_warnings(const Model& model, const std::vector<std::optional<Amplification>>& all) {
  std::vector<std::string> lines;
  for (std::size_t body = 0; body < all.size(); ++body) {
    if (!all[body] || !all[body]->grows()) continue;
    const double growth = all[body]->growth, damping = -std::expm1(-growth * model.scene.solver.dt);
    lines.push_back("body '" + model.scene.bodies[body].name +
                    "': its constraints alone make small motions about its rest state grow by " + shown(growth, 2) +
                    " a second, and the scene damps " + shown(all[body]->damping, 2) + " a second; take " +
                    (damping < kMostDamping ? "a \"damping\" of " + shown(damping, 2) + " or more, or " : "") +
                    (model.scene.solver.type == "desbrun" ? "\"corrector\": \"inertia\""
                                                          : "\"rigidity\" or \"compliance\" instead of \"stiffness\"") +
                    " (scenes/accuracy.md, Growth at rest)");
  }
  return lines;
}

}  // namespace malha
