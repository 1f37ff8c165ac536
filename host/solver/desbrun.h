// SPDX-License-Identifier: Apache-2.0
// Desbrun, Schröder, Barr, "Interactive Animation of Structured Deformable Objects" (1999): the forces of springs go
// through a precomputed filter, S = (M - dt^2 H)^-1, and then move the particles explicitly. With refinement iterations
// the same filter solves on for backward Euler of the true springs (Liu et al. 2013).
#pragma once
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "host/filter/corrector.h"
#include "host/filter/filter.h"
#include "host/filter/spring_forces.h"
#include "host/measure/over_elongation.h"
#include "host/solver/stepper.h"

namespace malha {

template <class Executor, class R>
class Desbrun final : public TimeStepper<Executor, R> {
  using Base = TimeStepper<Executor, R>;
  using Base::executor_, Base::model_, Base::facts_, Base::pressures_;

 public:
  /// `threads`: number of threads of the executor.
  Desbrun(const Model& model, const Executor& executor, int threads, const ShowProgress& progress)
      : Base(model, executor, threads, !model.sets.empty()),
        spec_(model.scene.solver.desbrun),
        corrector_(spec_.corrects()) {
    if (spec_.tolerance && !model.sets.empty()) {  // of distance limits, the only kind that is projected in batches
      length_limits_.emplace(executor, model);
      facts_.constraint_bytes += length_limits_->bytes();
    }
    if (model.springs.empty() && model.stencils.empty()) return;
    const SpringSystem system = this->system();
    filter_ = make_filter<Executor, R>(executor, threads, model, system, progress);
    forces_.emplace(executor, threads, model, filtered_masses(system));
    force_ = PointArray<Executor, R>(model.x.size()), acceleration_ = PointArray<Executor, R>(model.x.size());
    if (spec_.refinement_iterations > 0) {
      std::vector<R> mass;  // that of pinned particles is unused: they have no acceleration
      for (const double w : model.w) mass.push_back(w > 0 ? R(1 / w) : R(0));
      mass.resize(mass.size() + kSpringPack);
      mass_ = Array<Executor, R>(mass);
    }
    for (const SystemBlock& body : system.blocks)
      if (body.free) free_blocks_.push_back(body);
    if (!free_blocks_.empty()) members_ = Array<Executor, int>(system.particle), filter_corrector_.emplace(executor);
    facts_.filter = filter_->facts();
    facts_.free_bodies = static_cast<int>(free_blocks_.size());
    facts_.corrects = corrector_ != Corrector::Off;
    if (!pressures_.empty()) assign_pressures(system), note_pressures();
    facts_.spring_bytes = forces_->bytes(), facts_.force_launches = forces_->launches();
    facts_.particle_bytes += force_.bytes() + acceleration_.bytes() + mass_.bytes() + members_.bytes();
  }

  std::optional<FilterErrors> filter_errors() const override {
    if (!filter_) return std::nullopt;
    return malha::filter_errors<Executor>(*filter_, model_, system());
  }

 private:
  SpringSystem system() const {
    const SolverSpec& solver = model_.scene.solver;
    return spring_system(model_, solver.dt / solver.substeps);
  }

  /// The mass of each particle whose weight is filtered, otherwise 0. On a free body the filter passes the weight
  /// unchanged; without it the result is exact.
  std::vector<double> filtered_masses(const SpringSystem& system) const {
    std::vector<double> filtered(model_.x.size(), 0);
    if (!spec_.filter_external_forces) return filtered;
    for (const SystemBlock& body : system.blocks)
      for (int i = body.first; i < body.first + body.count && !body.free; ++i)
        filtered[system.particle[i]] = system.mass[i];
    return filtered;
  }

  void start_substep() override { substep_start_ = std::chrono::steady_clock::now(); }
  void predict(double h) override {
    const Particles<R> all = this->particles();
    const Vector3<R> g = this->to_R(model_.scene.gravity);
    if (!filter_)
      return this->timed(Pass::Prediction, [&] { parallel_for(executor_, all.count, Predict<R>{all, R(h), g}); });
    const Points<R> force = force_.points(), a = acceleration_.points();
    this->timed(Pass::Forces, [&] { forces_->sum_explicit(all, h, force); });
    this->timed(Pass::Filter, [&] { filter_->apply({force, a, false}); });
    for (int r = 0; r < spec_.refinement_iterations; ++r) {
      correct_bodies(Corrector::Off);
      this->timed(Pass::Forces, [&] { forces_->sum_missing(all, h, a, mass_.data(), force); });
      this->timed(Pass::Filter, [&] { filter_->apply({force, a, true}); });
    }
    correct_bodies(corrector_);
    this->timed(Pass::Prediction, [&] {
      parallel_for(executor_, all.count, FilteredMotion<R>{all, a, forces_->filtered_mass(), R(h), g});
    });
  }

  void correct_bodies(Corrector corrector) {
    if (free_blocks_.empty()) return;
    this->timed(Pass::MomentumCorrection, [&] { remove_net_motion(corrector); });
  }
  void remove_net_motion(Corrector corrector) {
    const Particles<R> all = this->particles();
    for (const SystemBlock& body : free_blocks_)
      filter_corrector_->correct({all.x, acceleration_.points(), all.w, members_.data() + body.first}, body.count,
                                 corrector);
  }

  /// Pressure is projected as in XPBD, but in the filter's metric, along S grad C instead of M^-1 grad C: this solves
  /// the filter's system with the stiffness of the pressure along its gradient added (Sherman, Morrison 1950). In the
  /// metric of the masses the correction would bypass the filter, whose response to the bending of single edges is
  /// smaller by a factor of m / (k dt^2): springs would be stretched by as many times too much. The gradient is that at
  /// the start of the substep, where springs have their directions from too, so that bodies at rest are in equilibrium.
  void start_pressures(const Particles<R>& all) override {
    if (!filter_) return Base::start_pressures(all);
    this->timed(Pass::Pressure, [&] {
      for (const std::vector<int>& product : filtered_pressures_)
        for (const int k : product) pressures_[k].start_substep(all.p, all.w, true);
      for (const int k : plain_pressures_) pressures_[k].start_substep(all.p, all.w, false);
    });
  }
  void press(const Particles<R>& all) override {
    if (!filter_) return Base::press(all);
    const Points<R> force = force_.points(), displacement = acceleration_.points();
    for (const std::vector<int>& product : filtered_pressures_) {
      parallel_for(executor_, all.count, ClearFilterIo<R>{{force, displacement, false}});
      for (const int k : product) pressures_[k].put(force);
      filter_->apply({force, displacement, false});
      remove_net_motion(Corrector::Inertia);
      for (const int k : product) pressures_[k].push(all.p, displacement);
    }
    for (const int k : plain_pressures_) pressures_[k].project(all.p, all.w);
  }
  /// Assigns pressures to products with S: those of different bodies share one.
  void assign_pressures(const SpringSystem& system) {
    std::vector<const SystemBlock*> block(model_.x.size(), nullptr);
    for (const SystemBlock& one : system.blocks)
      for (int i = one.first; i < one.first + one.count; ++i) block[system.particle[i]] = &one;
    std::vector<std::size_t> products(model_.scene.bodies.size(), 0);
    for (int k = 0; k < static_cast<int>(pressures_.size()); ++k) {
      if (!pushes_blocks(model_.pressures[k], block)) {
        plain_pressures_.push_back(k);
        continue;
      }
      const std::size_t product = products[pressures_[k].move_all(model_)]++;
      if (product == filtered_pressures_.size()) filtered_pressures_.emplace_back();
      filtered_pressures_[product].push_back(k);
    }
  }
  /// Tells whether springs connect the whole mesh, so that a pressure on it has no net force on any free block: the
  /// filter cannot represent the mean acceleration of one.
  bool pushes_blocks(const PressureSet& set, const std::vector<const SystemBlock*>& block) const {
    for (const Triangle& t : set.triangles)
      for (const int i : t) {
        const SystemBlock* const own = block[i];
        if (!own && model_.w[i] > 0) return false;
        for (const int j : t)
          if (own && block[j] != own && (own->free || model_.w[j] > 0)) return false;
      }
    return true;
  }
  void note_pressures() {
    std::size_t bytes = 0, launches = 4 * plain_pressures_.size(), starts = 3 * plain_pressures_.size();
    for (const std::vector<int>& product : filtered_pressures_) {
      launches += 1 + filter_->facts().launches + 5 * free_blocks_.size() + 5 * product.size();
      starts += 2 * product.size();
      for (const int k : product) bytes += pressures_[k].member_bytes();
    }
    facts_.pressure_launches = launches, facts_.pressure_starts = starts, facts_.constraint_bytes += bytes;
  }

  void on_gravity_changed() override {
    if (forces_) forces_->set_gravity(model_.scene.gravity);
  }

  const char* requires_fixed_pins() const override { return "Desbrun's filter, which is made for pins that stay"; }

  bool converged() override {
    if (spec_.time_budget) {
      synchronize(executor_);
      if (std::chrono::duration<double>(std::chrono::steady_clock::now() - substep_start_).count() > *spec_.time_budget)
        return true;
    }
    return length_limits_ && length_limits_->excess(this->particles().p) <= *spec_.tolerance;
  }

  const DesbrunSpec& spec_;
  Corrector corrector_;
  std::unique_ptr<Filter<R>> filter_;
  std::optional<SpringForces<Executor, R>> forces_;
  PointArray<Executor, R> force_, acceleration_;
  Array<Executor, R> mass_;
  std::vector<SystemBlock> free_blocks_;
  std::vector<std::vector<int>> filtered_pressures_;  // pressures of each product
  std::vector<int> plain_pressures_;
  Array<Executor, int> members_;
  std::optional<FilterCorrector<Executor, R>> filter_corrector_;
  std::optional<LengthLimits<Executor, R>> length_limits_;
  std::chrono::steady_clock::time_point substep_start_;
};

}  // namespace malha
