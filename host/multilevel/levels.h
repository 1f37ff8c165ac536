// SPDX-License-Identifier: Apache-2.0
// The coarser levels of a model in the executor's memory, and their part of a substep, between prediction and the
// finest sweep.
#pragma once
#include <chrono>
#include <deque>
#include <vector>

#include "host/base/point_array.h"
#include "host/model/levels.h"
#include "host/multilevel/mean_plan.h"
#include "host/patch/sweep.h"
#include "kernels/multilevel/restrict.h"

namespace malha {

template <class Executor, class R>
class Levels {
 public:
  /// `finest`: the sweep of the model. `fused`: the coarse correction is applied inside the patch solve (see
  /// prolongation()), otherwise in a pass before it. `islands`: the first particle of each connected body.
  /// `interactive`: both forms are prepared.
  Levels(const Executor& executor, const std::vector<Level>& levels, const Sweep<Executor, R>& finest, int threads,
         bool fused, const std::vector<int>& islands, bool interactive = false)
      : islands_(islands), origins_(islands.size()) {
    seconds_.assign(levels.size(), 0);
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const auto lay_out = [&](const auto& finer, TransferOperator* prolongation) {
        const std::vector<Patch> patches = finer.patches();
        const std::vector<Segment> segments = finer.segments();
        const auto goals =
            fused || l > 0 ? goals_by_patch(patches, segments) : goals_in_order(levels[l].prolongation, kPiece);
        const MeanPlan plan = plan_means(levels[l].prolongation, goals);
        *prolongation = TransferOperator(plan);
        levels_.emplace_back(executor, levels[l], plan_parts(levels[l].restriction, patches, segments),
                             plan.in_columns(), threads);
      };
      if (l == 0)
        lay_out(finest, &prolongation_);
      else
        lay_out(levels_[l - 1].sweep, &levels_[l - 1].prolongation);
    }
    if (fused && interactive)
      unfused_prolongation_ = TransferOperator(
          plan_means(levels.front().prolongation, goals_in_order(levels.front().prolongation, kPiece)));
  }

  /// The cycle of a substep: particles are restricted level by level to the coarsest, the levels are solved from there,
  /// each with the correction that is prolongated from the level before, and the last correction is prolongated to p.
  template <class Team>
  void apply_coarse_correction(const Team& team, const Sweep<Executor, R>& finest, const Particles<R>& all) const {
    restrict_patches(team, finest, {all.p, all.w, {}}, restriction());
    solve_restricted(team);
    const TransferOperator& transfer = unfused_prolongation_.bytes() > 0 ? unfused_prolongation_ : prolongation_;
    parallel_groups(team, 0, transfer.pieces(), {}, Prolongate<R>{transfer.from(levels_.front()), all.p.d});
  }

  /// The same cycle where patch solves do the finest level's part: the last solves of a substep restrict to
  /// restriction() what the next one predicts, and its first solves add prolongation(). solve_restricted() comes
  /// between them. Before the first substep of a step restrict_prediction() restricts in a pass.
  RestrictionTarget<R> restriction() const {
    RestrictionTarget<R> target = levels_.front().target();
    target.origins = origins_.points();
    return target;
  }
  template <class Team>
  void restrict_prediction(const Team& team, const Sweep<Executor, R>& finest, const SolvePatch<R>& solve) const {
    const Particles<R>& all = solve.particles;
    restrict_patches(team, finest, {all.p, all.w, FreeFall<R>{all.v, solve.dt, solve.gravity, solve.force}},
                     restriction());
  }
  template <class Team>
  void solve_restricted(const Team& team) const {
    LapTimer lap(is_leader(team) ? &seconds_ : nullptr);
    sum_parts(team, levels_.front());
    lap(0);
    for (std::size_t l = 1; l < levels_.size(); ++l) {
      const LevelData& finer = levels_[l - 1];
      restrict_patches(team, finer.sweep, {finer.restricted(), finer.w.data(), {}}, levels_[l].target());
      sum_parts(team, levels_[l]);
      lap(l);
    }
    for (std::size_t l = levels_.size(); l-- > 0;) {
      SolveCoarsePatch<R> solve = levels_[l].make_solve();
      if (l + 1 < levels_.size()) solve.prolongation = levels_[l].prolongation.from(levels_[l + 1]);
      levels_[l].sweep(team, solve);
      lap(l);
    }
  }
  ProlongationView<R> prolongation() const { return prolongation_.from(levels_.front()); }

  /// Sets the origins of bodies for a step, so that rounding is relative to the size of bodies, wherever they are.
  void set_origins(const Executor& executor, const Points<R>& x) const {
    parallel_for(executor, static_cast<int>(islands_.size()), SetOrigins<R>{x, islands_.data(), origins_.points()});
  }

  /// Time that the cycles took for each level, s.
  const std::vector<double>& seconds_of_each() const { return seconds_; }

  std::vector<LevelStats> facts() const {
    std::vector<LevelStats> all;
    for (const LevelData& own : levels_) {
      LevelStats& level = all.emplace_back();
      level.particles = static_cast<int>(own.rank.size()), level.patches = own.sweep.facts();
      for (const SetStats& set : own.sweep.set_facts()) level.constraints += set.constraints;
    }
    return all;
  }

  std::size_t bytes() const {
    std::size_t sum = prolongation_.bytes() + unfused_prolongation_.bytes();
    for (const LevelData& own : levels_) sum += own.bytes();
    return sum;
  }

 private:
  static constexpr int kPiece = 512;  // means

  /// Adds up the time of each level, on the leading thread.
  class LapTimer {
   public:
    explicit LapTimer(std::vector<double>* seconds) : seconds_(seconds) {
      if (seconds_) start_ = std::chrono::steady_clock::now();
    }
    void operator()(std::size_t level) {
      if (!seconds_) return;
      const auto now = std::chrono::steady_clock::now();
      (*seconds_)[level] += std::chrono::duration<double>(now - start_).count(), start_ = now;
    }

   private:
    std::vector<double>* seconds_;
    std::chrono::steady_clock::time_point start_;
  };

  struct LevelData;
  /// Restriction or prolongation in the executor's memory.
  struct TransferOperator {
    Array<Executor, int> begin;
    Array<Executor, MeanRun> runs;
    Array<Executor, MeanTerm<R>> terms;
    TransferOperator() = default;
    explicit TransferOperator(const MeanPlan& plan) : begin(plan.begin), runs(plan.runs) {
      std::vector<MeanTerm<R>> rounded;
      for (const MeanTerm<double>& term : plan.terms) rounded.push_back({term.from, R(term.weight)});
      terms = Array<Executor, MeanTerm<R>>(rounded);
    }
    int pieces() const { return static_cast<int>(begin.size()) - 1; }
    MeansView<R> view() const { return {begin.data(), runs.data(), terms.data()}; }
    /// The prolongation of a level's corrections.
    ProlongationView<R> from(const LevelData& level) const { return {view(), level.corrections()}; }
    std::size_t bytes() const { return begin.bytes() + runs.bytes() + terms.bytes(); }
  };

  struct LevelData {
    Sweep<Executor, R, KindList<Coarse>> sweep;
    PointArray<Executor, R> x, restricted_d;  // of the particles; behind them the partial sums of restriction
    PointArray<Executor, R> d;
    PointArray<Executor, R> columns;  // corrections of the particles, in columns or in rows: the other is empty
    ScatteredArray<Executor, R> rows;
    Array<Executor, R> w;
    Array<Executor, int> place, rank;            // place: particle of each mean; rank: mean of each particle
    TransferOperator restriction, prolongation;  // prolongation: from the next coarser level
    Array<Executor, int> summed, parts;

    LevelData(const Executor& executor, const Level& level, const MeanParts& means, bool in_columns, int threads)
        : sweep(executor, level.model, threads), d(level.model.x.size()), restriction(means.plan), parts(means.begin) {
      const std::size_t n = level.particle.size();
      std::vector<Vec3> places = level.model.x;
      std::vector<int> all = level.particle, ranks(n), at;
      for (int part = means.begin.front(); part < means.begin.back(); ++part) all.push_back(part), places.push_back({});
      for (std::size_t i = 0; i < n; ++i) ranks[level.particle[i]] = static_cast<int>(i);
      for (const int mean : means.mean) at.push_back(level.particle[mean]);
      std::vector<R> inverse(level.model.w.begin(), level.model.w.end());
      inverse.resize(n + kSlotPack);  // so that a pack that starts at the last particle reads inside the array
      x = PointArray<Executor, R>(places), restricted_d = PointArray<Executor, R>(places.size());
      if (in_columns)
        columns = PointArray<Executor, R>(n);
      else
        rows = ScatteredArray<Executor, R>(n);
      w = Array<Executor, R>(inverse);
      place = Array<Executor, int>(all), rank = Array<Executor, int>(ranks), summed = Array<Executor, int>(at);
    }
    Displaced<R> restricted() const { return {x.points(), restricted_d.points(), {}}; }
    RestrictionTarget<R> target() const {
      return {restriction.view(), place.data(), x.points(), restricted_d.points(), {}};
    }
    Corrections<R> corrections() const { return {columns.points(), rows.points()}; }
    SolveCoarsePatch<R> make_solve() const {
      return {sweep.data(), x.points(), restricted_d.points(), w.data(), d.points(), corrections(),
              rank.data(),  {},         Sweeps::Both};
    }
    std::size_t bytes() const {
      std::size_t sum = x.bytes() + restricted_d.bytes() + d.bytes() + columns.bytes() + rows.bytes() + w.bytes() +
                        place.bytes() + rank.bytes() + restriction.bytes() + prolongation.bytes() + summed.bytes() +
                        parts.bytes() + sweep.facts().bytes;
      for (const SetStats& set : sweep.set_facts()) sum += set.bytes;
      return sum;
    }
  };

  template <class Team, class Finer>
  static void restrict_patches(const Team& team, const Finer& finer, const RestrictedParticles<R>& particles,
                               const RestrictionTarget<R>& target) {
    finer.for_each_patch(team, Restrict<R>{finer.data(), particles, target});
  }
  /// Adds the partial sums of means whose particles lie in several patches.
  template <class Team>
  static void sum_parts(const Team& team, const LevelData& level) {
    const SumPartialRestrictions<R> add{level.summed.data(), level.parts.data(), level.x.points(),
                                        level.restricted_d.points()};
    parallel_pieces(team, static_cast<int>(level.summed.size()), kPiece, add);
  }

  Array<Executor, int> islands_;
  PointArray<Executor, R> origins_;  // of each, in a step
  std::deque<LevelData> levels_;
  mutable std::vector<double> seconds_;    // of each
  TransferOperator prolongation_;          // to the finest level: by patches if solves are fused, otherwise by pieces
  TransferOperator unfused_prolongation_;  // the same by pieces; empty unless both forms are prepared
};

}  // namespace malha
