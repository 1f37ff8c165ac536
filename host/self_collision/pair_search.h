// SPDX-License-Identifier: Apache-2.0
// Broad phase of self-collision in the executor's memory: swept bounds of the particles, and the search, cluster by
// cluster, for pairs that may come near while no particle leaves its bounds. A search serves several substeps.
#pragma once
#include <algorithm>
#include <vector>

#include "host/self_collision/clusters.h"
#include "host/self_collision/pair_index_memory.h"
#include "host/self_collision/self_contacts.h"
#include "host/self_collision/self_memory.h"
#include "kernels/self_collision/swept_bounds.h"

namespace malha {

template <class Executor, class R>
class PairSearch {
 public:
  using Contacts = SelfContacts<Executor, R>;

  /// `origin`: a point near x, m. `crosses`: bodies intersect at the start. `at_rest`: where particles are at rest from
  /// a place of their body, m; empty: x.
  PairSearch(const Executor& executor, const SelfSurface& surface, const std::vector<Vec3>& x, double thickness,
             const Vector3<double>& origin = {0, 0, 0}, bool crosses = false, const std::vector<Vec3>& at_rest = {})
      : executor_(executor),
        rules_{R(0.2 * thickness), R(0.25), R(thickness), R(0.5 * thickness)},
        thickness_(R(thickness)),
        particles_(static_cast<int>(x.size())) {
    memory_.crosses = crosses ? 1 : 0;
    upload_plan(plan_clusters(surface, x));
    std::vector<Vec4<R>> rest;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (at_rest.empty())
        rest.push_back({R(x[i][0] - origin.x), R(x[i][1] - origin.y), R(x[i][2] - origin.z), R(surface.body[i])});
      else
        rest.push_back({R(at_rest[i][0]), R(at_rest[i][1]), R(at_rest[i][2]), R(surface.body[i])});
    rest.push_back({});
    rest_ = Rows(rest), from_ = Rows(x.size() + 1, Vec4<R>{}), way_ = Rows(x.size() + 1, Vec4<R>{});
    boxes_ = Array<Executor, Box<R>>(x.size(), Box<R>{});
    takes_part_ = Array<Executor, unsigned char>(surface.takes_part);
    violations_ = Array<Executor, BoundsViolations>(
        (x.size() + CheckSweptBounds<R>::kGroup - 1) / CheckSweptBounds<R>::kGroup, BoundsViolations{});
    if (surface.sewn.list.empty()) return;
    std::vector<int> list = surface.sewn.list;
    for (int& i : list) i *= kIndexScale<R>;
    sewn_begin_ = Array<Executor, int>(surface.sewn.begin), sewn_ = Array<Executor, int>(list);
  }

  int clusters() const { return clusters_.count; }
  /// Returns 1 for each particle that takes part, and 0 for the others.
  const unsigned char* takes_part() const { return takes_part_.data(); }
  std::int64_t searches() const { return searches_; }
  /// Number of substeps that searches look ahead now.
  int horizon() const { return memory_.horizon; }

  /// Once a substep, with its predicted motions: searches if the last search is not valid for them.
  void update(const Trajectories<R>& motions, Contacts& contacts) {
    if (memory_.valid) {
      const BoundsViolations found = check_bounds(motions);
      if (found.outside <= most_clamped() && found.tight <= kMostTight * particles_) {
        ++memory_.age;
        return;
      }
    }
    // Look ahead as far as the last search served, or farther if it served to its horizon.
    memory_.horizon =
        memory_.age < memory_.horizon ? memory_.age : std::min(2 * memory_.horizon, SearchMemory::kMaxAhead);
    search(motions, {0, 0, 0}, memory_.horizon, contacts);
  }
  /// Finds the pairs that the motions from x0 may bring near, `ahead` substeps ahead. Truncated particles, which move
  /// by `rest_motion` (m) in this substep, stay in their bounds.
  void search(const Trajectories<R>& motions, const Vector3<double>& rest_motion, int ahead, Contacts& contacts) {
    memory_.valid = memory_.age = 1;
    parallel_for(executor_, particles_,
                 InitSweptBounds<R>{motions, rounded<R>(rest_motion), R(ahead), rules_, swept_bounds()}, kGrain);
    find_pairs(contacts);
    ++searches_;
  }
  /// The next substep searches anew.
  void invalidate() { memory_.valid = 0; }

  /// Checks that particles stay in their swept bounds. `rest_motion`: of truncated particles, m.
  BoundsViolations check_bounds(const Trajectories<R>& motions, const Vector3<double>& rest_motion = {0, 0, 0}) const {
    const int groups = static_cast<int>(violations_.size());
    const CheckSweptBounds<R> check{motions,    swept_bounds(),    R(kFit), takes_part_.data(), rounded<R>(rest_motion),
                                    particles_, violations_.data()};
    parallel_region(executor_, particles_ > kGrain ? groups : 1,
                    [&](const auto& team) { parallel_groups(team, 0, groups, {}, check); });
    return parallel_reduce<BoundsViolations>(executor_, groups, ReadViolations{violations_.data()});
  }
  /// So many particles that leave their swept bounds are clamped to them: a part of their motion in one substep is
  /// lost, where a search would cost as much as all constraints in several substeps.
  double most_clamped() const { return kMostClamped * particles_; }
  double most_clamped_at_end() const { return kMostClampedAtEnd * particles_; }
  void clamp_to_bounds(const Trajectories<R>& motions, const Displaced<R>& p) const {
    parallel_for(executor_, particles_, ClampToSweptBounds<R>{motions, swept_bounds(), p, takes_part_.data()}, kGrain);
  }

  /// Sets the particles where bodies intersect: searches leave out pairs that have such a particle on both sides. An
  /// empty list: no bodies intersect.
  void exclude(const std::vector<CrossingBodies>& crosses) {
    crosses_ = Array<Executor, CrossingBodies>(crosses);
    memory_.crosses = crosses.empty() ? 0 : 1, memory_.valid = 0;
  }
  const CrossingBodies* crosses() const { return crosses_.data(); }
  /// Tells whether bodies that intersected at the start did so when they were last tested.
  bool has_crossings() const { return memory_.crosses == 1; }

  /// The state that later substeps depend on, for checkpoints.
  void save(SelfMemory<R>& memory) const {
    for (int i = 0; const Vec4<R>& a : from_.download())
      if (i++ < particles_) memory.from.push_back({a.x, a.y, a.z, a.w});
    for (int i = 0; const Vec4<R>& a : way_.download())
      if (i++ < particles_) memory.way.push_back({a.x, a.y, a.z});
    memory.search = {memory_};
  }
  /// Restores it; a valid search is repeated, which finds the same pairs.
  void restore(const SelfMemory<R>& memory, Contacts& contacts) {
    memory_ = memory.search.at(0);
    if (memory_.valid == 0) return;
    std::vector<Vec4<R>> from, way;
    for (const auto& a : memory.from) from.push_back({a[0], a[1], a[2], a[3]});
    for (const auto& a : memory.way) way.push_back({a[0], a[1], a[2], R(0)});
    from.push_back({}), way.push_back({});
    from_.upload(from), way_.upload(way);
    find_pairs(contacts);
  }

  std::size_t bytes() const {
    std::size_t bytes = from_.bytes() + way_.bytes() + rest_.bytes() + boxes_.bytes() + wire_edge_.bytes() +
                        takes_part_.bytes() + violations_.bytes() + index_memory_.bytes() + crosses_.bytes() +
                        sewn_begin_.bytes() + sewn_.bytes();
    for (const auto& list : lists_) bytes += list.bytes();
    for (const auto& boxes : boxes_of_items_) bytes += boxes.bytes();
    return bytes;
  }

 private:
  using Rows = Array<Executor, Vec4<R>>;

  void upload_plan(const ClusterPlan& plan) {
    const auto upload = [&](std::vector<int> list, int scale) -> const int* {
      for (int& i : list) i = i < 0 ? i : scale * i;
      lists_.emplace_back(list);
      return lists_.back().data();
    };
    const auto rows = [&](std::size_t count) {
      boxes_of_items_.emplace_back(6 * count, R(0));
      BoxRows<R> boxes;
      for (int k = 0; k < 6; ++k) boxes.bound[k] = boxes_of_items_.back().data() + k * count;
      return boxes;
    };
    clusters_.count = plan.clusters;
    for (int kind = 0; kind < kItemKinds; ++kind) {
      const std::size_t items = plan.begin[kind].back();
      clusters_.begin[kind] = upload(plan.begin[kind], 1);
      clusters_.item[kind] = rows(items + kBranch), clusters_.leaf[kind] = rows(items / kBranch + kBranch);
    }
    clusters_.point = upload(plan.point, kIndexScale<R>);
    for (int k = 0; k < 3; ++k) clusters_.corner[k] = upload(plan.corner[k], kIndexScale<R>);
    for (int k = 0; k < 2; ++k) clusters_.end[k] = upload(plan.end[k], kIndexScale<R>);
    wire_edge_ = Array<Executor, unsigned char>(plan.wire_edge);
    clusters_.wire_edge = wire_edge_.data();
    clusters_.has_wire_edges = std::ranges::find(plan.wire_edge, 1) != plan.wire_edge.end();
    lay_out_levels(clusters_.count, clusters_.tree);
    clusters_.tree.node = rows(static_cast<std::size_t>(node_capacity(clusters_.tree)));
  }

  SweptBounds<R> swept_bounds() const { return {from_.data(), way_.data(), rest_.data()}; }

  /// Finds the pairs in the swept bounds, and those of clusters whose capacity is too small again.
  void find_pairs(Contacts& contacts) {
    contacts.start_search();
    parallel_for(executor_, particles_, ComputeSweptAabbs<R>{swept_bounds(), rules_.min_distance, boxes_.data()},
                 kGrain);
    parallel_for(executor_, clusters_.count, RefitLeaves<R>{clusters_, boxes_.data()}, kClusterGrain);
    for (int level = 1; level < clusters_.tree.levels; ++level)
      parallel_for(executor_, clusters_.tree.nodes[level], RefitLevel<R>{clusters_.tree, level});
    const int threads = std::clamp(clusters_.count / kClustersPerThread, 1, threads_of(executor_));
    using Find = typename PairIndexMemory<Executor>::template Find<R>;
    do {
      index_memory_.reserve(particles_, threads, contacts.list_capacity());
      const Find find{{clusters_,
                       swept_bounds(),
                       thickness_,
                       crosses_.data(),
                       {sewn_begin_.data(), sewn_.data()},
                       contacts.pairs()},
                      index_memory_.index_map()};
      const IndexedGroups<Find> listed{find, contacts.clusters_to_find()};
      parallel_region(executor_, threads, [&](const auto& team) {
        parallel_for_interleaved(team, contacts.number_to_find(), listed, index_memory_.template memory<R>());
      });
    } while (!contacts.finish_search());
  }

  static constexpr int kGrain = 8192;                               // particles
  static constexpr int kClusterGrain = 16, kClustersPerThread = 2;  // for refitting, and for finding pairs
  // Constraints may use the rest of the margin of predicted motions, where few particles need more than this share.
  static constexpr double kFit = 0.5;
  static constexpr double kMostTight = 0.01;                               // of the particles
  static constexpr double kMostClamped = 0.001, kMostClampedAtEnd = 0.01;  // of the particles

  Executor executor_;
  BroadPhaseParams<R> rules_;
  R thickness_;
  int particles_;
  ClusterBvh<R> clusters_{};
  std::vector<Array<Executor, int>> lists_;         // of clusters_
  std::vector<Array<Executor, R>> boxes_of_items_;  // of clusters_, and of its nodes
  Array<Executor, unsigned char> wire_edge_;
  Rows rest_, from_, way_;
  Array<Executor, Box<R>> boxes_;
  Array<Executor, unsigned char> takes_part_;
  Array<Executor, BoundsViolations> violations_;  // of groups of particles
  PairIndexMemory<Executor> index_memory_;
  Array<Executor, CrossingBodies> crosses_;
  Array<Executor, int> sewn_begin_, sewn_;  // see SewnParticles
  SearchMemory memory_;
  std::int64_t searches_ = 0;
};

}  // namespace malha
