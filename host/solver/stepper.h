// SPDX-License-Identifier: Apache-2.0
// Time stepper, the base of all methods, for any executor and precision: it executes the list of stages that
// host/solver/step_plan.h makes, and holds the state of the particles and what the user does between steps. A pass that
// a scene does not use is not made.
#pragma once
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host/attachments/attachments.h"
#include "host/attachments/long_range.h"
#include "host/attachments/moved_pins.h"
#include "host/attachments/particle_handles.h"
#include "host/attachments/sewn_places.h"
#include "host/base/launch_graph.h"
#include "host/base/point_array.h"
#include "host/base/scoped_value.h"
#include "host/base/stopwatch.h"
#include "host/environment/colliders.h"
#include "host/environment/edge_collider.h"
#include "host/environment/edge_crossings.h"
#include "host/forces/air.h"
#include "host/forces/body_momenta.h"
#include "host/forces/pressure.h"
#include "host/forces/sleeper.h"
#include "host/measure/finite_check.h"
#include "host/measure/measure.h"
#include "host/measure/over_elongation.h"
#include "host/mesh/vectors.h"
#include "host/model/pins.h"
#include "host/model/seams.h"
#include "host/patch/sweep.h"
#include "host/projection/user_constraints.h"
#include "host/self_collision/final_guard.h"
#include "host/self_collision/self_collider.h"
#include "host/solver/energy_guard.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "host/solver/step_plan.h"
#include "kernels/forces/integrate.h"
#include "malha/error.h"

namespace malha {

/// Memory of an optional part of the solver.
template <class Part>
std::size_t bytes_of(const std::optional<Part>& part) {
  return part ? part->bytes() : 0;
}

template <class Executor, class R>
class TimeStepper : public Solver {
 public:
  void step(const SubstepCallback& after) final {
    if (after && !handles_)
      throw InputError("step: found a simulation without interactive; allowed: one that is made with it");
    const ScopedValue<const SubstepCallback*> callback(substep_callback_, after ? &after : nullptr);
    const double start = time(), end = start + model_.scene.solver.dt;
    if (sleeper_ && sleeper_->sleeps_through(particles(), start, end)) {
      ++steps_;
      return;
    }
    plan();
    advance();
    if (collider_) note_speed_of_vertices();
    check_energy();
    if (self_ || collider_) note_collision();
    if (sleeper_ && !interaction().acts() && !(time() < seams_closed_))
      timed(Pass::Sleep, [&] { sleeper_->watch(particles(), start, end, steps_); });
  }

  void check_divergence() final { check_energy(true); }

  double time() const final { return steps_ * model_.scene.solver.dt; }
  std::int64_t steps() const final { return steps_; }
  std::vector<Vec3> positions() const final { return in_user_order(positions_in_order(), model_.user_index); }
  std::vector<Vec3> velocities() const final { return in_user_order(v_.download(), model_.user_index); }
  void copy_positions(float* to, std::size_t stride) const final { scatter_positions(to, stride); }
  void copy_positions(double* to, std::size_t stride) const final { scatter_positions(to, stride); }
  void copy_velocities(float* to, std::size_t stride) const final { v_.scatter_to(to, stride, model_.user_index); }
  void copy_velocities(double* to, std::size_t stride) const final { v_.scatter_to(to, stride, model_.user_index); }
  const SolverStats& facts() const final { return facts_; }
  const StepPlan& step_plan() const final { return plan_; }
  bool has_levels() const final { return features_.levels; }
  const std::array<double, kPassNames.size()>& pass_seconds() const final { return seconds_; }
  std::string save() const final {
    return collider_ ? save_state(state_to_save(), *collider_) : save_state(state_to_save());
  }
  void restore(const std::string& bytes, const std::string& file) final { set(load(bytes, x_.size(), file)); }
  State<double> whole_state() const final {
    State<R> all = state_to_save();
    if (collider_) collider_->for_each_part([&](const auto& part) { all.proximity.add(part); });
    return converted<double>(all);
  }
  void continue_from(const State<double>& before, const LayoutMap& map,
                     const std::array<double, kPassNames.size()>& seconds) final {
    State<double> start = converted<double>(state_to_save());
    if (self_) start.self.search[0].crosses = model_.scene.self_collision->ignores_crossings ? 1 : 0;
    State<R> now = converted<R>(remapped(before, map, std::move(start)));
    const bool self_starts = self_ && (before.self.x0.empty() || before.low.empty() == kCompensated<R>);
    check(now, "state");
    set(now), seconds_ = seconds;
    const std::vector<R> w = w_.download();
    const std::vector<bool> driven = has_keyframes(model_);
    for (std::size_t i = 0; i < now.v.size(); ++i)  // pins stay where they are, see Simulation::set_positions()
      if (!(w[i] > R(0)) && !driven[static_cast<std::size_t>(model_.user_index[i])]) v_.set(i, {0, 0, 0});
    if (self_starts) self_->start_from(particles());
    if (collider_) collider_->find_new_overlaps(particles(), map, time());
    if (map.releases) keep_overlaps();
  }
  void set_state(std::int64_t steps, const std::vector<Vec3>& x, const std::vector<Vec3>& v) final {
    restore(save_state(moved_to(state_to_save(), steps, in_solver_order(x, model_.user_index),
                                in_solver_order(v, model_.user_index))),
            "state");
    if (self_) self_->start_from(particles());
  }
  bool overstretched() final {
    bool found = false;
    if (tear_limits_) timed(Pass::Tearing, [&] { found = tear_limits_->excess(x_.points()) > 0; });
    return found;
  }
  void move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to) final {
    const std::vector<R> w = w_.download();
    const std::vector<int> list = pins_of(model_, particles, [&](int i) {
      return !(w[i] > R(0)) && !(kinematic_pins_ && kinematic_pins_->refuses(i)) && !(handles_ && handles_->has(i));
    });
    double farthest = 0;
    for (std::size_t k = 0; k < particles.size(); ++k) {
      const auto i = static_cast<std::size_t>(list[k]);
      farthest = std::max(farthest, norm(minus(to[k], position_of(i))));
      set_position(i, to[k]);
    }
    energy_guard_.add_pin_move(farthest);
    crossings_step_ = -1;
    wake();
  }
  std::vector<double> inverse_masses() const final {
    return in_user_order(inverse_masses_in_order(), model_.user_index);
  }
  void change_gravity() final {
    gravity_ = norm(model_.scene.gravity);
    on_gravity_changed();
    energy_guard_.restart(particles(), positions_in_order());  // potential energies have changed
    energy_guard_.add_driven_speed(gravity_ * model_.scene.solver.dt);
    wake();
  }
  void change_wind() final {
    if (air_) air_->change(*model_.scene.wind);
    energy_guard_.add_driven_speed(norm(model_.scene.wind->velocity));
    wake();
  }
  void set_forces(const std::vector<Vec3>& forces) final {
    const bool had_any = features_.forces;
    features_.forces = !forces.empty();
    if (features_.forces) {
      if (forces_.size() == 0) forces_ = PointArray<Executor, R>(model_.x.size());
      forces_.gather(forces, model_.user_index);
      energy_guard_.exempt_where([&](std::size_t i) {
        const Vec3& force = forces[static_cast<std::size_t>(model_.user_index[i])];
        return force[0] != 0 || force[1] != 0 || force[2] != 0;
      });
    }
    if (features_.forces != had_any && !substep_callback_) plan_ = plan_step(features_, interaction_);
    double most = 0;  // squared
    for (std::size_t i = 0; features_.forces && collider_ && i < model_.w.size(); ++i) {
      const Vec3& force = forces[static_cast<std::size_t>(model_.user_index[i])];
      most = std::max(most, dot(force, force) * (model_.w[i] * model_.w[i]));
    }
    force_acceleration_ = std::sqrt(most);
    wake();
  }
  std::vector<Vec3> forces() const final {
    return features_.forces ? in_user_order(forces_.download(), model_.user_index) : std::vector<Vec3>{};
  }
  NextMotion next_motion() const final {
    if (!substep_callback_) return {time(), time_at(model_.scene.solver.substeps), false};
    return {time_at(substep_ + 1), time_at(substep_ + 2), true};
  }
  void change_environment() final {
    const double h = model_.scene.solver.dt / model_.scene.solver.substeps;
    max_object_speed_ = self_ ? std::max(fastest_object(model_, h), fastest_vertex_) : 0;
    note_driven_speed(fastest_object(model_, h));
    crossings_step_ = -1;
    if (sleeper_) sleeper_->change_environment(model_);
    const bool forces = features_.forces;
    features_ = step_features(model_, features_.levels), features_.forces = forces;
    if (!substep_callback_) plan_ = plan_step(features_, interaction_);  // one with a callback stays as it is
    wake();
  }
  void add_user_constraints(const std::vector<UserConstraint>& all) final {
    user_constraints_.emplace(executor_, model_, all);
    facts_.user_constraints = user_constraints_->facts();
    energy_guard_.exempt(user_constraints_->particles());
    exclude_from_momentum_correction(), plan();
  }
  std::vector<double> values_of_user_constraint(std::size_t index) const final {
    return user_constraints_ ? user_constraints_->values(index, x_.points(), w_.data())
                             : throw std::out_of_range("values_of_user_constraint");
  }
  void take(const ParticleHandle& what) final {
    if (!handles_)
      throw InputError("pull, hold: found a simulation without interactive; allowed: one that is made with it");
    const int i = handles_->number_of(what, model_, w_.data(), requires_fixed_pins());
    const Vec3 x = position_of(i), way = minus(what.to, x);
    what.is_held() ? energy_guard_.add_pin_move(norm(way)) : energy_guard_.add_work(i, handles_->work(i, what, x));
    if (what.is_held() && !handles_->has(i)) v_.set(i, {0, 0, 0});
    handles_->add(i, what, x, w_.data());
    pins_changed_ = true;
    exclude_from_momentum_correction(), wake();
  }
  void release(int particle) final {
    const auto found = std::find(model_.user_index.begin(), model_.user_index.end(), particle);
    if (!handles_ || found == model_.user_index.end()) return;
    handles_->release(static_cast<int>(found - model_.user_index.begin()), w_.data());
    pins_changed_ = true;
    exclude_from_momentum_correction(), keep_overlaps(), wake();
  }
  std::vector<ParticleHandle> taken() const final {
    return handles_ ? handles_->specs() : std::vector<ParticleHandle>{};
  }
  void wake() final {
    if (sleeper_) sleeper_->wake();
  }
  std::optional<SleepStats> sleep() const final {
    if (!sleeper_) return std::nullopt;
    if (!sleeper_->asleep()) return SleepStats{};
    return SleepStats{model_.count(), static_cast<double>(sleeper_->since()) * model_.scene.solver.dt};
  }
  std::uint64_t state_hash() const final { return hash_state(state(), model_.user_index); }

  Measures measure() const final {
    Measures m = measure_motion(executor_, particles(), model_.scene.gravity);
    const std::vector<Vec3> x = positions_in_order();
    measure_constraints(on_host(executor_), model_, x, m);
    measure_seams(model_, x, time(), m);
    measure_tetrahedra(on_host(executor_), model_, x, m);
    for (const auto& pressure : pressures_) {
      m.volume_ratios.push_back(pressure.volume_ratio(x_.points()));
      m.elastic += pressure.energy(x_.points());
    }
    if (attachments_) m.elastic += attachments_->energy(x_.points(), time());
    if (handles_) m.elastic += handles_->energy(x);
    if (user_constraints_) m.elastic += user_constraints_->energy(x_.points(), w_.data());
    if (collider_) {
      m.contacts = collider_->contacts();
      m.penetration_max = collider_->max_penetration(particles(), time());
      m.max_pinched = collider_->most_pinched();
    }
    if (self_) m.self_contacts = self_->contacts();
    if (edges_) {
      m.edge_contacts = edges_->contacts();
      m.max_pinched = std::max(m.max_pinched, edges_->most_left_out());
    }
    m.crossings = crossings_at(x);
    return m;
  }
  const StrainSample& strains() const final {
    sample_strains(on_host(executor_), model_, lengths_, present_positions(), sample_);
    if (long_range_) sample_.beyond = long_range_->beyond(x_.points(), w_.data());
    return sample_;
  }
  const std::vector<LengthRun>& lengths() const final { return lengths_; }
  int steps_to_sample() const final { return steps_to_sample_; }
  std::int64_t crossings() const final { return crossings_at(positions_in_order()); }

 protected:
  /// `threads`: number of threads of the executor. `sweeps`: the method projects batches, and needs a Sweep.
  TimeStepper(const Model& model, const Executor& executor, int threads, bool sweeps)
      : executor_(executor), model_(model), gravity_(norm(model.scene.gravity)), energy_guard_(executor, model) {
    facts_.layout_seconds = seconds([&] { allocate_particles(); });
    facts_.constraint_seconds = seconds([&] {
      if (sweeps) sweep_.emplace(executor, model, threads);
      for (const PressureSet& set : model.pressures) pressures_.emplace_back(executor, model, set);
    });
    if (sweep_) facts_.colour_seconds = sweep_->facts().plan_seconds;
    facts_.layout_seconds += facts_.constraint_seconds - facts_.colour_seconds;
    if (model.long_range.items() > 0) long_range_.emplace(executor, model.long_range);
    if (!model.free.empty()) momentum_corrector_.emplace(executor, model);
    if (!model.damped.empty()) damping_.emplace(executor, model.damped, model.scene.solver.substeps);
    if (!model.air.particle.empty()) air_.emplace(executor, model.air, *model.scene.wind);
    if (model.scene.sleep) sleeper_.emplace(executor, model);
    if (!model.moved.empty()) kinematic_pins_.emplace(executor, model), kinematic_pins_->set_pinned(0, w_.data());
    if (can_tear(model.scene)) tear_limits_.emplace(executor, tearable_edges(model));
    if (!model.attached.empty()) attachments_.emplace(executor, model);
    if (!model.scene.seams.empty()) sewn_places_.emplace(executor, model);
    if (!model.environment.empty()) facts_.collision_seconds = seconds([&] { collider_.emplace(executor, model); });
    if (names_edges(model.scene)) facts_.collision_seconds += seconds([&] { edges_.emplace(executor, model); });
    if (model.scene.self_collision)
      facts_.collision_seconds += seconds([&] { self_.emplace(executor, model, particles()); });
    if (self_ && collider_) kinematic_.emplace(executor, model.x.size());
    if (self_) max_object_speed_ = fastest_object(model, model.scene.solver.dt / model.scene.solver.substeps);
    if (model.interactive) handles_.emplace(executor, model);
    set_features(step_features(model, false));
    note_facts();
    steps_to_sample_ = sampling_interval();
    positions_.reserve(model.x.size()), sample_.rms.reserve(lengths_.size());
    if (steps_to_sample_ > 0) facts_.particle_bytes += model.x.size() * sizeof(Vec3);  // otherwise hardly ever used
  }

  /// One step of a scene that does not sleep.
  virtual void advance() { advance_from(0); }

  /// Plans the steps of a scene. A method calls it again when it knows more than the model tells.
  void set_features(const StepFeatures& features) {
    features_ = features;
    plan_ = plan_step(features_, interaction_);
  }
  /// Plans the next step anew if the user has taken or released particles, or added constraints or a callback.
  void plan() {
    const Interaction now = interaction();
    if (now == interaction_) return;
    interaction_ = now;
    set_features(features_);
  }

  /// The substeps of a step from `first` on.
  void advance_from(int first) {
    const SolverSpec& solver = model_.scene.solver;
    const double h = solver.dt / solver.substeps;
    repeat_step("substeps", [&] {
      if (first == 0) start_step();
      for (substep_ = first; substep_ < solver.substeps; ++substep_) {
        start_substep();
        for (const Stage stage : plan_.substep) run(stage, h);
      }
    });
    if (!plan_.finite_each_substep) require_finite();
    restore_momenta();
    ++steps_;
  }

  void restore_momenta() {
    const auto work = [&] { momentum_corrector_->restore_momenta(particles(), plan_.compares_substeps()); };
    if (momentum_corrector_) repeat_step("momenta", [&] { timed(Pass::MomentumCorrection, work); });
  }

  /// Runs a part of a step, which is recorded if the plan says so of steps. Executors that time passes do not record
  /// it.
  template <class Work>
  void repeat_step(const std::string& part, const Work& work) {
    if (is_timed(executor_) || plan_.recorded != Recorded::Steps) return work();
    const auto key = [&] {  // of the parameters of launches that may change between steps
      const Wind wind = model_.scene.wind.value_or(Wind{});
      return part + key_from(layouts_, features_.forces, closing_time(0), model_.scene.gravity, wind.velocity,
                             wind.drag, wind.density, wind.drag_coefficient, wind.lift_coefficient);
    };
    repeated(executor_, recorded_, key, work);
  }

  /// Runs patch solves in one parallel region, which a device records if it does not record whole steps. The launches
  /// depend on `solve` and further_key().
  template <class Key, class Work>
  void repeat_solves(const SolvePatch<R>& solve, const Key& further_key, const Work& work) {
    const auto key = [&] {
      const Particles<R>& all = solve.particles;
      const Vector3<R>& g = solve.gravity;
      return "patch solves" +
             key_from(all.x.x, all.v.x, all.p.d.x, all.w, solve.dt, g.x, g.y, g.z, solve.time, solve.force.x) +
             further_key();
    };
    sweep_->region(recorded_, key, work);
  }
  /// Solves all patches once, between other passes.
  void solve_patches(double h, bool first_iteration) {
    SolvePatch<R> solve = make_solve(h);
    solve.time = closing_time(substep_);
    if (first_iteration) solve.first = FirstIteration<R>{};
    repeat_solves(
        solve, [&] { return key_from(first_iteration); }, [&](const auto& team) { (*sweep_)(team, solve); });
  }

  /// Applies the wind to v: forces on faces if the air has a density, and drag on particles.
  void apply_wind(double h) {
    if (air_) timed(Pass::Air, [&] { air_->apply_wind(particles(), h); });
    if (const auto& wind = model_.scene.wind; wind && wind->drag > 0)
      timed(Pass::Prediction, [&] {
        parallel_for(executor_, model_.count(), Drag<R>{particles(), R(h), R(wind->drag), to_R(wind->velocity)});
      });
  }

  /// Called at the start of a step, and of each substep that runs as a list of stages.
  virtual void start_step() {}
  virtual void start_substep() {}
  /// Stage::Predict: computes v and p of a substep of h seconds from the forces on the particles.
  virtual void predict(double h) = 0;
  /// Stage::SolveSubstep.
  virtual void solve_substep(double /*h*/) {}
  /// Stage::FilterBending.
  virtual void filter_bending() {}
  /// Stage::CorrectCoarsely.
  virtual void apply_coarse_correction(const Particles<R>& /*all*/) {}
  /// Stage::StartPressures.
  virtual void start_pressures(const Particles<R>& all) {
    timed(Pass::Pressure, [&] {
      for (auto& pressure : pressures_) pressure.start_substep(all.p, all.w, false);
    });
  }
  /// One projection of all pressures.
  virtual void press(const Particles<R>& all) {
    for (auto& pressure : pressures_) pressure.project(all.p, all.w);
  }
  /// Throws Diverged if a substep of the current step has left a particle without a finite position.
  virtual void require_finite() {
    timed(Pass::State, [&] { refuse(finite_check_.in_step()); });
  }
  /// Called after every iteration. True if no other is needed or allowed: by a tolerance, or a time budget.
  virtual bool converged() { return false; }
  /// Called when gravity changes, for methods that cache it.
  virtual void on_gravity_changed() {}
  /// Name of the component that was built for a fixed set of pins (for error messages), or null.
  virtual const char* requires_fixed_pins() const { return nullptr; }

  /// Runs a stage of substep `substep_`, of h seconds.
  void run(Stage stage, double h) {
    const Particles<R> all = particles();
    const double start = time() + substep_ * h, end = start + h;
    const auto at = [this](int s) { return time_at(s); };
    switch (stage) {
      case Stage::MovePins:
        return timed(Pass::Pins, [&] { move_kinematic_pins(at(substep_), at(substep_ + 1)); });
      case Stage::ReleaseAttachments:
        return attachments_->release(at(substep_)) ? keep_overlaps() : void();
      case Stage::MoveHandles:
        return handles_->move(all, substep_);
      case Stage::Damp:
        return timed(Pass::Damping, [&] { damping_->damp(all); });
      case Stage::Wind:
        return apply_wind(h);
      case Stage::ApplyForces:
        if (!features_.forces) return;  // a callback might have set some
        return timed(Pass::Prediction, [&] {
          parallel_for(executor_, all.count, ApplyForces<R>{all, forces_.points(), R(h)});
          if (features_.filter && !features_.filtered_wind)  // they follow the prediction
            parallel_for(executor_, all.count, Predict<R>{all, R(h), {R(0), R(0), R(0)}});
        });
      case Stage::MeasureMomenta:
        return begins_comparison() ? measure_momenta() : void();
      case Stage::Predict:
        return predict(h);
      case Stage::PredictWind:
        return timed(Pass::Prediction, [&] {
          parallel_for(executor_, all.count, Predict<R>{all, R(h), {R(0), R(0), R(0)}});
        });
      case Stage::FilterBending:
        return filter_bending();
      case Stage::SolveSubstep:
        return solve_substep(h);
      case Stage::DetectContacts:
        return timed(Pass::Collision, [&] { collider_->detect_contacts(all, start, end); });
      case Stage::StartSelfCollision:
        return self_->start_substep();
      case Stage::DetectEdgeContacts:
        return timed(Pass::Edges, [&] { edges_->detect_contacts(all, start, end); });
      case Stage::CorrectCoarsely:
        return apply_coarse_correction(all);
      case Stage::StartPressures:
        return start_pressures(all);
      case Stage::Iterate:
        return iterate(h);
      case Stage::ClampTunnelling:
        return timed(Pass::Collision, [&] { collider_->clamp_tunnelling(all); });
      case Stage::TruncateMotion:
        truncate_motion(all);
        if (self_) timed(Pass::SelfCollision, [&] { self_->note_truncation(all, bool(collider_)); });
        return;
      case Stage::UpdateState:
        return timed(Pass::State, [&] {
          finite_check_.update(executor_, all, h, substep_);
          if (plan_.finite_each_substep) refuse(finite_check_.in(substep_));
        });
      case Stage::Restitute:
        return apply_restitution(all, h);
      case Stage::EndSelfCollision:
        return timed(Pass::SelfCollision, [&] { self_->end_substep(all, h, max_object_speed_); });
      case Stage::EndEdgeContacts:
        return timed(Pass::Edges, [&] { edges_->end_substep(all); });
      case Stage::CompareMomenta:
        return ends_comparison() ? compare_momenta(h * substeps_compared()) : void();
      case Stage::PlaceHandles:
        return handles_->arrive(all, substep_);
      case Stage::PlacePins:
        return timed(Pass::Pins, [&] { kinematic_pins_->arrive(all, at(substep_), at(substep_ + 1)); });
      case Stage::CallBack:
        return (*substep_callback_)(substep_ + 1, at(substep_ + 1));
    }
  }

  void iterate(double h) {
    const double start = time() + substep_ * h;
    for (int iteration = 0; iteration < model_.scene.solver.iterations; ++iteration) {
      for (const IterationStage stage : plan_.iteration) run(stage, particles(), start, h, iteration == 0);
      if (converged()) break;
    }
  }

  /// Runs a stage of an iteration, in a substep of h seconds from `start` on.
  void run(IterationStage stage, const Particles<R>& all, double start, double h, bool first_iteration) {
    switch (stage) {
      case IterationStage::MeasureMomenta:
        return timed(Pass::MomentumCorrection, [&] { momentum_corrector_->before_projection(all, h); });
      case IterationStage::SolvePatches:
        return timed(Pass::Projection, [&] { solve_patches(h, first_iteration); });
      case IterationStage::ProjectPressures:
        return timed(Pass::Pressure, [&] { press(all); });
      case IterationStage::CompareMomenta:
        return timed(Pass::MomentumCorrection, [&] { momentum_corrector_->after_projection(all, h); });
      case IterationStage::ProjectLongRange:
        return timed(Pass::LongRange, [&] { long_range_->project(all.p, all.w); });
      case IterationStage::ProjectAttachments:
        return timed(Pass::Attachments,
                     [&] { attachments_->project(all.p, all.w, start, start + h, first_iteration); });
      case IterationStage::ProjectUserConstraints:
        return timed(Pass::UserConstraints, [&] { user_constraints_->project(all.p, all.w, first_iteration); });
      case IterationStage::ProjectHandles:
        return timed(Pass::Attachments, [&] { handles_->project(all.p, all.w, first_iteration); });
      case IterationStage::SolveSelfContacts:
        return timed(Pass::SelfCollision, [&] { self_->solve_contacts(all); });
      case IterationStage::SolveEdgeContacts:
        return timed(Pass::Edges, [&] { edges_->solve_contacts(all); });
      case IterationStage::CloseSeams:
        if (closing_time(substep_) < R(seams_closed_)) return;  // some are still open
        return timed(Pass::Attachments, [&] { sewn_places_->close(all); });
      case IterationStage::SolveContacts:
        return timed(Pass::Contact, [&] { collider_->solve_contacts(all); });
    }
  }

  int substeps_compared() const { return plan_.substeps_compared(model_.scene.solver.substeps); }
  bool begins_comparison() const { return substep_ % substeps_compared() == 0; }
  bool ends_comparison() const { return (substep_ + 1) % substeps_compared() == 0; }
  void measure_momenta() {
    timed(Pass::MomentumCorrection, [&] { momentum_corrector_->before(particles()); });
  }
  /// Compares momenta with those t seconds ago, before gravity acted.
  void compare_momenta(double t) {
    const Vec3& g = model_.scene.gravity;
    timed(Pass::MomentumCorrection, [&] { momentum_corrector_->after(particles(), {g[0] * t, g[1] * t, g[2] * t}); });
  }

  void truncate_motion(const Particles<R>& all) {
    malha::apply_final_guards(self_, edges_, collider_, kinematic_, all,
                              [&](Pass pass, const auto& work) { timed(pass, work); });
  }
  /// Restitution moves particles again after the substep; that motion is guarded against intersections too.
  void apply_restitution(const Particles<R>& all, double h) {
    timed(Pass::Contact, [&] { collider_->restitute(all, 2 * h * gravity_, h); });
    if (!collider_->bounces()) return;
    if (self_ || edges_) collider_->end_motion(), truncate_motion(all);
    timed(Pass::State, [&] { parallel_for(executor_, all.count, AdvanceAll<R>{all.p}); });
  }

  /// Moves kinematic pins and releases those whose time is over. Overlaps that released pins caused are kept, so that
  /// contacts do not throw them apart.
  void move_kinematic_pins(double start, double end) {
    const int before = released_pin_sets();
    kinematic_pins_->move(particles(), w_.data(), start, end);
    if (released_pin_sets() == before) return;
    pins_changed_ = true, keep_overlaps();
  }
  void keep_overlaps() {
    if (self_) self_->keep_overlaps();
    if (edges_) edges_->keep_overlaps();
    if (collider_) collider_->keep_overlaps(particles());
  }
  int released_pin_sets() const { return kinematic_pins_ ? kinematic_pins_->released() : 0; }
  /// Present inverse masses, 1/kg, in the solver's order: 0 for pinned particles.
  std::vector<double> inverse_masses_in_order() const {
    const std::vector<R> w = w_.download();
    return {w.begin(), w.begin() + model_.count()};
  }

  Particles<R> particles() const {
    return {model_.count(), x_.points(),     v_.points(), {x_.points(), d_.points(), low_.points()},
            w_.data(),      friction_.data()};
  }
  /// Positions in the solver's order, x and low together.
  std::vector<Vec3> positions_in_order() const {
    std::vector<Vec3> all;
    copy_positions_in_order(all);
    return all;
  }
  template <class Number>
  void scatter_positions(Number* to, std::size_t stride) const {
    x_.scatter_to(to, stride, model_.user_index, kCompensated<R> ? &low_ : nullptr);
  }
  void copy_positions_in_order(std::vector<Vec3>& all) const {
    x_.download_to(all);
    if constexpr (kCompensated<R>) low_.add_to(all);
  }
  /// The same in memory of the solver, until the next call.
  const std::vector<Vec3>& present_positions() const {
    copy_positions_in_order(positions_);
    return positions_;
  }
  /// The time (s) at the end of a substep of this step, from 0 on, for seams; it stands still once all are closed.
  R closing_time(int substep) const {
    const SolverSpec& solver = model_.scene.solver;
    return R(std::min(seams_closed_, (steps_ + double(substep + 1) / solver.substeps) * solver.dt));
  }
  SolvePatch<R> make_solve(double h) const {
    SolvePatch<R> solve = sweep_->make_solve(particles(), h, to_R(model_.scene.gravity));
    if (plan_.solves_apply_forces) solve.force = forces_.points();
    return solve;
  }
  Vec3 position_of(std::size_t i) const {
    Vec3 position = x_.get(i);
    if constexpr (kCompensated<R>)
      for (int k = 0; k < 3; ++k) position[k] += low_.get(i)[k];
    return position;
  }
  void set_position(std::size_t i, const Vec3& position) {
    x_.set(i, position), d_.set(i, {0, 0, 0});
    if constexpr (kCompensated<R>) low_.set(i, minus(position, x_.get(i)));
  }
  /// -0 becomes 0, as in packs.
  static Vector3<R> to_R(const Vec3& a) { return {R(a[0] + 0), R(a[1] + 0), R(a[2] + 0)}; }

  bool has_handles() const { return handles_ && !handles_->empty(); }
  Interaction interaction() const {
    return {has_handles(), user_constraints_.has_value(), substep_callback_ != nullptr};
  }

  /// Throws Diverged if the energy has exploded, finite or not. `now`: checks at this step, whichever it is.
  void check_energy(bool now = false) {
    timed(plan_.fuses() ? Pass::FusedSolve : Pass::State, [&] {
      const auto wrong = energy_guard_.check(
          particles(), steps_, [&]() -> const std::vector<Vec3>& { return present_positions(); },
          [&] { return v_.download(); }, now);
      if (wrong)
        throw Diverged("step " + std::to_string(steps_) + " (t = " + std::to_string(time()) + " s): " + *wrong);
    });
  }

  void refuse(const std::optional<int>& non_finite) const {
    if (non_finite) refuse_non_finite(model_.user_index[*non_finite]);
  }
  /// `non_finite`: a particle whose position is not finite, by the user's number.
  [[noreturn]] void refuse_non_finite(int non_finite) const {
    throw Diverged("step " + std::to_string(steps_ + 1) + " (t = " + std::to_string(time()) +
                   " s): " + particle_name(model_, non_finite) + " has no finite position any more");
  }

  /// Accounts for the motion of deforming meshes, whose speed is not known beforehand.
  void note_speed_of_vertices() {
    const double speed = collider_->fastest_vertex();
    if (!(speed > fastest_vertex_)) return;
    fastest_vertex_ = speed, note_driven_speed(speed);
    max_object_speed_ = std::max(max_object_speed_, speed);
  }
  /// Accounts for objects that move at a speed (m/s) from now on, once for all that are as fast.
  void note_driven_speed(double speed) {
    if (!(speed > fastest_driven_)) return;
    fastest_driven_ = speed, energy_guard_.add_driven_speed(speed);
  }
  /// The time at the start of a substep of this step, counted from 0: the same at the ends of steps.
  double time_at(int substep) const {
    const SolverSpec& solver = model_.scene.solver;
    return (steps_ + double(substep) / solver.substeps) * solver.dt;
  }
  void note_collision() {
    facts_.collision_bytes = bytes_of(collider_) + bytes_of(self_) + bytes_of(edges_) + bytes_of(kinematic_);
    if (self_) facts_.self = self_->facts();
    if (edges_) facts_.edges = edges_->facts();
    if (collider_) facts_.contact = collider_->facts();
  }

  template <class F>
  void timed(Pass pass, F&& work) {
    if (!is_timed(executor_)) return void(work());
    seconds_[static_cast<int>(pass)] += seconds([&] { work(), synchronize(executor_); });
  }

  Executor executor_;
  const Model& model_;
  double gravity_, max_object_speed_ = 0;               // m/s^2; m/s, of moving environment objects
  double force_acceleration_ = 0;                       // m/s^2, the largest that forces of the program cause
  double seams_closed_ = time_of_closed_seams(model_);  // s, from which on all are; 0: none closes
  double fastest_vertex_ = 0;                           // m/s, of deforming meshes, so far
  double fastest_driven_ = 0;                           // m/s, of objects whose motion was not known at the start
  PointArray<Executor, R> x_, v_, d_, low_;             // see Particles
  std::optional<Sweep<Executor, R>> sweep_;
  std::vector<Pressure<Executor, R>> pressures_;
  std::optional<MomentumCorrector<Executor, R>> momentum_corrector_;
  std::optional<EnvironmentColliders<Executor, R>> collider_;
  std::optional<EdgeCollider<Executor, R>> edges_;
  std::int64_t steps_ = 0;
  int substep_ = 0;            // of the step
  bool pins_changed_ = false;  // particles were pinned or released, which a method notes
  int layouts_ = 0;            // of parts that a method has made anew
  StepFeatures features_;
  StepPlan plan_;  // of the present step
  SolverStats facts_;

 private:
  void exclude_from_momentum_correction() {
    std::vector<int> all = handles_ ? handles_->particles() : std::vector<int>{};
    if (user_constraints_) std::ranges::copy(user_constraints_->particles(), std::back_inserter(all));
    if (momentum_corrector_) momentum_corrector_->exclude(all);
  }

  /// Number of intersections in the present state, cached for several callers.
  std::int64_t crossings_at(const std::vector<Vec3>& x) const {
    if (crossings_step_ != steps_) {
      crossings_ =
          (self_ ? count_crossings(self_->surface(), x) : 0) + (edges_ ? count_edge_crossings(model_, x, time()) : 0);
      crossings_step_ = steps_;
    }
    return crossings_;
  }

  void allocate_particles() {
    x_ = PointArray<Executor, R>(model_.x), v_ = PointArray<Executor, R>(model_.v);
    d_ = PointArray<Executor, R>(model_.x.size());
    if constexpr (kCompensated<R>) {
      State<R> start;
      set_positions(model_.x, start);
      low_ = PointArray<Executor, R>(model_.x.size()), low_.upload(start.low);
    }
    std::vector<R> w(model_.w.begin(), model_.w.end());
    w.resize(w.size() + kSlotPack);  // so that a pack may start at the last particle
    w_ = Array<Executor, R>(w);
    std::vector<R> friction(model_.friction_factor.begin(), model_.friction_factor.end());
    if (!friction.empty()) friction.resize(w.size());
    friction_ = Array<Executor, R>(friction);
  }
  State<R> state() const {
    State<R> now{steps_, x_.template download<std::array<R, 3>>(), v_.template download<std::array<R, 3>>()};
    if constexpr (kCompensated<R>) now.low = low_.template download<std::array<R, 3>>();
    return now;
  }

  /// Continues from a state of this layout.
  void set(const State<R>& saved) {
    steps_ = saved.steps, crossings_step_ = -1;
    x_.upload(saved.x), v_.upload(saved.v), d_.upload(std::vector<Vec3>(saved.x.size(), Vec3{0, 0, 0}));
    if constexpr (kCompensated<R>) low_.upload(saved.low);
    if (handles_) handles_->release_all(w_.data());
    exclude_from_momentum_correction();
    if (kinematic_pins_) kinematic_pins_->set_pinned(time(), w_.data());
    pins_changed_ = true;
    if (sweep_) sweep_->clear_non_finite();
    if (collider_) {
      collider_->restore_state(saved.proximity), collider_->restore_overlaps(saved.overlaps);
      collider_->restore_shapes(saved.shapes.value_or(ShapeMemory{}), x_.size());
    }
    if (sleeper_) user_constraints_ ? sleeper_->wake() : sleeper_->restore_state(saved.rest);
    if (self_) self_->restore_state(saved.self);
    if (edges_) edges_->restore_state(saved.edges);
    energy_guard_.restart(particles(), positions_in_order());
  }

  /// The state with everything that the next step needs, except contacts.
  State<R> state_to_save() const {
    State<R> all = state();
    if (sleeper_) all.rest = sleeper_->save_state();
    if (self_) all.self = self_->save_state();
    if (edges_) all.edges = edges_->save_state();
    if (collider_) all.overlaps = collider_->overlaps(), all.shapes = collider_->save_shapes(x_.size());
    return all;
  }

  State<R> load(const std::string& bytes, std::size_t particles, const std::string& file) const {
    const StateSizes sizes{.particles = particles,
                           .meshes = mesh_count(model_),
                           .shapes = shape_count(model_),
                           .deforming = model_.environment.size() - mesh_count(model_) - shape_count(model_),
                           .rest = sleeper_ ? std::size_t(2) : 0,
                           .searched = self_ ? particles : 0,
                           .edge_groups = edges_ ? static_cast<std::size_t>(edges_->groups()) : 0};
    return load_state<R>(bytes, sizes, collider_ ? collider_->triangles() : std::vector<int>{}, file);
  }
  void check(const State<R>& of, const std::string& file) const {
    detail::check_state(of, collider_ ? collider_->triangles() : std::vector<int>{},
                        static_cast<std::int64_t>(mesh_count(model_)), file);
  }

  /// The steps after which strains may be sampled again for a hundredth of the time of those steps; 0: there is no
  /// length.
  int sampling_interval() const {
    const SolverSpec& solver = model_.scene.solver;
    double lengths = static_cast<double>(model_.long_range.anchor.size());
    double projections = static_cast<double>(pressures_.size()) + lengths;
    for (const LengthRun& run : lengths_) lengths += run.count;
    if (!(lengths > 0)) return 0;
    if (sweep_)
      for (const ConstraintSet& set : model_.sets) projections += kSweepsPerIteration * double(set.count());
    projections *= double(solver.substeps) * solver.iterations;
    // Costs in units of one projection: six for a sampled length, and twenty per substep for a particle with contact
    // tests. The launches alone cost some thousands.
    const double contacts = collider_ || self_ || edges_ ? 20.0 * solver.substeps * model_.count() : 0;
    const double step = projections + lengths + contacts + 4000;
    return std::clamp(static_cast<int>(std::ceil(6 * lengths / (0.01 * step))), 1, 128);
  }

  void note_facts() {
    facts_.particle_bytes = x_.bytes() + v_.bytes() + d_.bytes() + low_.bytes() + w_.bytes() +
                            bytes_of(kinematic_pins_) + bytes_of(momentum_corrector_) + bytes_of(damping_);
    facts_.constraint_bytes += bytes_of(tear_limits_) + bytes_of(attachments_) + bytes_of(sewn_places_);
    facts_.air_bytes = bytes_of(air_), facts_.long_range_bytes = bytes_of(long_range_);
    for_each_isa([&]<class Isa>(Isa) {
      if (executor_.instructions == Isa::value) facts_.instructions = Isa::name;
    });
    if (sweep_) facts_.patches = sweep_->facts(), facts_.sets = sweep_->set_facts();
    facts_.long_range = model_.long_range.items();
    facts_.attachments = static_cast<int>(model_.long_range.anchor.size());
    facts_.air_particles = static_cast<int>(model_.air.particle.size());
    std::int64_t projections = static_cast<std::int64_t>(pressures_.size()) + facts_.attachments;
    for (const SetStats& set : facts_.sets)
      facts_.constraint_bytes += set.bytes, projections += kSweepsPerIteration * std::int64_t{set.constraints};
    for (const auto& pressure : pressures_) facts_.constraint_bytes += pressure.bytes();
    facts_.pressure_launches = 4 * pressures_.size(), facts_.pressure_starts = 3 * pressures_.size();
    note_collision();
    if (collider_) facts_.deforming = collider_->deforming();
    facts_.projections_per_step = projections * model_.scene.solver.substeps * model_.scene.solver.iterations;
  }

  const SubstepCallback* substep_callback_ = nullptr;  // during a step; null: none
  Interaction interaction_;                            // for which plan_ is
  Array<Executor, R> w_;
  Array<Executor, R> friction_;     // see Particles; empty without a map of it
  PointArray<Executor, R> forces_;  // that a program has set, N; empty: none so far
  std::optional<Damping<Executor, R>> damping_;
  std::vector<LengthRun> lengths_ = length_runs(model_);
  FiniteCheck<Executor> finite_check_{model_.scene.solver.substeps};
  EnergyGuard<Executor, R> energy_guard_;
  Recording<Executor> recorded_;  // parts of steps, or patch solves
  int steps_to_sample_ = 0;
  std::optional<LongRange<Executor, R>> long_range_;
  std::optional<KinematicPins<Executor, R>> kinematic_pins_;
  std::optional<Attachments<Executor, R>> attachments_;
  std::optional<SewnPlaces<Executor, R>> sewn_places_;
  std::optional<ParticleHandles<Executor, R>> handles_;
  std::optional<UserConstraints<Executor, R>> user_constraints_;
  std::optional<LengthLimits<Executor, R>> tear_limits_;  // edges that tear
  std::optional<Air<Executor, R>> air_;
  std::optional<Sleeper<Executor, R>> sleeper_;
  std::optional<SelfCollider<Executor, R>> self_;
  std::optional<KinematicParticles<Executor, R>> kinematic_;  // with self_ and collider_
  std::array<double, kPassNames.size()> seconds_{};
  mutable std::int64_t crossings_step_ = -1, crossings_ = 0;  // the step of the last count, and its result
  mutable std::vector<Vec3> positions_;                       // of present_positions()
  mutable StrainSample sample_;
};

}  // namespace malha
