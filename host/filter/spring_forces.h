// SPDX-License-Identifier: Apache-2.0
// The springs and stencils of a model in the executor's memory, and the sums of their forces
// (kernels/filter/springs.h).
#pragma once
#include <algorithm>
#include <vector>

#include "host/base/array.h"
#include "host/filter/system.h"
#include "host/model/stencils.h"
#include "kernels/filter/springs.h"
#include "kernels/simd/rows.h"

namespace malha {

template <class Executor, class R>
class SpringForces {
 public:
  /// `filtered_mass`: mass of each particle whose weight is part of the forces, otherwise 0, kg.
  SpringForces(const Executor& executor, int threads, const Model& model, const std::vector<double>& filtered_mass)
      : executor_(executor), packs_((model.count() + kSpringPack - 1) / kSpringPack) {
    const std::size_t slots = kSpringPack * std::size_t(packs_);
    width_ = std::max(1, std::min(threads, model.count() / kGrain));
    std::vector<R> padded(filtered_mass.begin(), filtered_mass.end());
    padded.resize(slots);
    filtered_mass_ = Array<Executor, R>(padded);
    const Vec4<R> zero{R(0), R(0), R(0), R(0)};
    now_ = Array<Executor, Vec4<R>>(slots, zero), ahead_ = Array<Executor, Vec4<R>>(slots, zero);
    lay_out(model);
    lay_out_targets(model);
    set_gravity(model.scene.gravity);
  }

  void set_gravity(const Vec3& gravity) { gravity_ = {R(gravity[0]), R(gravity[1]), R(gravity[2])}; }

  const R* filtered_mass() const { return filtered_mass_.data(); }

  /// Sums the forces of springs at x, with their artificial viscosity, and the weight.
  void sum_explicit(const Particles<R>& particles, double h, const Points<R>& force) const {
    parallel_for(executor_, particles.count, SpringRows<R>{particles, R(h), now_.data(), ahead_.data()});
    find_targets(now_.data());
    sum(ExplicitForces<R>{view(), now_.data(), ahead_.data(), force});
  }
  /// Computes the residual of backward Euler at the positions to which the filtered accelerations lead.
  void sum_missing(const Particles<R>& particles, double h, const Points<R>& acceleration, const R* mass,
                   const Points<R>& force) const {
    parallel_for(executor_, particles.count,
                 FilteredRows<R>{{particles, acceleration, filtered_mass_.data(), R(h), gravity_}, now_.data()});
    find_targets(now_.data());
    sum(MissingForces<R>{view(), now_.data(), acceleration, mass, force});
  }

  /// Computes h^2 F of the stencils at the predicted positions. Their targets are those of the start of the substep,
  /// turned by the rotation of their block (rad).
  void sum_stencils(const Particles<R>& particles, double h, const Vec4<R>* rotations, const Points<R>& impulse) const {
    parallel_for(executor_, particles.count, OffsetRows<R>{particles, now_.data(), ahead_.data()});
    find_turned_targets(rotations);
    sum(LinearImpulses<R>{view(), now_.data(), ahead_.data(), R(h * h), impulse});
  }
  bool has_targets() const { return !targets_.empty(); }

  /// Notes the block of each constraint with a target, from that of each particle (-1: none).
  void set_blocks(const std::vector<int>& block_of) {
    for (Targets& own : targets_) {
      const std::vector<int> particle = own.particle.download();
      const std::size_t n = particle.size() / own.count;
      std::vector<int> block(own.count, 0);
      for (std::size_t k = 0; k < particle.size(); ++k)
        block[k / n] = std::max(block[k / n], block_of[particle[k] / kIndexScale<R>]);
      own.block = Array<Executor, int>(block);
    }
  }

  std::size_t bytes() const {
    std::size_t sum = begin_.bytes() + other_.bytes() + stiffness_.bytes() + rest_.bytes() + filtered_mass_.bytes() +
                      now_.bytes() + ahead_.bytes() + rows_.bytes() + pull_begin_.bytes() + pull_row_.bytes() +
                      pull_weight_.bytes();
    for (const Targets& set : targets_)
      sum += set.particle.bytes() + set.block.bytes() + set.weight.bytes() + set.own.bytes() + set.stiffness.bytes();
    return sum;
  }
  /// Launches of one sum of forces.
  std::size_t launches() const { return 2 + targets_.size(); }

 private:
  static constexpr int kGrain = 4096;  // particles per thread at least, some ten microseconds
  static constexpr int kGroup = 16;    // packs

  /// Targets of one set of stencils.
  struct Targets {
    const ConstraintSet* set;
    int count, first_row;
    Array<Executor, int> particle, block;
    Array<Executor, R> weight, own, stiffness;
  };

  SpringView<R> view() const {
    return {begin_.data(), other_.data(), stiffness_.data(), rest_.data(), filtered_mass_.data(), gravity_};
  }

  template <class Forces>
  void sum(const Forces& forces) const {
    if (targets_.empty()) return sum<false>(forces);
    sum<true>(forces);
  }
  template <bool has_targets, class Forces>
  void sum(const Forces& forces) const {
    const PullView<R> pulls{pull_begin_.data(), pull_row_.data(), pull_weight_.data(), rows_.data()};
    parallel_region(executor_, width_, [&](const auto& team) {
      parallel_groups(team, 0, (packs_ + kGroup - 1) / kGroup, {},
                      SumForces<R, Forces, has_targets>{forces, pulls, packs_, kGroup});
    });
  }

  void find_targets(Vec4<R>* at) const {
    for (const Targets& own : targets_)
      with_stencil(*own.set, [&]<class Kind, class Stencil>(Kind, Stencil) {
        parallel_for(executor_, own.count, ComputeTargets<R, Stencil, Kind::particles>{view_of(own), at});
      });
  }
  void find_turned_targets(const Vec4<R>* rotations) const {
    for (const Targets& own : targets_)
      with_stencil(*own.set, [&]<class Kind, class Stencil>(Kind, Stencil) {
        if constexpr (bends<Kind>())
          parallel_for(executor_, own.count,
                       ComputeTurnedTargets<R, Stencil, Kind::particles>{view_of(own), now_.data(), own.block.data(),
                                                                         rotations});
      });
  }
  TargetView<R> view_of(const Targets& own) const {
    return {own.particle.data(), own.weight.data(), own.own.data(), own.stiffness.data(), rows_.data() + own.first_row};
  }

  /// First slot of each pack, which has as many as its particle with the most.
  std::vector<int> begin_of_packs(const std::vector<int>& slots) const {
    std::vector<int> begin{0};
    for (int pack = 0; pack < packs_; ++pack)
      begin.push_back(begin.back() +
                      *std::max_element(&slots[kSpringPack * pack], &slots[kSpringPack * pack] + kSpringPack));
    return begin;
  }

  void lay_out_targets(const Model& model) {
    struct Pull {
      int particle, row;
      double weight;
    };
    std::vector<Pull> pulls;
    int rows = 0;
    for (const ConstraintSet& set : model.stencils)
      with_stencil(set, [&]<class Kind, class Stencil>(Kind, Stencil) {
        std::vector<int> particle;
        std::vector<R> weight, own, stiffness;
        const int first = rows;
        for (int c = 0; c < set.count(); ++c) {
          const StencilOf<Kind> one = stencil_of<Kind>(model, set, c);
          if (std::ranges::all_of(one.own, [](double a) { return a == 0; })) continue;
          for (int j = 0; j < one.n; ++j) particle.push_back(one.particles[j] * kIndexScale<R>);
          for (int k = 0; k < Stencil::vectors; ++k)
            for (int j = 0; j < one.n; ++j) {
              weight.push_back(R(one.weights[k][j]));
              if (model.w[one.particles[j]] > 0) pulls.push_back({one.particles[j], rows + k, one.weights[k][j]});
            }
          own.insert(own.end(), std::begin(one.own), std::end(one.own));
          stiffness.push_back(R(1 / one.alpha));
          rows += Stencil::vectors;
        }
        if (!stiffness.empty())
          targets_.push_back({&set,
                              static_cast<int>(stiffness.size()),
                              first,
                              Array<Executor, int>(particle),
                              {},
                              Array<Executor, R>(weight),
                              Array<Executor, R>(own),
                              Array<Executor, R>(stiffness)});
      });
    if (targets_.empty()) return;
    std::vector<int> slots(kSpringPack * std::size_t(packs_), 0);
    for (const Pull& pull : pulls) ++slots[pull.particle];
    const std::vector<int> begin = begin_of_packs(slots);
    std::vector<int> row(kSpringPack * std::size_t(begin.back()), 0);
    std::vector<R> weight(row.size(), R(0));
    std::ranges::fill(slots, 0);
    for (const Pull& pull : pulls) {
      const int pack = pull.particle / kSpringPack;
      const int at = kSpringPack * (begin[pack] + slots[pull.particle]++) + pull.particle % kSpringPack;
      row[at] = pull.row * kIndexScale<R>, weight[at] = R(pull.weight);
    }
    rows_ = Array<Executor, Vec4<R>>(rows, Vec4<R>{R(0), R(0), R(0), R(0)});
    pull_begin_ = Array<Executor, int>(begin), pull_row_ = Array<Executor, int>(row);
    pull_weight_ = Array<Executor, R>(weight);
  }

  void lay_out(const Model& model) {
    std::vector<int> springs(kSpringPack * std::size_t(packs_), 0);
    const SpringSet linear = linear_part(model);
    const auto each_end = [&](const auto& visit) {
      const auto visit_set = [&](const SpringSet& set) {
        for (std::size_t s = 0; s < set.ends.size(); ++s)
          for (const int e : {0, 1})
            if (model.w[set.ends[s][e]] > 0) visit(set, s, set.ends[s][e], set.ends[s][1 - e]);
      };
      std::ranges::for_each(model.springs, visit_set);
      visit_set(linear);
    };
    each_end([&](const SpringSet&, std::size_t, int i, int) { ++springs[i]; });
    const std::vector<int> begin = begin_of_packs(springs);
    const std::size_t slots = kSpringPack * std::size_t(begin.back());
    std::vector<int> other(slots);
    std::vector<R> stiffness(slots, R(0)), rest(slots, R(0));
    for (int pack = 0; pack < packs_; ++pack)
      for (int slot = begin[pack]; slot < begin[pack + 1]; ++slot)
        for (int i = 0; i < kSpringPack; ++i) other[kSpringPack * slot + i] = (kSpringPack * pack + i) * kIndexScale<R>;
    std::ranges::fill(springs, 0);
    each_end([&](const SpringSet& set, std::size_t s, int i, int j) {
      const int at = kSpringPack * (begin[i / kSpringPack] + springs[i]++) + i % kSpringPack;
      other[at] = j * kIndexScale<R>, stiffness[at] = R(set.stiffness[s]), rest[at] = R(set.rest[s]);
    });
    begin_ = Array<Executor, int>(begin), other_ = Array<Executor, int>(other);
    stiffness_ = Array<Executor, R>(stiffness), rest_ = Array<Executor, R>(rest);
  }

  Executor executor_;
  int packs_, width_ = 1;
  Vector3<R> gravity_{};
  Array<Executor, int> begin_, other_;
  Array<Executor, R> stiffness_, rest_, filtered_mass_;
  Array<Executor, Vec4<R>> now_, ahead_, rows_;
  std::vector<Targets> targets_;
  Array<Executor, int> pull_begin_, pull_row_;
  Array<Executor, R> pull_weight_;
};

}  // namespace malha
