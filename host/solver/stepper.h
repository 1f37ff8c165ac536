// SPDX-License-Identifier: Apache-2.0
// What the methods share: a substep of damping, wind, prediction (each method's own), projected constraints, collision
// and the new state, for any executor and precision. A pass that the scene does not name does not exist here.
#pragma once
#include <algorithm>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host/attachments/attachments.h"
#include "host/attachments/long_range.h"
#include "host/attachments/moved_pins.h"
#include "host/attachments/particle_handles.h"
#include "host/base/point_array.h"
#include "host/base/scoped_value.h"
#include "host/base/stopwatch.h"
#include "host/environment/collider.h"
#include "host/environment/edge_collider.h"
#include "host/environment/edge_crossings.h"
#include "host/forces/air.h"
#include "host/forces/damping.h"
#include "host/forces/momentum_corrector.h"
#include "host/forces/pressure.h"
#include "host/forces/sleeper.h"
#include "host/measure/finite_check.h"
#include "host/measure/measure.h"
#include "host/measure/over_elongation.h"
#include "host/mesh/vectors.h"
#include "host/model/validate_outputs.h"
#include "host/patch/sweep.h"
#include "host/projection/user_constraints.h"
#include "host/self_collision/self_collider.h"
#include "host/self_collision/truncate.h"
#include "host/solver/energy_guard.h"
#include "host/solver/graph_capture.h"
#include "host/solver/overlap_host_queries.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "host/solver/step_features.h"
#include "kernels/forces/integrate.h"
#include "malha/error.h"

namespace malha {

/// The bytes of an optional part of the solver.
template <class Part>
std::size_t bytes_of(const std::optional<Part>& part) {
  return part ? part->bytes() : 0;
}

template <class Executor, class R>
class TimeStepper : public Solver {
 public:
  void step(const SubstepCallback& after) final {
    if (after && !hand_)
      throw InputError("step: found a simulation without interactive; allowed: one that is made with it");
    const ScopedValue<const SubstepCallback*> watch(watcher_, after ? &after : nullptr);
    const double start = time(), end = start + model_.scene.solver.dt;
    if (sleeper_ && sleeper_->sleeps_through(particles(), start, end)) {
      ++steps_;
      return;
    }
    advance();
    guard();
    if (self_ || collider_) note_collision();
    if (sleeper_ && !has_external_constraints())
      timed(Pass::Sleep, [&] { sleeper_->watch(particles(), start, end, steps_); });
  }

  void check_divergence() final { guard(true); }

  double time() const final { return steps_ * model_.scene.solver.dt; }
  std::int64_t steps() const final { return steps_; }
  std::vector<Vec3> positions() const final { return in_user_order(places(), model_.user_index); }
  std::vector<Vec3> velocities() const final { return in_user_order(v_.download(), model_.user_index); }
  const SolverStats& facts() const final { return facts_; }
  const std::array<double, kPassNames.size()>& pass_seconds() const final { return seconds_; }
  std::string save() const final { return collider_ ? save_state(remembered(), *collider_) : save_state(remembered()); }
  void restore(const std::string& bytes, const std::string& file) final {
    const State<R> saved = load(bytes, x_.size(), file);
    steps_ = saved.steps, crossings_step_ = -1;
    x_.upload(saved.x), v_.upload(saved.v), d_.upload(std::vector<Vec3>(saved.x.size(), Vec3{0, 0, 0}));
    if constexpr (kCarries<R>) low_.upload(saved.low);
    if (hand_) hand_->release_all(w_.data());
    exclude_from_momentum_correction();
    if (moved_) moved_->hold(time(), w_.data());
    if (sweep_) sweep_->forget_lost();
    if (collider_) collider_->restore_state(saved.seen);
    if (sleeper_) own_ ? sleeper_->wake() : sleeper_->restore_state(saved.rest);
    if (self_) self_->restore_state(saved.self);
    if (edges_) edges_->restore_state(saved.edges);
    guard_.restart(particles(), places());
  }
  void restore_after_split(const std::string& bytes, std::size_t particles, const std::vector<int>& from,
                           const std::array<double, kPassNames.size()>& seconds) final {
    restore(save_state(carried(load(bytes, particles, "state"), from)), "state");
    seconds_ = seconds;
  }
  void set_state(std::int64_t steps, const std::vector<Vec3>& x, const std::vector<Vec3>& v) final {
    restore(save_state(displaced(remembered(), steps, in_solver_order(x, model_.user_index),
                                 in_solver_order(v, model_.user_index))),
            "state");
    if (self_) self_->start_from(particles());
  }
  bool overstretched() final {
    bool found = false;
    if (breakable_) timed(Pass::Tearing, [&] { found = breakable_->excess(x_.points()) > 0; });
    return found;
  }
  void move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to) final {
    const std::vector<R> w = w_.download();
    const std::vector<int> list = pins_of(model_, particles, [&](int i) {
      return !(w[i] > R(0)) && !(moved_ && moved_->refuses(i)) && !(hand_ && hand_->has(i));
    });
    double farthest = 0;
    for (std::size_t k = 0; k < particles.size(); ++k) {
      const auto i = static_cast<std::size_t>(list[k]);
      farthest = std::max(farthest, norm(minus(to[k], place_of(i))));
      put(i, to[k]);
    }
    guard_.moved(farthest);
    crossings_step_ = -1;
    wake();
  }
  std::vector<double> inverse_masses() const final { return in_user_order(weights_in_order(), model_.user_index); }
  void change_gravity() final {
    gravity_ = norm(model_.scene.gravity);
    on_gravity_changed();
    guard_.restart(particles(), places());  // heights weigh otherwise now
    guard_.driven(gravity_ * model_.scene.solver.dt);
    wake();
  }
  void change_wind() final {
    if (air_) air_->change(*model_.scene.wind);
    guard_.driven(norm(model_.scene.wind->velocity));
    wake();
  }
  void add_user_constraints(const std::vector<UserConstraint>& all) final {
    own_.emplace(executor_, model_, all);
    facts_.own = own_->facts();
    guard_.trust(own_->particles());
    exclude_from_momentum_correction();
  }
  std::vector<double> values_of_user_constraint(std::size_t index) const final {
    return own_ ? own_->values(index, x_.points(), w_.data()) : throw std::out_of_range("values_of_user_constraint");
  }
  void take(const ParticleHandle& what) final {
    if (!hand_)
      throw InputError("pull, hold: found a simulation without interactive; allowed: one that is made with it");
    const int i = hand_->number_of(what, model_, w_.data(), requires_fixed_pins());
    const Vec3 x = place_of(i), way = minus(what.to, x);
    what.is_held() ? guard_.moved(norm(way)) : guard_.gave(i, hand_->work(i, what, x));
    if (what.is_held() && !hand_->has(i)) v_.set(i, {0, 0, 0});
    hand_->take(i, what, x, w_.data());
    exclude_from_momentum_correction(), wake();
  }
  void release(int particle) final {
    const auto found = std::find(model_.user_index.begin(), model_.user_index.end(), particle);
    if (!hand_ || found == model_.user_index.end()) return;
    hand_->release(static_cast<int>(found - model_.user_index.begin()), w_.data());
    exclude_from_momentum_correction(), keep_overlaps(), wake();
  }
  std::vector<ParticleHandle> taken() const final { return hand_ ? hand_->taken() : std::vector<ParticleHandle>{}; }
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
    const std::vector<Vec3> x = places();
    measure_constraints(on_host(executor_), model_, x, m);
    measure_tetrahedra(on_host(executor_), model_, x, m);
    for (const auto& pressure : pressures_) {
      m.volume_ratios.push_back(pressure.volume_ratio(x_.points()));
      m.elastic += pressure.energy(x_.points());
    }
    if (attachments_) m.elastic += attachments_->energy(x_.points(), time());
    if (hand_) m.elastic += hand_->energy(x);
    if (own_) m.elastic += own_->energy(x_.points(), w_.data());
    if (collider_) {
      m.contacts = collider_->contacts();
      m.penetration_max = collider_->max_penetration(particles(), time());
    }
    if (self_) m.self_contacts = self_->contacts();
    if (edges_) m.edge_contacts = edges_->contacts();
    m.crossings = crossings_at(x);
    return m;
  }
  StrainSample strains() const final {
    StrainSample sample = sample_strains(on_host(executor_), model_, lengths_, places());
    if (long_range_) sample.beyond = long_range_->beyond(x_.points(), w_.data());
    return sample;
  }
  const std::vector<LengthRun>& lengths() const final { return lengths_; }
  int steps_to_sample() const final {
    const SolverSpec& solver = model_.scene.solver;
    double lengths = facts_.attachments;
    for (const LengthRun& run : lengths_) lengths += run.count;
    if (!(lengths > 0)) return 0;
    // In times of a projection: six a length sampled, and for a particle that may touch something twenty a substep.
    // Launches alone take some thousands.
    const double contacts = collider_ || self_ || edges_ ? 20.0 * solver.substeps * model_.count() : 0;
    const double step = static_cast<double>(facts_.projections_per_step) + lengths + contacts + 4000;
    return std::clamp(static_cast<int>(std::ceil(6 * lengths / (0.01 * step))), 1, 128);
  }
  std::int64_t crossings() const final { return crossings_at(places()); }

 protected:
  /// `threads`: of the executor. A method that needs no sweep lays out none.
  TimeStepper(const Model& model, const Executor& executor, int threads, bool sweeps)
      : executor_(executor), model_(model), gravity_(norm(model.scene.gravity)), guard_(executor, model) {
    facts_.layout_seconds = seconds([&] { lay_out_particles(); });
    facts_.constraint_seconds = seconds([&] {
      if (sweeps) sweep_.emplace(executor, model, threads);
      for (const PressureSet& set : model.pressures) pressures_.emplace_back(executor, model, set);
    });
    if (sweep_) facts_.colour_seconds = sweep_->facts().plan_seconds;
    facts_.layout_seconds += facts_.constraint_seconds - facts_.colour_seconds;
    if (model.long_range.items() > 0) long_range_.emplace(executor, model.long_range);
    if (!model.free.empty()) free_.emplace(executor, model);
    if (!model.damped.empty()) damping_.emplace(executor, model.damped, model.scene.solver.substeps);
    if (!model.air.particle.empty()) air_.emplace(executor, model.air, *model.scene.wind);
    if (model.scene.sleep) sleeper_.emplace(executor, model);
    if (!model.moved.empty()) moved_.emplace(executor, model), moved_->hold(0, w_.data());
    if (can_tear(model.scene)) breakable_.emplace(executor, tearable_edges(model));
    if (!model.attached.empty()) attachments_.emplace(executor, model);
    if (!model.environment.empty()) facts_.collision_seconds = seconds([&] { collider_.emplace(executor, model); });
    if (names_edges(model.scene)) facts_.collision_seconds += seconds([&] { edges_.emplace(executor, model); });
    if (model.scene.self_collision) facts_.collision_seconds += seconds([&] { self_.emplace(executor, model); });
    if (self_ && collider_) kinematic_.emplace(executor, model.x.size());
    if (self_) objects_ = fastest_object(model, model.scene.solver.dt / model.scene.solver.substeps);
    if (model.interactive) hand_.emplace(executor, model);
    note_facts();
  }

  /// A step, awake.
  virtual void advance() { advance_from(0); }

  /// From a substep on.
  void advance_from(int first) {
    const SolverSpec& solver = model_.scene.solver;
    const double h = solver.dt / solver.substeps;
    const auto at = [&](int s) { return (steps_ + double(s) / solver.substeps) * solver.dt; };  // steps end alike
    repeat_step("substeps", [&] {
      if (first == 0) start_step();
      for (int s = first; s < solver.substeps; ++s) {
        if (moved_) timed(Pass::Pins, [&] { place_pins(at(s), at(s + 1)); });
        if (attachments_ && attachments_->release(at(s))) keep_overlaps();
        if (hand_) hand_->place(particles(), s);
        substep_ = s;
        substep(time() + s * h, h);
        if (hand_) hand_->arrive(particles(), s);
        if (moved_) timed(Pass::Pins, [&] { moved_->arrive(particles(), at(s), at(s + 1)); });
        if (watched()) (*watcher_)(s + 1, at(s + 1));
      }
    });
    if (!checks_finite_each_substep()) require_places();
    restore_momenta();
    ++steps_;
  }

  void restore_momenta() {
    const auto work = [&] { free_->give_back(particles(), can_fuse_passes()); };
    if (free_) repeat_step("momenta", [&] { timed(Pass::Correction, work); });
  }

  /// Part of a step, recorded where all steps launch the same. What times its passes records none.
  template <class Work>
  void repeat_step(const std::string& part, const Work& work) {
    if (is_timed(executor_) || !can_capture_step(model_) || has_external_constraints() || watched()) return work();
    repeated(
        executor_, recorded_, [&] { return part + key_from(can_fuse_passes()) + steady_key(model_.scene); }, work);
  }

  /// What the wind does to v: on faces, if air has a density, and on particles, if it drags them.
  void apply_wind(double h) {
    if (air_) timed(Pass::Air, [&] { air_->apply_wind(particles(), h); });
    if (const auto& wind = model_.scene.wind; wind && wind->drag > 0)
      timed(Pass::Prediction, [&] {
        parallel_for(executor_, model_.count(), Drag<R>{particles(), R(h), R(wind->drag), to_R(wind->velocity)});
      });
  }

  /// What is looked up once a step.
  virtual void start_step() {}
  /// v and p of a substep of h seconds, from what acts on the particles, the wind included.
  virtual void predict(double h) = 0;
  /// What happens between prediction and the first projection, contacts known.
  virtual void correct(const Particles<R>& /*all*/) {}
  /// At the start of a substep, all where it begins.
  virtual void start_pressures(const Particles<R>& all) {
    if (!pressures_.empty())
      timed(Pass::Pressure, [&] {
        for (auto& pressure : pressures_) pressure.start_substep(all.p, all.w, false);
      });
  }
  /// One projection of all pressures.
  virtual void press(const Particles<R>& all) {
    for (auto& pressure : pressures_) pressure.project(all.p, all.w);
  }
  /// Throws Diverged where a substep of the step that ends has left a particle without a finite place.
  virtual void require_places() {
    timed(Pass::State, [&] { refuse(lost_.in_step()); });
  }
  /// Whether what follows the prediction is done in it, up to the new state.
  virtual bool predicts_the_state() const { return false; }
  /// At the end of a substep of h seconds, unless the prediction does what follows.
  virtual void end_substep(double /*h*/) {}
  /// Called after every iteration. True if the constraints are met within the tolerance, so that no other is needed.
  virtual bool converged() { return false; }
  /// Called when gravity changes, for methods that cache it.
  virtual void on_gravity_changed() {}
  /// Name of the component that was built for a fixed set of pins (for error messages), or null.
  virtual const char* requires_fixed_pins() const { return nullptr; }

  void substep(double start, double h) {
    const Particles<R> all = particles();
    // Gravity is uniform: whether the rigid part of the motion is taken before or after it is the same.
    if (damping_) timed(Pass::Damping, [&] { damping_->damp(all); });
    predict(h);
    if (predicts_the_state()) return;
    const auto go_on = [&](const ActiveMask& asked) {
      if (!edges_ && !free_ && solve_is_next(model_, facts_))
        early_.begin(executor_, *sweep_, make_solve_pass(h, true), asked);
    };
    if (collider_) timed(Pass::Collision, [&] { collider_->detect_contacts(all, start, start + h, go_on); });
    if (self_) self_->start_substep();
    if (edges_) timed(Pass::Edges, [&] { edges_->detect_contacts(all, start, start + h); });
    correct(all);
    start_pressures(all);
    if (!model_.sets.empty() || !runs_fused())
      for (int iteration = 0; iteration < model_.scene.solver.iterations; ++iteration) {
        project(all, start, h, iteration == 0);
        if (converged()) break;
      }
    if (collider_) timed(Pass::Collision, [&] { collider_->clamp_tunnelling(all); });
    hold_apart(all);
    if (self_) timed(Pass::SelfCollision, [&] { self_->note_held(all, bool(collider_)); });
    timed(Pass::State, [&] {
      lost_.update(executor_, all, h, substep_);
      if (checks_finite_each_substep()) refuse(lost_.in(substep_));
    });
    if (collider_) bounce(all, h);
    if (self_) timed(Pass::SelfCollision, [&] { self_->end_substep(all, h, objects_); });
    if (edges_) timed(Pass::Edges, [&] { edges_->end_substep(all); });
    end_substep(h);
  }

  void hold_apart(const Particles<R>& all) {
    malha::hold_apart(self_, edges_, collider_, kinematic_, all,
                      [&](Pass pass, const auto& work) { timed(pass, work); });
  }
  /// Restitution: what bounces moves on from where the substep ended, and that motion is guarded against intersections
  /// too.
  void bounce(const Particles<R>& all, double h) {
    timed(Pass::Contact, [&] { collider_->restitute(all, 2 * h * gravity_, h); });
    if (!collider_->bounces()) return;
    if (self_ || edges_) collider_->end_motion(), hold_apart(all);
    timed(Pass::State, [&] { parallel_for(executor_, all.count, ArriveAll<R>{all.p}); });
  }

  /// Pins whose time is over let go, and nothing that they pressed together is shot apart.
  void place_pins(double start, double end) {
    const int before = pins_let_go();
    moved_->place(particles(), w_.data(), start, end);
    if (pins_let_go() > before) keep_overlaps();
  }
  void keep_overlaps() {
    if (self_) self_->keep_overlaps();
    if (edges_) edges_->keep_overlaps();
    if (collider_) collider_->keep_overlaps();
  }
  int pins_let_go() const { return moved_ ? moved_->released() : 0; }
  /// Now, 1/kg, in the solver's order: 0 where particles are held.
  std::vector<double> weights_in_order() const {
    const std::vector<R> w = w_.download();
    return {w.begin(), w.begin() + model_.count()};
  }

  Particles<R> particles() const {
    return {model_.count(), x_.points(), v_.points(), {x_.points(), d_.points(), low_.points()}, w_.data()};
  }
  /// In the solver's order, with what x lacks of them.
  std::vector<Vec3> places() const {
    std::vector<Vec3> all = x_.download();
    if constexpr (kCarries<R>) {
      const std::vector<Vec3> low = low_.download();
      for (std::size_t i = 0; i < all.size(); ++i)
        for (int k = 0; k < 3; ++k) all[i][k] += low[i][k];
    }
    return all;
  }
  SolvePatch<R> visit(double h) const { return sweep_->visit(particles(), h, to_R(model_.scene.gravity)); }
  /// Where other passes come between, visits neither predict nor update.
  SolvePatch<R> make_solve_pass(double h, bool first_iteration) const {
    SolvePatch<R> between = visit(h);
    between.first_iteration = first_iteration;
    return between;
  }
  Vec3 place_of(std::size_t i) const {
    Vec3 place = x_.get(i);
    if constexpr (kCarries<R>)
      for (int k = 0; k < 3; ++k) place[k] += low_.get(i)[k];
    return place;
  }
  void put(std::size_t i, const Vec3& place) {
    x_.set(i, place), d_.set(i, {0, 0, 0});
    if constexpr (kCarries<R>) low_.set(i, minus(place, x_.get(i)));
  }
  /// Without -0, which packs do not keep either.
  static Vector3<R> to_R(const Vec3& a) { return {R(a[0] + 0), R(a[1] + 0), R(a[2] + 0)}; }

  bool runs_fused() const { return can_fuse_passes() && !has_external_constraints() && !watched(); }
  /// Whether constraints of batches alone change momenta between the prediction and the new state: Desbrun's filter is
  /// part of the prediction. Of long range the model may have let go.
  bool can_fuse_passes() const {
    return model_.scene.solver.type == "pbd" && !long_range_ && has_no_mid_step_passes(model_);
  }
  bool in_hand() const { return hand_ && !hand_->empty(); }
  /// By hand or by constraints of the caller's own, of which what was laid out knows nothing.
  bool has_external_constraints() const { return in_hand() || own_; }
  bool watched() const { return watcher_ != nullptr; }

  /// Refuses an explosion that is finite still. `now`: at whatever step this is.
  void guard(bool now = false) {
    timed(model_.scene.solver.type == "pbd" && runs_fused() ? Pass::FusedSolve : Pass::State, [&] {
      const auto wrong = guard_.watch(
          particles(), steps_, [&] { return places(); }, [&] { return v_.download(); }, now);
      if (wrong)
        throw Diverged("step " + std::to_string(steps_) + " (t = " + std::to_string(time()) + " s): " + *wrong);
    });
  }

  /// True if a pass inside the substep cannot handle NaN positions. Otherwise the check waits until the end of the
  /// step.
  bool checks_finite_each_substep() const { return collider_ || self_ || edges_ || own_ || watched(); }
  void refuse(const std::optional<int>& lost) const {
    if (lost) refuse_lost(model_.user_index[*lost]);
  }
  /// `lost`: a particle that is no longer finite, by the user's number.
  [[noreturn]] void refuse_lost(int lost) const {
    throw Diverged("step " + std::to_string(steps_ + 1) + " (t = " + std::to_string(time()) +
                   " s): " + particle_name(model_, lost) + " has no finite position any more");
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
  double gravity_, objects_ = 0;             // m/s^2; m/s: the fastest that objects move
  PointArray<Executor, R> x_, v_, d_, low_;  // see Particles
  std::optional<Sweep<Executor, R>> sweep_;
  std::vector<Pressure<Executor, R>> pressures_;
  std::optional<FreeBodies<Executor, R>> free_;
  std::optional<EnvironmentCollider<Executor, R>> collider_;
  std::optional<EdgeCollider<Executor, R>> edges_;
  std::int64_t steps_ = 0;
  int substep_ = 0;  // of the step
  SolverStats facts_;

 private:
  void exclude_from_momentum_correction() {
    std::vector<int> all = hand_ ? hand_->particles() : std::vector<int>{};
    if (own_) std::ranges::copy(own_->particles(), std::back_inserter(all));
    if (free_) free_->leave_out(all);
  }

  /// Of the present state, which several ask for: counted once.
  std::int64_t crossings_at(const std::vector<Vec3>& x) const {
    if (crossings_step_ != steps_) {
      crossings_ =
          (self_ ? count_crossings(self_->surface(), x) : 0) + (edges_ ? count_edge_crossings(model_, x, time()) : 0);
      crossings_step_ = steps_;
    }
    return crossings_;
  }

  void lay_out_particles() {
    x_ = PointArray<Executor, R>(model_.x), v_ = PointArray<Executor, R>(model_.v);
    d_ = PointArray<Executor, R>(model_.x.size());
    if constexpr (kCarries<R>) {
      State<R> start;
      put_places(model_.x, start);
      low_ = PointArray<Executor, R>(model_.x.size()), low_.upload(start.low);
    }
    std::vector<R> w(model_.w.begin(), model_.w.end());
    w.resize(w.size() + kSlotPack);  // a pack that starts at the last particle stays inside
    w_ = Array<Executor, R>(w);
  }
  State<R> state() const {
    State<R> now{steps_, x_.template download<std::array<R, 3>>(), v_.template download<std::array<R, 3>>()};
    if constexpr (kCarries<R>) now.low = low_.template download<std::array<R, 3>>();
    return now;
  }

  /// With what the next step needs beside it, but for contacts.
  State<R> remembered() const {
    State<R> all = state();
    if (sleeper_) all.rest = sleeper_->save_state();
    if (self_) all.self = self_->save_state();
    if (edges_) all.edges = edges_->save_state();
    return all;
  }

  State<R> load(const std::string& bytes, std::size_t particles, const std::string& file) const {
    const StateSizes sizes{.particles = particles,
                           .meshes = model_.environment.size(),
                           .rest = sleeper_ ? std::size_t(2) : 0,
                           .searched = self_ ? particles : 0,
                           .edge_groups = edges_ ? static_cast<std::size_t>(edges_->groups()) : 0};
    return load_state<R>(bytes, sizes, collider_ ? collider_->triangles() : std::vector<int>{}, file);
  }

  /// Contacts last: what leaves the iteration is outside the environment.
  void project(const Particles<R>& all, double start, double h, bool first_iteration) {
    if (free_ && !can_fuse_passes()) timed(Pass::Correction, [&] { free_->before_projection(all, h); });
    if (!model_.sets.empty())
      timed(Pass::Projection, [&] { early_.go_on(*sweep_, make_solve_pass(h, first_iteration)); });
    if (!pressures_.empty()) timed(Pass::Pressure, [&] { press(all); });
    if (free_ && !can_fuse_passes()) timed(Pass::Correction, [&] { free_->after_projection(all, h); });
    if (long_range_) timed(Pass::LongRange, [&] { long_range_->project(all.p, all.w); });
    if (attachments_)
      timed(Pass::Attachments, [&] { attachments_->project(all.p, all.w, start, start + h, first_iteration); });
    if (own_) timed(Pass::UserConstraints, [&] { own_->project(all.p, all.w, first_iteration); });
    if (in_hand()) timed(Pass::Attachments, [&] { hand_->project(all.p, all.w, first_iteration); });
    if (self_) timed(Pass::SelfCollision, [&] { self_->solve_contacts(all); });
    if (edges_) timed(Pass::Edges, [&] { edges_->solve_contacts(all); });
    if (collider_) timed(Pass::Contact, [&] { collider_->solve_contacts(all); });
  }

  void note_facts() {
    facts_.particle_bytes = x_.bytes() + v_.bytes() + d_.bytes() + low_.bytes() + w_.bytes() + bytes_of(moved_) +
                            bytes_of(free_) + bytes_of(damping_);
    facts_.constraint_bytes += bytes_of(breakable_) + bytes_of(attachments_);
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
      facts_.constraint_bytes += set.bytes, projections += kThereAndBack * std::int64_t{set.constraints};
    for (const auto& pressure : pressures_) facts_.constraint_bytes += pressure.bytes();
    facts_.pressure_launches = 4 * pressures_.size(), facts_.pressure_starts = 3 * pressures_.size();
    note_collision();
    facts_.projections_per_step = projections * model_.scene.solver.substeps * model_.scene.solver.iterations;
  }

  const SubstepCallback* watcher_ = nullptr;  // of this step; null: none
  Array<Executor, R> w_;
  std::optional<Damping<Executor, R>> damping_;
  std::vector<LengthRun> lengths_ = length_runs(model_);
  FiniteCheck<Executor> lost_{model_.scene.solver.substeps};
  EarlyVisits<Executor, R> early_;
  EnergyGuard<Executor, R> guard_;
  Recording<Executor> recorded_;  // parts of steps
  std::optional<LongRange<Executor, R>> long_range_;
  std::optional<KinematicPins<Executor, R>> moved_;
  std::optional<Attachments<Executor, R>> attachments_;
  std::optional<ParticleHandles<Executor, R>> hand_;
  std::optional<UserConstraints<Executor, R>> own_;
  std::optional<Limits<Executor, R>> breakable_;  // edges that tear
  std::optional<Air<Executor, R>> air_;
  std::optional<Sleeper<Executor, R>> sleeper_;
  std::optional<SelfCollider<Executor, R>> self_;
  std::optional<KinematicParticles<Executor, R>> kinematic_;  // with self_ and collider_
  std::array<double, kPassNames.size()> seconds_{};
  mutable std::int64_t crossings_step_ = -1, crossings_ = 0;  // the step of which they were counted, and how many
};

}  // namespace malha
