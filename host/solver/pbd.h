// Position Based Dynamics (Müller et al. 2006) with XPBD's compliance (Macklin et al. 2016) and substeps (Macklin et
// al. 2019).
#pragma once
#include "host/solver/levels.h"
#include "host/solver/stepper.h"

namespace malha {

template <class Executor, class R>
class Pbd final : public Stepper<Executor, R> {
  using Base = Stepper<Executor, R>;
  using Base::executor_, Base::model_, Base::sweep_;

 public:
  /// `threads`: of the executor.
  Pbd(const Model& model, const Executor& executor, int threads)
      : Base(model, executor, threads, true, Base::nothing_between(model) && model.scene.solver.iterations > 1),
        threads_(threads) {
    this->facts_.fused = this->nothing_between();
    lay_out_levels();
    this->facts_.whole_steps =
        this->nothing_between() && model.damped.empty() && model.moved.empty() && !model.scene.wind;
  }

 private:
  void advance() override {
    const SolverSpec& solver = model_.scene.solver;
    if (!this->facts_.whole_steps) return Base::advance();
    visit_patches(solver.dt / solver.substeps, solver.substeps);
    this->give_back_momenta();
    ++this->steps_;
  }
  /// For those that are held now.
  void lay_out_levels() {
    if (model_.scene.solver.levels == 0) return;
    held_until_ = this->pins_let_go();
    this->facts_.level_seconds += seconds([&] {
      const std::vector<Level> levels = make_levels(model_, this->inverse_masses(), threads_);
      levels_.reset();
      if (!levels.empty()) levels_.emplace(executor_, levels, *sweep_, threads_, this->nothing_between());
    });
    this->facts_.levels = levels_ ? levels_->facts() : std::vector<LevelFacts>{};
    this->facts_.level_bytes = levels_ ? levels_->bytes() : 0;
  }

  void predict(double h) override {
    if (held_until_ != this->pins_let_go()) lay_out_levels();
    this->blow(h);
    if (this->nothing_between()) return visit_patches(h, 1);
    this->timed(Pass::Prediction, [&] {
      parallel_for(executor_, model_.count(), Predict<R>{this->particles(), R(h), this->to_R(model_.scene.gravity)});
    });
    if (levels_ && levels_now(this->substep_))
      this->timed(Pass::Levels,
                  [&] { sweep_->region([&](const auto& team) { levels_->move(team, *sweep_, this->particles()); }); });
  }
  /// Whether a step's substep, counted from 0, uses the levels.
  bool levels_now(int substep) const { return substep % model_.scene.solver.levels_every == 0; }
  bool predicts_the_state() const override { return this->nothing_between(); }

  /// Substeps of prediction, projection and state in one parallel region.
  void visit_patches(double h, int substeps) {
    const int iterations = model_.scene.solver.iterations;
    if (this->momenta_) this->timed(Pass::Correction, [&] { this->momenta_->before(this->particles()); });
    const Visit<R> plain = sweep_->visit(this->particles(), h, this->to_R(model_.scene.gravity));
    const Particles<R>& all = plain.particles;
    const Foreseen<R> foreseen{all.x, all.v, all.w, plain.dt, plain.gravity};
    this->timed(Pass::Visits, [&] {
      sweep_->region([&](const auto& team) {
        for (int s = 0; s < substeps; ++s) {
          const bool levels = levels_ && levels_now(this->substep_ + s);
          const bool next = levels_ && s + 1 < substeps && levels_now(this->substep_ + s + 1);
          if (levels) {
            if (s == 0) levels_->restrict_from(team, *sweep_, foreseen);
            levels_->sweep(team);
          }
          for (int iteration = 0; iteration < iterations; ++iteration) {
            Visit<R> visit = plain;
            visit.predicts = visit.fresh = iteration == 0;
            visit.updates = iteration + 1 == iterations;
            visit.substep = s + 1;
            if (levels && visit.predicts) visit.down = levels_->down();
            if (next && visit.updates) visit.up = levels_->up();
            (*sweep_)(team, visit);
          }
          if (next) levels_->join_parts(team);
        }
      });
    });
    if (sweep_->lost()) this->refuse_lost(sweep_->first_lost(this->x_.download(), model_.user_of));
    if (!this->momenta_) return;
    const Vec3& g = model_.scene.gravity;
    const double t = h * substeps;
    this->timed(Pass::Correction, [&] { this->momenta_->after(this->particles(), {g[0] * t, g[1] * t, g[2] * t}); });
  }

  int threads_;
  int held_until_ = 0;  // the pins that were let go when the levels were laid out
  Part<Levels<Executor, R>, built("levels")> levels_;
};

}  // namespace malha
