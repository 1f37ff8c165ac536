// The springs of a model in the executor's memory, and the sums of their forces (kernels/springs.h).
#pragma once
#include <algorithm>
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
#include "kernels/springs.h"

namespace malha {

template <class Executor, class R>
class SpringForces {
 public:
  /// `load`: of each particle, what of its mass weighs in the forces, kg.
  SpringForces(const Executor& executor, int threads, const Model& model, const std::vector<double>& load)
      : executor_(executor), packs_((model.count() + kSpringPack - 1) / kSpringPack) {
    const std::size_t slots = kSpringPack * std::size_t(packs_);
    width_ = std::max(1, std::min(threads, model.count() / kGrain));
    std::vector<R> padded(load.begin(), load.end());
    padded.resize(slots);
    load_ = Array<Executor, R>(padded);
    const Vec4<R> zero{R(0), R(0), R(0), R(0)};
    now_ = Array<Executor, Vec4<R>>(slots, zero), ahead_ = Array<Executor, Vec4<R>>(slots, zero);
    lay_out(model);
    gravity_ = {R(model.scene.gravity[0]), R(model.scene.gravity[1]), R(model.scene.gravity[2])};
  }

  const R* load() const { return load_.data(); }

  /// Springs at x with their artificial viscosity, and the weight.
  void sum_explicit(const Particles<R>& particles, double h, const Points<R>& force) const {
    parallel_for(executor_, particles.count, SpringRows<R>{particles, R(h), now_.data(), ahead_.data()});
    sum(ExplicitForces<R>{view(), now_.data(), ahead_.data(), force});
  }
  /// What backward Euler still misses where the filtered accelerations lead to.
  void sum_missing(const Particles<R>& particles, double h, const Points<R>& acceleration, const R* mass,
                   const Points<R>& force) const {
    parallel_for(executor_, particles.count,
                 FilteredRows<R>{{particles, acceleration, load_.data(), R(h), gravity_}, now_.data()});
    sum(MissingForces<R>{view(), now_.data(), acceleration, mass, force});
  }

  std::size_t bytes() const {
    return begin_.bytes() + other_.bytes() + stiffness_.bytes() + rest_.bytes() + load_.bytes() + now_.bytes() +
           ahead_.bytes();
  }

 private:
  static constexpr int kGrain = 4096;  // particles that are worth a thread: some ten microseconds
  static constexpr int kGroup = 16;    // packs

  SpringView<R> view() const {
    return {begin_.data(), other_.data(), stiffness_.data(), rest_.data(), load_.data(), gravity_};
  }

  template <class Forces>
  void sum(const Forces& forces) const {
    parallel_region(executor_, width_, [&](const auto& team) {
      parallel_groups(team, 0, (packs_ + kGroup - 1) / kGroup, {}, SumForces<R, Forces>{forces, packs_, kGroup});
    });
  }

  void lay_out(const Model& model) {
    std::vector<int> springs(kSpringPack * std::size_t(packs_), 0), begin{0};
    const auto each_end = [&](const auto& visit) {
      for (const SpringSet& set : model.springs)
        for (std::size_t s = 0; s < set.ends.size(); ++s)
          for (const int e : {0, 1})
            if (model.w[set.ends[s][e]] > 0) visit(set, s, set.ends[s][e], set.ends[s][1 - e]);
    };
    each_end([&](const SpringSet&, std::size_t, int i, int) { ++springs[i]; });
    for (int pack = 0; pack < packs_; ++pack)
      begin.push_back(begin.back() +
                      *std::max_element(&springs[kSpringPack * pack], &springs[kSpringPack * pack] + kSpringPack));
    const std::size_t slots = kSpringPack * std::size_t(begin.back());
    std::vector<int> other(slots);
    std::vector<R> stiffness(slots, R(0)), rest(slots, R(0));
    for (int pack = 0; pack < packs_; ++pack)
      for (int slot = begin[pack]; slot < begin[pack + 1]; ++slot)
        for (int i = 0; i < kSpringPack; ++i) other[kSpringPack * slot + i] = (kSpringPack * pack + i) * kIndexScale<R>;
    std::fill(springs.begin(), springs.end(), 0);
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
  Array<Executor, R> stiffness_, rest_, load_;
  Array<Executor, Vec4<R>> now_, ahead_;
};

}  // namespace malha
