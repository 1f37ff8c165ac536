// SPDX-License-Identifier: Apache-2.0
// Broad phase of self-collision: the pairs that may come near in the next substeps, in the executor's memory: found by
// units, and worked on patch by patch, in phases of patches that share no particle.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "host/base/point_array.h"
#include "host/base/scratch_buffer.h"
#include "host/mesh/vectors.h"
#include "host/self_collision/clusters.h"
#include "host/self_collision/pair_index_memory.h"
#include "kernels/self_collision/swept_bounds.h"
#include "malha/error.h"

namespace malha {

/// Runs a kernel on the groups of a list.
template <class Kernel>
struct OfList {
  Kernel kernel;
  const int* list;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    kernel(group.at(list[group.index]));
  }
};
template <class Kernel>
inline constexpr bool kShared<OfList<Kernel>> = kShared<Kernel>;
template <class Kernel>
inline constexpr int kThreads<OfList<Kernel>> = kThreads<Kernel>;
template <class Kernel>
void note_launch(const OfList<Kernel>& list, int groups) {
  note_launch(list.kernel, groups);
}

template <class Executor, class R>
class PairSearch {
 public:
  /// `origin`: a place near x, m.
  PairSearch(const Executor& executor, const SelfSurface& surface, const std::vector<Vec3>& x, double thickness,
             const BroadPhaseParams<R>& rules, const Vec3& origin = {})
      : executor_(executor), rules_(rules), thickness_(R(thickness)), particles_(static_cast<int>(x.size())) {
    lay_out(plan_units(surface, x));
    std::vector<Vec4<R>> rest;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3 a = minus(x[i], origin);
      rest.push_back({R(a[0]), R(a[1]), R(a[2]), R(surface.body[i])});
    }
    rest.push_back({});
    rest_ = Array<Executor, Vec4<R>>(rest);
    from_ = Rows(x.size() + 1, Vec4<R>{}), way_ = Rows(x.size() + 1, Vec4<R>{});
    boxes_ = Array<Executor, Box<R>>(x.size(), Box<R>{});
    taken_ = Array<Executor, unsigned long long>(x.size() + 1, 0ull);
  }

  /// Searches for what the motions from x0 on may bring near, in a frame that moves by `common` in this substep, so
  /// many substeps ahead.
  void search(const Trajectories<R>& motions, const Vector3<R>& common, int ahead) {
    parallel_for(executor_, particles_, InitSweptBounds<R>{motions, common, R(ahead), rules_, reach()}, kGrain);
    search_again();
  }
  /// The same from where the last one started: finds the same.
  void search_again() {
    parallel_for(executor_, particles_, ComputeSweptAabbs<R>{reach(), rules_.min_distance, boxes_.data()}, kGrain);
    box_units();
    find();
    order();
  }
  SweptBounds<R> reach() const { return {from_.data(), way_.data(), rest_.data()}; }
  Pairs<R> pairs() const {
    return {patches_.data(), blocks_.data(), bits_.data(), touched_.data(), kIndexScale<R> * particles_};
  }
  int units() const { return units_.count; }

  std::int64_t found() const { return found_; }  // pairs
  std::int64_t candidates() const { return candidates_; }
  int phases() const { return static_cast<int>(phase_begin_.size()) - 1; }

  /// Runs work(team) on as many threads as the pairs can keep busy, with many launches over patches in it.
  template <class Work>
  void region(const Work& work) const {
    parallel_region(executor_, width_, work);
  }
  /// kernel(Group) for every patch with pairs, so that no two patches that share a particle are worked on at once.
  template <class Team, class Kernel>
  void in_phases(const Team& team, const Kernel& kernel) const {
    for (int phase = 0; phase < phases(); ++phase) in_phase(team, phase, kernel);
  }
  template <class Team, class Kernel>
  void in_phase(const Team& team, int phase, const Kernel& kernel) const {
    parallel_for_interleaved(team, phase_begin_[phase + 1] - phase_begin_[phase],
                             OfList<Kernel>{kernel, order_.data() + phase_begin_[phase]});
  }
  /// The same of all patches at once.
  template <class Kernel>
  void at_once(const Kernel& kernel) const {
    parallel_region(executor_, found_ < kPairGrain ? 1 : threads_of(executor_), [&](const auto& team) {
      parallel_for_interleaved(team, phase_begin_.back(), OfList<Kernel>{kernel, order_.data()});
    });
  }

  /// From now on no search finds pairs both sides of which have a particle where their bodies cross; empty: nowhere.
  void leave_out(const std::vector<CrossingBodies>& crosses) { crosses_ = Array<Executor, CrossingBodies>(crosses); }

  const CrossingBodies* crosses() const { return crosses_.data(); }

  /// From where the last search started, for checkpoints.
  const Array<Executor, Vec4<R>>& from() const { return from_; }
  const Array<Executor, Vec4<R>>& way() const { return way_; }
  void start_from(const std::vector<Vec4<R>>& from, const std::vector<Vec4<R>>& way) {
    from_.upload(from), way_.upload(way);
  }

  std::size_t bytes() const {
    return from_.bytes() + way_.bytes() + rest_.bytes() + boxes_.bytes() + patches_.bytes() + phase_.bytes() +
           order_.bytes() + bounds_.bytes() + items_.bytes() + bare_.bytes() + taken_.bytes() + places_.bytes() +
           touched_.bytes() + blocks_.bytes() + bits_.bytes() + crosses_.bytes();
  }

  static constexpr int kGrain = 8192;

 private:
  using Rows = Array<Executor, Vec4<R>>;

  void lay_out(const UnitPlan& plan) {
    std::vector<int> all;
    const auto place = [&](const std::vector<int>& list, bool particles) {
      const std::size_t begin = all.size();
      for (const int i : list) all.push_back(particles && i >= 0 ? kIndexScale<R> * i : i);
      return begin;
    };
    std::size_t begin[kItemKinds], corner[3], end[2];
    for (int kind = 0; kind < kItemKinds; ++kind) begin[kind] = place(plan.begin[kind], false);
    const std::size_t point = place(plan.point, true);
    for (int k = 0; k < 3; ++k) corner[k] = place(plan.corner[k], true);
    for (int k = 0; k < 2; ++k) end[k] = place(plan.end[k], true);
    items_ = Array<Executor, int>(all);
    bare_ = Array<Executor, unsigned char>(plan.wire_edge);
    units_.count = plan.units;
    for (int kind = 0; kind < kItemKinds; ++kind) units_.begin[kind] = items_.data() + begin[kind];
    units_.point = items_.data() + point;
    for (int k = 0; k < 3; ++k) units_.corner[k] = items_.data() + corner[k];
    for (int k = 0; k < 2; ++k) units_.end[k] = items_.data() + end[k];
    units_.wire_edge = bare_.data();
    units_.levels = static_cast<int>(plan.nodes.size());
    std::copy(plan.level.begin(), plan.level.end(), units_.level);
    std::copy(plan.nodes.begin(), plan.nodes.end(), units_.nodes);
    has_bare_ = std::find(plan.wire_edge.begin(), plan.wire_edge.end(), 1) != plan.wire_edge.end();

    std::size_t counts[2 * kItemKinds + 1], sum = 0;
    for (int kind = 0; kind < kItemKinds; ++kind) {
      counts[kind] = plan.begin[kind].back() + kBranch;
      counts[kItemKinds + kind] = plan.begin[kind].back() / kBranch + kBranch;
    }
    counts[2 * kItemKinds] = plan.level.back() + 2 * kBranch;
    for (const std::size_t count : counts) sum += 6 * count;
    bounds_ = Array<Executor, R>(sum, R(0));
    R* at = bounds_.data();
    const auto rows = [&](std::size_t count) {
      BoxRows<R> own;
      for (R*& bound : own.bound) bound = at, at += count;
      return own;
    };
    for (int kind = 0; kind < kItemKinds; ++kind) units_.item[kind] = rows(counts[kind]);
    for (int kind = 0; kind < kItemKinds; ++kind) units_.leaf[kind] = rows(counts[kItemKinds + kind]);
    units_.node = rows(counts[2 * kItemKinds]);

    patches_ = Array<Executor, PairPatch>(plan.units, PairPatch{});
    if (!Memory<Executor>::kOnHost) {  // which lists particles where there is room for them alone
      std::vector<PairPatch> patches(plan.units);
      for (PairPatch& patch : patches) patch.touches = kListed;
      make_room(patches);
    }
    phase_ = Array<Executor, int>(plan.units, 0), order_ = Array<Executor, int>(plan.units, 0);
  }

  void box_units() {
    parallel_for(executor_, units_.count, RefitLeaves<R>{units_, boxes_.data()}, kUnitGrain);
    for (int level = 1; level < units_.levels; ++level)
      parallel_for(executor_, units_.nodes[level], RefitLevel<R>{units_, level});
  }

  /// Into the room that the last search needed and a quarter more; where that is too little, again.
  void find() {
    const int threads = std::clamp(units_.count / kUnitsOfThread, 1, threads_of(executor_));
    do {
      places_.make_room(particles_, threads, touched_.size());
      const typename SearchPlaces<Executor>::template Find<R> find{
          {units_, reach(), thickness_, has_bare_, crosses_.data(), pairs()}, places_.places()};
      parallel_region(executor_, threads, [&](const auto& team) {
        parallel_for_interleaved(team, units_.count, find, places_.template memory<R>());
      });
    } while (!fits());
  }

  /// Whether there was room for all; else there is more now.
  bool fits() {
    std::vector<PairPatch> patches = patches_.download();
    bool fits = true;
    found_ = candidates_ = 0;
    for (const PairPatch& patch : patches) {
      fits = fits && patch.all() <= patch.capacity && patch.touches <= patch.room;
      found_ += patch.pairs, candidates_ += patch.candidates;
    }
    if (!fits) make_room(patches);
    return fits;
  }
  /// For a quarter more than patches have.
  void make_room(std::vector<PairPatch>& patches) {
    std::size_t blocks = 0, listed = 0;
    for (PairPatch& patch : patches) {
      patch.begin = static_cast<int>(blocks), patch.touched = static_cast<int>(listed);
      patch.capacity = patch.all() + patch.all() / 4 + 1, patch.room = patch.touches + patch.touches / 4 + kPairBlock;
      blocks += patch.capacity, listed += patch.room;
      if (blocks > kMostBlocks)
        throw OutOfMemory("self-collision: found more than " + std::to_string(kMostBlocks * kPairBlock) +
                          " pairs that may come near; allowed: fewer; take a smaller thickness, or smaller steps");
    }
    patches_.upload(patches);
    if (blocks > bits_.size()) {
      if (bits_.size() > 0) blocks += blocks / 4;  // it has grown before, and may again in a jam
      blocks_ = {}, bits_ = {};
      blocks_ = Array<Executor, ContactBlock<R>>(blocks), bits_ = Array<Executor, PairBits>(blocks);
    }
    if (listed > touched_.size()) touched_ = {}, touched_ = Array<Executor, int>(listed);
  }

  void order() {
    parallel_for(executor_, 1,
                 ColorPatches{patches_.data(), touched_.data(), units_.count, taken_.data(), phase_.data()});
    const std::vector<int> phase = phase_.download();
    std::vector<int> order;
    for (int u = 0; u < units_.count; ++u)
      if (phase[u] >= 0) order.push_back(u);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return phase[a] < phase[b]; });
    phase_begin_ = {0};
    for (std::size_t k = 0; k < order.size(); ++k)
      if (k + 1 == order.size() || phase[order[k + 1]] != phase[order[k]])
        phase_begin_.push_back(static_cast<int>(k) + 1);
    const int patches = phase_begin_.back();
    order.resize(units_.count, 0);
    order_.upload(order);
    width_ = found_ < kPairGrain ? 1 : std::max(1, patches / std::max(1, 2 * phases()));
  }

  static constexpr int kUnitGrain = 16, kUnitsOfThread = 2;  // to box, and to find the pairs of
  static constexpr std::int64_t kPairGrain = 8'000;          // a hundred microseconds of work
  static constexpr int kListed = 256;                        // particles of a unit, before more were found
  static constexpr std::size_t kMostBlocks = 2147483647 / kPairBlock;

  Executor executor_;
  BroadPhaseParams<R> rules_;
  R thickness_;
  int particles_;
  ClusterBvh<R> units_{};
  bool has_bare_ = false;
  Array<Executor, int> items_;
  Array<Executor, unsigned char> bare_;
  Array<Executor, R> bounds_;
  Rows rest_, from_, way_;
  Array<Executor, Box<R>> boxes_;
  Array<Executor, unsigned long long> taken_;
  SearchPlaces<Executor> places_;
  Array<Executor, PairPatch> patches_;
  Array<Executor, int> phase_, order_, touched_;
  Array<Executor, ContactBlock<R>> blocks_;
  Array<Executor, PairBits> bits_;
  Array<Executor, CrossingBodies> crosses_;
  std::vector<int> phase_begin_{0};
  std::int64_t found_ = 0, candidates_ = 0;
  int width_ = 1;
};

}  // namespace malha
