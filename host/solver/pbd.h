// SPDX-License-Identifier: Apache-2.0
// Position Based Dynamics (Müller et al. 2006) with XPBD's compliance (Macklin et al. 2016) and substeps (Macklin et
// al. 2019).
#pragma once
#include <algorithm>
#include <deque>
#include <string>

#include "host/filter/bending_filter.h"
#include "host/multilevel/levels.h"
#include "host/solver/stepper.h"

namespace malha {

template <class Executor, class R>
class Pbd final : public TimeStepper<Executor, R> {
  using Base = TimeStepper<Executor, R>;
  using Base::executor_, Base::model_, Base::sweep_;

 public:
  /// `threads`: number of threads of the executor.
  Pbd(const Model& model, const Executor& executor, int threads, const ShowProgress& progress)
      : Base(model, executor, threads, true), threads_(threads), levels_interval_(levels_interval(model)) {
    this->facts_.levels_interval = levels_interval_;
    if (!model.stencils.empty()) make_bending_filter(progress);
    lay_out_levels();
    if (!levels_.empty()) this->set_features(step_features(model, true));
    if (!this->plan_.skips_contacts) return;
    this->collider_->allocate_clearance(model.x.size()), sweep_->allocate_speed_limit();
    this->note_collision();
  }

  std::vector<double> level_seconds() const override {
    std::vector<double> sum(this->facts_.levels.size(), 0);
    for (const auto& levels : levels_)
      for (std::size_t l = 0; levels && l < std::min(sum.size(), levels->seconds_of_each().size()); ++l)
        sum[l] += levels->seconds_of_each()[l];
    return sum;
  }

 private:
  void advance() override {
    if (bending_filter_) refactor_bending();
    const SolverSpec& solver = model_.scene.solver;
    const double h = solver.dt / solver.substeps;
    if (this->plan_.solves != PatchSolves::ByStep)
      return this->advance_from(this->plan_.skips_contacts ? step_without_contacts(h) : 0);
    this->substep_ = 0;
    this->repeat_step("fused solve", [&] {
      start_step();
      solve_substeps(h, solver.substeps);
    });
    check_finite();
    this->restore_momenta();
    ++this->steps_;
  }

  void start_step() override {
    for (const auto& levels : levels_)
      if (levels) levels->set_origins(executor_, this->particles().x);
  }

  /// Runs substeps of a step as patch solves without contact tests, and returns how many, as long as no particle can
  /// reach the environment. A particle that moved farther than its speed allowed is clamped after its substep.
  int step_without_contacts(double h) {
    auto& collider = *this->collider_;
    const int substeps = model_.scene.solver.substeps;
    double speed = 0;
    this->timed(Pass::Collision, [&] {
      const double acceleration = this->gravity_ + this->force_acceleration_;
      speed = collider.max_contact_free_speed(this->particles(), h, substeps, acceleration);
      if (speed > 0) collider.invalidate_contacts(this->particles());
    });
    if (!(speed > 0)) return 0;
    sweep_->start_speed_limit();
    const int done = solve_substeps(h, substeps, speed);
    check_finite();
    if (sweep_->speed_exceeded(done))
      this->timed(Pass::Collision,
                  [&] { collider.clamp_tunnelling_late(this->particles(), this->time() + (done - 1) * h, h); });
    return done;
  }

  /// Throws Diverged if patch solves have left a position that is not finite.
  void check_finite() {
    if (sweep_->has_non_finite())
      this->refuse_non_finite(sweep_->first_non_finite(this->x_.download(), model_.user_index));
  }
  void require_finite() override { this->plan_.fuses() ? check_finite() : Base::require_finite(); }

  /// Makes the levels for the state after each release of pins beforehand: the model is not kept.
  void lay_out_levels() {
    if (model_.scene.solver.levels == 0) return;
    std::vector<const MovedPins*> released;
    for (const MovedPins& pins : model_.moved)
      if (pins.release_time) released.push_back(&pins);
    std::stable_sort(released.begin(), released.end(),
                     [](auto a, auto b) { return *a->release_time < *b->release_time; });
    std::vector<double> w = this->inverse_masses_in_order();
    for (std::size_t count = 0;; ++count) {
      add_levels(w);
      if (count == released.size()) break;
      for (const int i : released[count]->particles) w[i] = model_.w[i];
    }
    const auto& first = levels_.front();
    this->facts_.levels = first ? first->facts() : std::vector<LevelStats>{};
    for (const auto& levels : levels_) this->facts_.level_bytes += levels ? levels->bytes() : 0;
    const auto none = [](const auto& levels) { return !levels; };
    if (std::all_of(levels_.begin(), levels_.end(), none)) levels_.clear();
  }
  void add_levels(const std::vector<double>& w) {
    this->facts_.level_seconds += seconds([&] {
      const std::vector<Level> levels = make_levels(model_, w, on_host(executor_));
      auto& own = levels_.emplace_back();
      if (levels.empty()) return;
      ++this->facts_.level_layouts;
      own.emplace(executor_, levels, *sweep_, threads_, this->plan_.solves_alone != PatchSolves::InIterations,
                  model_.patches.islands, model_.interactive);
    });
  }

  /// The levels for the present pins if this substep of a step, counted from 0, uses them; otherwise null.
  const Levels<Executor, R>* levels_at(int substep) const {
    if (levels_.empty() || substep % levels_interval_ != 0) return nullptr;
    const auto& levels = levels_[this->released_pin_sets()];
    return levels ? &*levels : nullptr;
  }

  void apply_coarse_correction(const Particles<R>& all) override {
    if (const auto* levels = levels_at(this->substep_))
      this->timed(Pass::Levels, [&] {
        sweep_->region([&](const auto& team) { levels->apply_coarse_correction(team, *sweep_, all); });
      });
  }

  void predict(double h) override {
    this->timed(Pass::Prediction, [&] {
      parallel_for(executor_, model_.count(), Predict<R>{this->particles(), R(h), this->to_R(model_.scene.gravity)});
    });
  }
  void filter_bending() override {
    refactor_bending();
    this->timed(Pass::Filter, [&] { bending_filter_->apply(this->particles()); });
  }
  void make_bending_filter(const ShowProgress& progress) {
    const SolverSpec& solver = model_.scene.solver;
    filtered_w_ = this->inverse_masses_in_order();
    bending_filter_.emplace(executor_, threads_, model_, filtered_w_, solver.dt / solver.substeps, progress);
    SolverStats& facts = this->facts_;
    facts.filter = bending_filter_->facts(), facts.free_bodies = bending_filter_->free_bodies();
    facts.spring_bytes = bending_filter_->force_bytes(), facts.bending_launches = bending_filter_->launches();
    facts.particle_bytes += bending_filter_->particle_bytes();
  }
  /// Factors the filter anew if particles are pinned now that were not, or the other way round.
  void refactor_bending() {
    if (!this->pins_changed_) return;
    this->pins_changed_ = false;
    std::vector<double> w = this->inverse_masses_in_order();
    if (w == filtered_w_) return;
    filtered_w_ = std::move(w);
    bending_filter_->factor(filtered_w_, {});
    ++this->layouts_;
  }
  std::optional<FilterErrors> filter_errors() const override {
    if (!bending_filter_) return std::nullopt;
    const SolverSpec& solver = model_.scene.solver;
    return malha::filter_errors<Executor>(bending_filter_->filter(), model_,
                                          spring_system(model_, solver.dt / solver.substeps, filtered_w_));
  }
  void solve_substep(double h) override { solve_substeps(h, 1); }
  const char* requires_fixed_pins() const override {
    return levels_.empty() ? nullptr : "levels, which are laid out for what is pinned";
  }

  /// Runs substeps of prediction, projection and state update in one parallel region, up to the first in which a
  /// particle was faster than `speed` (m/s). Returns how many.
  int solve_substeps(double h, int substeps, double speed = INFINITY) {
    int done = substeps;
    const bool limits_speed = speed < INFINITY;
    const int iterations = model_.scene.solver.iterations;
    if (this->momentum_corrector_) this->measure_momenta();
    SolvePatch<R> plain = this->make_solve(h);
    plain.time = this->closing_time(this->substep_);
    this->timed(Pass::FusedSolve, [&] {
      const auto solve_all = [&](const auto& team) {
        for (int s = 0; s < substeps; ++s) {
          const auto* levels = levels_at(this->substep_ + s);
          const auto* next = s + 1 < substeps ? levels_at(this->substep_ + s + 1) : nullptr;
          if (levels && s == 0) levels->restrict_prediction(team, *sweep_, plain);
          if (levels) levels->solve_restricted(team);
          for (int iteration = 0; iteration < iterations; ++iteration) {
            SolvePatch<R> solve = plain;
            solve.time = this->closing_time(this->substep_ + s);
            if (iteration == 0) {
              PatchPrediction<R> prediction;
              if (levels) prediction.correction = levels->prolongation();
              solve.first = FirstIteration<R>{prediction};
            }
            if (iteration + 1 == iterations) {
              PatchUpdate<R> update = sweep_->make_update(s + 1);
              if (next) update.restriction = next->restriction();
              if (limits_speed) update.speed_limit = sweep_->speed_limit(speed, s + 1);
              solve.update = update;
            }
            (*sweep_)(team, solve);
          }
          if (!limits_speed || !sweep_->speed_exceeded(s + 1)) continue;
          if (is_leader(team)) done = s + 1;
          return;
        }
      };
      const auto key = [&] {
        std::string text = key_from(substeps);
        for (int s = 0; s < substeps; ++s) text += key_from(levels_at(this->substep_ + s));
        return text;
      };
      // With a limit the host reads after each substep whether it was exceeded.
      limits_speed ? sweep_->region(solve_all) : this->repeat_solves(plain, key, solve_all);
    });
    if (this->momentum_corrector_) this->compare_momenta(h * substeps);
    return done;
  }

  int threads_, levels_interval_;  // an interval of substeps
  std::optional<BendingFilter<Executor, R>> bending_filter_;
  std::vector<double> filtered_w_;                         // inverse masses for which it is factored, 1/kg
  std::deque<std::optional<Levels<Executor, R>>> levels_;  // by number of released sets of pins; empty: no levels
};

}  // namespace malha
