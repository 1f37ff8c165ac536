// SPDX-License-Identifier: Apache-2.0
// Bending through a prefactored filter within PBD. The energy of quadratic bending (Bergou et al. 2006) has a constant
// Hessian Q, so that one linear solve of (M + h^2 Q) p' = M p + h^2 b after the prediction is backward Euler of bending
// alone, at every stiffness and resolution: stretch, pressure and contacts are projected afterwards. It is Desbrun's
// filter (Desbrun, Schröder, Barr 1999, section 3.2) in the place where it is exact.
//
// b pulls hinges that are curved at rest to their fold at rest, along their normals at the start of the substep, which
// are turned with the body as a whole: without that its rotation would be damped. Shells that are folded too sharply
// for their stiffness gain energy on impact (kMostTurning, host/model/softening.h), with normals of the prediction too.
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "host/filter/corrector.h"
#include "host/filter/filter.h"
#include "host/filter/spring_forces.h"

namespace malha {

template <class Executor, class R>
class BendingFilter {
 public:
  /// `w`: the present inverse masses, 1/kg, in the solver's order. `h`: the substep, s. `threads`: number of threads of
  /// the executor.
  BendingFilter(const Executor& executor, int threads, const Model& model, const std::vector<double>& w, double h,
                const ShowProgress& progress)
      : executor_(executor),
        model_(model),
        threads_(threads),
        h_(h),
        forces_(executor, threads, model, std::vector<double>(model.x.size(), 0)),
        impulse_(model.x.size()) {
    factor(w, progress);
  }

  /// Factors the system of other inverse masses, after particles were pinned or released.
  void factor(const std::vector<double>& w, const ShowProgress& progress) {
    const SpringSystem system = spring_system(model_, h_, w);
    filter_ = make_filter<Executor, R>(executor_, threads_, model_, system, progress);
    free_blocks_.clear(), turned_blocks_.clear();
    for (const SystemBlock& block : system.blocks)
      if (block.free) free_blocks_.push_back(block);
    if (forces_.has_targets()) {
      turned_blocks_ = system.blocks;
      forces_.set_blocks(blocks_of(system));
      motions_ = Array<Executor, NetMotion>(system.blocks.size(), NetMotion{});
      rotations_ = Array<Executor, Vec4<R>>(system.blocks.size(), Vec4<R>{R(0), R(0), R(0), R(0)});
    }
    if (free_blocks_.empty() && turned_blocks_.empty()) return;
    members_ = Array<Executor, int>(system.particle);
    correction_ = PointArray<Executor, R>(free_blocks_.empty() ? 0 : model_.x.size());
    if (!corrector_) corrector_.emplace(executor_);
  }

  /// Moves the predicted particles: p' = p + S h^2 (b - Q p). Bodies without pins keep their momenta.
  void apply(const Particles<R>& all) const {
    const Points<R> impulse = impulse_.points();
    measure_rotations(all);
    forces_.sum_stencils(all, h_, rotations_.data(), impulse);
    if (free_blocks_.empty()) return filter_->apply({impulse, all.p.d, true});
    const Points<R> correction = correction_.points();
    filter_->apply({impulse, correction, false});
    for (const SystemBlock& block : free_blocks_)
      corrector_->correct({all.x, correction, all.w, members_.data() + block.first}, block.count, Corrector::Inertia);
    parallel_for(executor_, all.count, AddDisplacement<R>{all, correction});
  }

  const FilterStats& facts() const { return filter_->facts(); }
  const Filter<R>& filter() const { return *filter_; }
  int free_bodies() const { return static_cast<int>(free_blocks_.size()); }
  std::size_t force_bytes() const { return forces_.bytes(); }
  /// Launches in a substep.
  std::size_t launches() const {
    const std::size_t free = free_blocks_.size(), turned = turned_blocks_.size();
    return forces_.launches() + filter_->facts().launches + (turned > 0 ? 4 * turned + 1 : 0) +
           (free > 0 ? 5 * free + 1 : 0);
  }
  std::size_t particle_bytes() const {
    return impulse_.bytes() + members_.bytes() + correction_.bytes() + motions_.bytes() + rotations_.bytes();
  }

 private:
  /// The block of each particle, or -1.
  std::vector<int> blocks_of(const SpringSystem& system) const {
    std::vector<int> of(model_.x.size(), -1);
    for (std::size_t b = 0; b < system.blocks.size(); ++b)
      for (int i = system.blocks[b].first; i < system.blocks[b].first + system.blocks[b].count; ++i)
        of[system.particle[i]] = static_cast<int>(b);
    return of;
  }

  /// Measures the rotation of each block in the predicted motion.
  void measure_rotations(const Particles<R>& all) const {
    if (turned_blocks_.empty()) return;
    for (std::size_t b = 0; b < turned_blocks_.size(); ++b)
      corrector_->measure({all.x, all.p.d, all.w, members_.data() + turned_blocks_[b].first}, turned_blocks_[b].count,
                          Corrector::Inertia, motions_.data() + b);
    parallel_for(executor_, static_cast<int>(turned_blocks_.size()),
                 StoreRotation<R>{motions_.data(), rotations_.data()});
  }

  Executor executor_;
  const Model& model_;
  int threads_;
  double h_;
  SpringForces<Executor, R> forces_;
  PointArray<Executor, R> impulse_;
  std::unique_ptr<Filter<R>> filter_;
  std::vector<SystemBlock> free_blocks_, turned_blocks_;  // without pins; with targets that turn
  Array<Executor, int> members_;
  PointArray<Executor, R> correction_;  // of free blocks, m
  Array<Executor, NetMotion> motions_;  // predicted for each block
  Array<Executor, Vec4<R>> rotations_;  // of these, rad
  mutable std::optional<FilterCorrector<Executor, R>> corrector_;
};

}  // namespace malha
