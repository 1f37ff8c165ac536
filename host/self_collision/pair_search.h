// SPDX-License-Identifier: Apache-2.0
// Broad phase of self-collision in the executor's memory: the pairs that may come near in the next substeps. They are
// found cluster by cluster, and processed patch by patch, in colours of patches that share no particle.
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

/// Runs a kernel on the groups of a list of indices.
template <class Kernel>
struct IndexedGroups {
  Kernel kernel;
  const int* list;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    kernel(group.at(list[group.index]));
  }
};
template <class Kernel>
inline constexpr bool kShared<IndexedGroups<Kernel>> = kShared<Kernel>;
template <class Kernel>
inline constexpr int kThreads<IndexedGroups<Kernel>> = kThreads<Kernel>;
template <class Kernel>
void note_launch(const IndexedGroups<Kernel>& list, int groups) {
  note_launch(list.kernel, groups);
}

template <class Executor, class R>
class PairSearch {
 public:
  /// `origin`: a point near x, m.
  PairSearch(const Executor& executor, const SelfSurface& surface, const std::vector<Vec3>& x, double thickness,
             const BroadPhaseParams<R>& rules, const Vec3& origin = {})
      : executor_(executor), rules_(rules), thickness_(R(thickness)), particles_(static_cast<int>(x.size())) {
    upload_plan(plan_clusters(surface, x));
    std::vector<Vec4<R>> rest;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3 a = minus(x[i], origin);
      rest.push_back({R(a[0]), R(a[1]), R(a[2]), R(surface.body[i])});
    }
    rest.push_back({});
    rest_ = Array<Executor, Vec4<R>>(rest);
    from_ = Rows(x.size() + 1, Vec4<R>{}), way_ = Rows(x.size() + 1, Vec4<R>{});
    boxes_ = Array<Executor, Box<R>>(x.size(), Box<R>{});
    used_colours_ = Array<Executor, unsigned long long>(x.size() + 1, 0ull);
  }

  /// Finds the pairs that the motions from x0 may bring near, in a frame that moves by `common` in this substep,
  /// `ahead` substeps ahead.
  void search(const Trajectories<R>& motions, const Vector3<R>& common, int ahead) {
    parallel_for(executor_, particles_, InitSweptBounds<R>{motions, common, R(ahead), rules_, swept_bounds()}, kGrain);
    search_again();
  }
  /// Repeats the last search from its stored start; finds the same pairs.
  void search_again() {
    parallel_for(executor_, particles_, ComputeSweptAabbs<R>{swept_bounds(), rules_.min_distance, boxes_.data()},
                 kGrain);
    refit_clusters();
    find();
    order();
  }
  SweptBounds<R> swept_bounds() const { return {from_.data(), way_.data(), rest_.data()}; }
  Pairs<R> pairs() const {
    return {patches_.data(), blocks_.data(), bits_.data(), patch_particles_.data(), kIndexScale<R> * particles_};
  }
  int clusters() const { return clusters_.count; }

  std::int64_t found() const { return found_; }  // pairs
  std::int64_t candidates() const { return candidates_; }
  int colours() const { return static_cast<int>(colour_begin_.size()) - 1; }

  /// Runs work(team), which launches many kernels over patches, on as many threads as the pairs can keep busy.
  template <class Work>
  void region(const Work& work) const {
    parallel_region(executor_, width_, work);
  }
  /// Runs kernel(group) on every patch with pairs, so that no two patches that share a particle are processed at once.
  template <class Team, class Kernel>
  void in_colours(const Team& team, const Kernel& kernel) const {
    for (int colour = 0; colour < colours(); ++colour) in_colour(team, colour, kernel);
  }
  template <class Team, class Kernel>
  void in_colour(const Team& team, int colour, const Kernel& kernel) const {
    parallel_for_interleaved(team, colour_begin_[colour + 1] - colour_begin_[colour],
                             IndexedGroups<Kernel>{kernel, order_.data() + colour_begin_[colour]});
  }
  /// Runs a kernel on all patches with pairs at once.
  template <class Kernel>
  void for_all_patches(const Kernel& kernel) const {
    parallel_region(executor_, found_ < kPairGrain ? 1 : threads_of(executor_), [&](const auto& team) {
      parallel_for_interleaved(team, colour_begin_.back(), IndexedGroups<Kernel>{kernel, order_.data()});
    });
  }

  /// Sets the particles where bodies intersect: searches leave out pairs that have such a particle on both sides. An
  /// empty list: no bodies intersect.
  void exclude(const std::vector<CrossingBodies>& crosses) { crosses_ = Array<Executor, CrossingBodies>(crosses); }

  const CrossingBodies* crosses() const { return crosses_.data(); }

  /// The start of the last search, for checkpoints.
  const Array<Executor, Vec4<R>>& from() const { return from_; }
  const Array<Executor, Vec4<R>>& way() const { return way_; }
  void start_from(const std::vector<Vec4<R>>& from, const std::vector<Vec4<R>>& way) {
    from_.upload(from), way_.upload(way);
  }

  std::size_t bytes() const {
    return from_.bytes() + way_.bytes() + rest_.bytes() + boxes_.bytes() + patches_.bytes() + colour_.bytes() +
           order_.bytes() + bounds_.bytes() + items_.bytes() + wire_edge_.bytes() + used_colours_.bytes() +
           index_memory_.bytes() + patch_particles_.bytes() + blocks_.bytes() + bits_.bytes() + crosses_.bytes();
  }

  static constexpr int kGrain = 8192;

 private:
  using Rows = Array<Executor, Vec4<R>>;

  void upload_plan(const ClusterPlan& plan) {
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
    wire_edge_ = Array<Executor, unsigned char>(plan.wire_edge);
    clusters_.count = plan.clusters;
    for (int kind = 0; kind < kItemKinds; ++kind) clusters_.begin[kind] = items_.data() + begin[kind];
    clusters_.point = items_.data() + point;
    for (int k = 0; k < 3; ++k) clusters_.corner[k] = items_.data() + corner[k];
    for (int k = 0; k < 2; ++k) clusters_.end[k] = items_.data() + end[k];
    clusters_.wire_edge = wire_edge_.data();
    clusters_.levels = static_cast<int>(plan.nodes.size());
    std::copy(plan.level.begin(), plan.level.end(), clusters_.level);
    std::copy(plan.nodes.begin(), plan.nodes.end(), clusters_.nodes);
    has_wire_edges_ = std::find(plan.wire_edge.begin(), plan.wire_edge.end(), 1) != plan.wire_edge.end();

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
    for (int kind = 0; kind < kItemKinds; ++kind) clusters_.item[kind] = rows(counts[kind]);
    for (int kind = 0; kind < kItemKinds; ++kind) clusters_.leaf[kind] = rows(counts[kItemKinds + kind]);
    clusters_.node = rows(counts[2 * kItemKinds]);

    patches_ = Array<Executor, PairPatch>(plan.clusters, PairPatch{});
    if (!Memory<Executor>::kOnHost) {  // a device lists particles only up to the capacity
      std::vector<PairPatch> patches(plan.clusters);
      for (PairPatch& patch : patches) patch.particle_count = kInitialParticles;
      reserve(patches);
    }
    colour_ = Array<Executor, int>(plan.clusters, 0), order_ = Array<Executor, int>(plan.clusters, 0);
  }

  void refit_clusters() {
    parallel_for(executor_, clusters_.count, RefitLeaves<R>{clusters_, boxes_.data()}, kClusterGrain);
    for (int level = 1; level < clusters_.levels; ++level)
      parallel_for(executor_, clusters_.nodes[level], RefitLevel<R>{clusters_, level});
  }

  /// Searches with the capacity that the last search needed and a quarter more, and again where that is too small.
  void find() {
    const int threads = std::clamp(clusters_.count / kClustersPerThread, 1, threads_of(executor_));
    do {
      index_memory_.reserve(particles_, threads, patch_particles_.size());
      const typename PairIndexMemory<Executor>::template Find<R> find{
          {clusters_, swept_bounds(), thickness_, has_wire_edges_, crosses_.data(), pairs()},
          index_memory_.index_map()};
      parallel_region(executor_, threads, [&](const auto& team) {
        parallel_for_interleaved(team, clusters_.count, find, index_memory_.template memory<R>());
      });
    } while (!fits_capacity());
  }

  /// Returns true if the capacity was large enough; otherwise enlarges it.
  bool fits_capacity() {
    std::vector<PairPatch> patches = patches_.download();
    bool fits = true;
    found_ = candidates_ = 0;
    for (const PairPatch& patch : patches) {
      fits = fits && patch.all() <= patch.capacity && patch.particle_count <= patch.particle_capacity;
      found_ += patch.pairs, candidates_ += patch.candidates;
    }
    if (!fits) reserve(patches);
    return fits;
  }
  /// Reserves capacity for a quarter more than the patches have.
  void reserve(std::vector<PairPatch>& patches) {
    std::size_t blocks = 0, listed = 0;
    for (PairPatch& patch : patches) {
      patch.begin = static_cast<int>(blocks), patch.particles_begin = static_cast<int>(listed);
      patch.capacity = patch.all() + patch.all() / 4 + 1,
      patch.particle_capacity = patch.particle_count + patch.particle_count / 4 + kPairBlock;
      blocks += patch.capacity, listed += patch.particle_capacity;
      if (blocks > kMaxBlocks)
        throw OutOfMemory("self-collision: found more than " + std::to_string(kMaxBlocks * kPairBlock) +
                          " pairs that may come near; allowed: fewer; take a smaller thickness, or smaller steps");
    }
    patches_.upload(patches);
    if (blocks > bits_.size()) {
      if (bits_.size() > 0) blocks += blocks / 4;  // it has grown before, and may grow again in a jam
      blocks_ = {}, bits_ = {};
      blocks_ = Array<Executor, ContactBlock<R>>(blocks), bits_ = Array<Executor, PairBits>(blocks);
    }
    if (listed > patch_particles_.size()) patch_particles_ = {}, patch_particles_ = Array<Executor, int>(listed);
  }

  void order() {
    parallel_for(
        executor_, 1,
        ColorPatches{patches_.data(), patch_particles_.data(), clusters_.count, used_colours_.data(), colour_.data()});
    const std::vector<int> colour = colour_.download();
    std::vector<int> order;
    for (int u = 0; u < clusters_.count; ++u)
      if (colour[u] >= 0) order.push_back(u);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return colour[a] < colour[b]; });
    colour_begin_ = {0};
    for (std::size_t k = 0; k < order.size(); ++k)
      if (k + 1 == order.size() || colour[order[k + 1]] != colour[order[k]])
        colour_begin_.push_back(static_cast<int>(k) + 1);
    const int patches = colour_begin_.back();
    order.resize(clusters_.count, 0);
    order_.upload(order);
    width_ = found_ < kPairGrain ? 1 : std::max(1, patches / std::max(1, 2 * colours()));
  }

  static constexpr int kClusterGrain = 16, kClustersPerThread = 2;  // for refitting, and for finding pairs
  static constexpr std::int64_t kPairGrain = 8'000;                 // a hundred microseconds of work
  static constexpr int kInitialParticles = 256;                     // particle capacity of a cluster at first
  static constexpr std::size_t kMaxBlocks = 2147483647 / kPairBlock;

  Executor executor_;
  BroadPhaseParams<R> rules_;
  R thickness_;
  int particles_;
  ClusterBvh<R> clusters_{};
  bool has_wire_edges_ = false;
  Array<Executor, int> items_;
  Array<Executor, unsigned char> wire_edge_;
  Array<Executor, R> bounds_;
  Rows rest_, from_, way_;
  Array<Executor, Box<R>> boxes_;
  Array<Executor, unsigned long long> used_colours_;
  PairIndexMemory<Executor> index_memory_;
  Array<Executor, PairPatch> patches_;
  Array<Executor, int> colour_, order_, patch_particles_;
  Array<Executor, ContactBlock<R>> blocks_;
  Array<Executor, PairBits> bits_;
  Array<Executor, CrossingBodies> crosses_;
  std::vector<int> colour_begin_{0};
  std::int64_t found_ = 0, candidates_ = 0;
  int width_ = 1;
};

}  // namespace malha
