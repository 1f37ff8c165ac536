// Position Based Dynamics (Müller et al. 2006) with XPBD's compliance (Macklin et al. 2016) and substeps (Macklin et
// al. 2019).
#pragma once
#include "host/solver/stepper.h"

namespace malha {

template <class Executor, class R>
class Pbd final : public Stepper<Executor, R> {
  using Base = Stepper<Executor, R>;
  using Base::executor_, Base::model_, Base::sweep_;

 public:
  /// `threads`: of the executor.
  Pbd(const Model& model, const Executor& executor, int threads)
      : Base(model, executor, threads, true, Base::nothing_between(model) && model.scene.solver.iterations > 1) {
    this->facts_.fused = this->nothing_between();
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
  void predict(double h) override {
    this->blow(h);
    if (this->nothing_between()) return visit_patches(h, 1);
    this->timed(Pass::Prediction, [&] {
      parallel_for(executor_, model_.count(), Predict<R>{this->particles(), R(h), this->to_R(model_.scene.gravity)});
    });
  }
  bool predicts_the_state() const override { return this->nothing_between(); }

  /// Substeps of prediction, projection and state in one parallel region.
  void visit_patches(double h, int substeps) {
    const int iterations = model_.scene.solver.iterations;
    if (this->momenta_) this->timed(Pass::Correction, [&] { this->momenta_->before(this->particles()); });
    const Visit<R> plain = sweep_->visit(this->particles(), h, this->to_R(model_.scene.gravity));
    this->timed(Pass::Visits, [&] {
      sweep_->region([&](const auto& team) {
        for (int s = 0; s < substeps; ++s)
          for (int iteration = 0; iteration < iterations; ++iteration) {
            Visit<R> visit = plain;
            visit.predicts = visit.fresh = iteration == 0;
            visit.updates = iteration + 1 == iterations;
            visit.substep = s + 1;
            (*sweep_)(team, visit);
          }
      });
    });
    if (sweep_->lost()) this->refuse_lost(sweep_->first_lost(this->x_.download(), model_.user_of));
    if (!this->momenta_) return;
    const Vec3& g = model_.scene.gravity;
    const double t = h * substeps;
    this->timed(Pass::Correction, [&] { this->momenta_->after(this->particles(), {g[0] * t, g[1] * t, g[2] * t}); });
  }
};

}  // namespace malha
