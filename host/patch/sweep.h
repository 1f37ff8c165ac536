// SPDX-License-Identifier: Apache-2.0
// The constraints of a model in the executor's memory, and symmetric Gauss-Seidel sweeps over them, colour by colour.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/base/array.h"
#include "host/base/launch_graph.h"
#include "host/base/stopwatch.h"
#include "host/measure/solver_stats.h"
#include "host/patch/patch_plan.h"
#include "host/patch/solve_patches.h"
#include "host/projection/rest_values.h"
#include "host/projection/stiffness.h"
#include "kernels/projection/rest.h"

namespace malha {

template <class Executor, class R, class Kinds = ConstraintKinds>
class Sweep {
 public:
  Sweep(const Executor& executor, const Model& model, int threads) : executor_(executor) {
    PatchPlan plan;
    facts_.plan_seconds = seconds([&] { plan = plan_patches(model, on_host(executor)); });
    patches_ = Array<Executor, Patch>(plan.patches);
    segments_ = Array<Executor, Segment>(plan.segments);
    colour_begin_ = plan.colour_begin;
    order_ = sweep_order(plan.colours());
    width_ = plan.width();
    std::vector<SetView<R>> views;
    sets_.resize(model.sets.size());
    for (std::size_t s = 0; s < sets_.size(); ++s) views.push_back(lay_out(model, static_cast<int>(s), plan, sets_[s]));
    batches_ = Array<Executor, Batch>(plan.batches);
    views_ = Array<Executor, SetView<R>>(views);
    non_finite_ = Array<Executor, int>(plan.patches.size(), 0);
    // The memory of a thread is whole cache lines, and those of two threads do not map to the same set of a cache.
    const std::size_t numbers =
        kNumbersPerParticle * std::size_t(plan.most_slots) + (stores_distance(Kinds{}) ? plan.most_constraints : 0);
    memory_bytes_ = (numbers * sizeof(R) / 128 + 1) * 128 + 64;
    memory_ = Array<Executor, char>(memory_bytes_ * threads, 0);
    data_ = {patches_.data(), segments_.data(), batches_.data(), views_.data(),
             model.x.size() * 10 * sizeof(R) > kCache};
    note_facts(model, plan);
  }

  /// Runs work(team), which may do many sweeps, on as many threads as the patches can keep busy.
  template <class Work>
  void region(const Work& work) const {
    parallel_region(executor_, width_, work);
  }

  /// The same, for launches that depend on key() alone and are recorded.
  template <class Key, class Work>
  void region(Recording<Executor>& recording, const Key& key, const Work& work) const {
    repeated_region(executor_, width_, recording, key, work);
  }

  const PatchData<R>& data() const { return data_; }

  /// Runs a kernel on every patch once, in any order.
  template <class Team, class Kernel>
  void for_each_patch(const Team& team, const Kernel& kernel) const {
    parallel_groups(team, 0, static_cast<int>(patches_.size()), {memory_.data(), memory_bytes_}, kernel);
  }

  /// A solve of a further iteration, that does not update the state.
  SolvePatch<R> make_solve(const Particles<R>& particles, double h, const Vector3<R>& gravity) const {
    return {data_, particles, R(h), R(1 / h), gravity, {}, {}, Sweeps::Both};
  }
  /// The state update of a substep, counted from 1.
  PatchUpdate<R> make_update(int substep) const { return {substep, non_finite_.data(), {}, {}}; }

  /// One iteration: every constraint in a forward and a backward sweep.
  template <class Team, class Solve>
  void operator()(const Team& team, Solve solve) const {
    for (const ColourSweep& launch : order_) {
      solve.sweeps = launch.sweeps;
      solve_patches(team, solve, colour_begin_[launch.colour], colour_begin_[launch.colour + 1],
                    {memory_.data(), memory_bytes_});
    }
  }

  /// The lowest user index of the particles without a finite position x in the patches where one appeared first; -1:
  /// none.
  int first_non_finite(const std::vector<Vec3>& x, const std::vector<int>& user_index) const {
    const std::vector<int> non_finite = non_finite_.download();
    int substep = 0, found = -1;
    for (const int when : non_finite)
      if (when > 0 && (substep == 0 || when < substep)) substep = when;
    if (substep == 0) return -1;
    const std::vector<Patch> patches = patches_.download();
    const std::vector<Segment> segments = segments_.download();
    for (std::size_t k = 0; k < patches.size(); ++k) {
      if (non_finite[k] != substep) continue;
      for (int s = patches[k].segment; s < patches[k].segment + patches[k].segments; ++s)
        for (int i = segments[s].global; i < segments[s].global + segments[s].count; ++i) {
          const R sum =
              R(x[i][0]) + R(x[i][1]) + R(x[i][2]);  // the solves test this sum too: finite coordinates may overflow
          if (!std::isfinite(sum) && (found < 0 || user_index[i] < found)) found = user_index[i];
        }
    }
    return found;
  }
  bool has_non_finite() const {
    return std::ranges::any_of(non_finite_.on_host(staging_), [](int substep) { return substep > 0; });
  }

  void clear_non_finite() { non_finite_.upload(std::vector<int>(non_finite_.size(), 0)); }

  /// Allocates memory for speed limits.
  void allocate_speed_limit() { too_fast_ = Array<Executor, int>(2 * patches_.size(), 0); }
  void start_speed_limit() { Memory<Executor>::fill(too_fast_.data(), too_fast_.size(), 0); }
  /// A limit of `speed` (m/s) for a substep, counted from 1.
  SpeedLimit<R> speed_limit(double speed, int substep) const { return {R(speed) * R(speed), speed_buffer(substep)}; }
  bool speed_exceeded(int substep) const {
    return Memory<Executor>::has(speed_buffer(substep), patches_.size(), substep);
  }

  std::vector<Patch> patches() const { return patches_.download(); }
  std::vector<Segment> segments() const { return segments_.download(); }
  int width() const { return width_; }

  const PatchStats& facts() const { return facts_; }
  const std::vector<SetStats>& set_facts() const { return set_facts_; }

 private:
  /// Substeps alternate between two buffers: one is read while the next substep runs.
  int* speed_buffer(int substep) const { return too_fast_.data() + (substep % 2) * patches_.size(); }

  static constexpr std::size_t kCache = 1 << 20;  // bytes; cores have caches of 0.25 to 2 MiB of their own
  struct Set {
    Array<Executor, LocalIndex> index[kMostParticles];
    Array<Executor, R> rest, common, lambda;
    Array<Executor, unsigned short> valid;
    std::size_t bytes() const {
      std::size_t sum = rest.bytes() + common.bytes() + valid.bytes() + lambda.bytes();
      for (const auto& of : index) sum += of.bytes();
      return sum;
    }
  };

  SetView<R> lay_out(const Model& model, int s, PatchPlan& patches, Set& own) const {
    const ConstraintSet& set = model.sets[s];
    const SetPlan& plan = patches.sets[s];
    const SolverSpec& solver = model.scene.solver;
    const double h = solver.dt / solver.substeps;
    SetView<R> view{};
    std::size_t multipliers = 1;
    with_kind(
        set.type,
        [&]<class Kind>(Kind) {
          view.kind = kind_index<Projected<Kind>>(Kinds{});
          multipliers = malha::multipliers<Kind>();
          view.update = update_of<Kind>(set, solver.iterations);
          view.rest_values = rest_value_count<Kind>(view.update);
          RestValues<R> rest(rest_by_slot<Kind>(model, set, plan), view.rest_values, s, patches.batches);
          own.rest = Array<Executor, R>(rest.each), own.common = Array<Executor, R>(rest.common);
          own.valid = Array<Executor, unsigned short>(rest.valid);
        },
        Kinds{});
    for (int j = 0; j < set.arity; ++j) {
      own.index[j] = Array<Executor, LocalIndex>(scaled(plan.index[j]));
      view.index[j] = own.index[j].data();
    }
    if (view.update != Update::Stiff) own.lambda = Array<Executor, R>(plan.constraint.size() * multipliers, R(0));
    view.rest = own.rest.data(), view.common = own.common.data(), view.valid = own.valid.data();
    view.lambda = own.lambda.data();
    view.stiffness = R(stiffness_per_projection(set.stiffness, solver, kSweepsPerIteration));
    view.compliance = R(set.compliance.value_or(0) / (h * h));
    // With more iterations than substeps, the heavy loads of a long substep converge faster along current gradients.
    view.from_start = solver.iterations <= solver.substeps,
    view.max_start_step = R(max_start_step_of(set.pressed, solver.iterations));
    view.max_compressed_start_step = R(max_compressed_start_step_of(set.pressed, solver.iterations));
    view.per_closing = R(set.per_closing);
    return view;
  }

  static std::vector<LocalIndex> scaled(std::vector<LocalIndex> index) {
    for (LocalIndex& i : index) i = static_cast<LocalIndex>(i * kIndexScale<R>);
    return index;
  }

  /// One of the updates that SolvePatch instantiates for the kind.
  template <class Kind>
  static Update update_of(const ConstraintSet& set, int iterations) {
    if (needs_material<Kind>() || !set.softness.empty()) return Update::Material;
    if (!Kind::strength.accepts_stiffness) return Update::Compliant;
    // With several iterations each needs the total that was applied (kMaxStartStep, kernels/projection/direction.h): a
    // compliance of 0 is the same as a stiffness of 1. Coarse constraints are swept once in a substep, whatever the
    // iterations.
    const bool hard = iterations > 1 && !stores_distance(KindList<Kind>{}) && set.stiffness == 1;
    return set.compliance || hard ? Update::Compliant : Update::Stiff;
  }

  /// Rest values are computed in double and rounded once.
  template <class Kind>
  std::vector<R> rest_by_slot(const Model& model, const ConstraintSet& set, const SetPlan& plan) const {
    const std::size_t count = rest_value_count<Kind>(update_of<Kind>(set, model.scene.solver.iterations));
    std::vector<R> rest(plan.constraint.size() * count, std::numeric_limits<R>::quiet_NaN());
    const auto measure = [&](int slot) {
      const int c = plan.constraint[slot];
      if (c < 0) return;
      double own[Kind::rest_values];
      if constexpr (stores_distance(KindList<Kind>()))
        own[0] = set.rest[c];
      else
        rest_values<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c), own);
      R* to = &rest[slot * count];
      std::copy(own, own + Kind::rest_values, to);
      if (int(count) > Kind::rest_values) to[Kind::rest_values] = R(set.softness.empty() ? 1 : set.softness[c]);
    };
    parallel_for(on_host(executor_), static_cast<int>(plan.constraint.size()), measure);
    return rest;
  }

  void note_facts(const Model& model, const PatchPlan& plan) {
    facts_.patches = static_cast<int>(plan.patches.size()), facts_.colours = plan.colours();
    facts_.columns = plan.columns, facts_.shared = plan.shared, facts_.most_slots = plan.most_slots;
    facts_.memory_bytes = memory_bytes_;
    facts_.bytes =
        plan.bytes() + colour_begin_.size() * sizeof(int) + views_.bytes() + non_finite_.bytes() + memory_.bytes();
    for (std::size_t s = 0; s < sets_.size(); ++s) {
      const ConstraintSet& set = model.sets[s];
      set_facts_.push_back({set.type, set.count(), plan.sets[s].in_runs, plan.sets[s].most_batches, sets_[s].bytes()});
    }
  }

  Executor executor_;
  Array<Executor, Patch> patches_;
  Array<Executor, Segment> segments_;
  Array<Executor, Batch> batches_;
  Array<Executor, SetView<R>> views_;
  std::vector<Set> sets_;
  Array<Executor, int> non_finite_, too_fast_;
  mutable std::vector<int> staging_;  // non_finite_ of a device
  Array<Executor, char> memory_;
  std::size_t memory_bytes_ = 0;
  std::vector<int> colour_begin_;
  std::vector<ColourSweep> order_;
  int width_ = 1;
  PatchData<R> data_{};
  PatchStats facts_;
  std::vector<SetStats> set_facts_;
};

}  // namespace malha
