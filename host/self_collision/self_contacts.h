// SPDX-License-Identifier: Apache-2.0
// Pairs of self-collision that may come near, in the executor's memory: their blocks, bits, patches and colours, their
// contacts, and the counts of those that would intersect. A broad phase (host/self_collision/pair_search.h) fills them.
#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/base/array.h"
#include "kernels/self_collision/contact_distance.h"
#include "kernels/self_collision/kinematic_push.h"
#include "kernels/self_collision/solve_contacts.h"
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
class SelfContacts {
 public:
  /// Each of the clusters has a patch. `thickness`: m. `friction`: Coulomb's mu. `h`: of a substep, s.
  SelfContacts(const Executor& executor, int particles, int clusters, double thickness, double friction, double h)
      : executor_(executor),
        params_{R(recovery_share(h)), R(kPushDistance * thickness), least_gap(thickness)},
        friction_(R(friction)),
        sweeps_(h > kLong ? kLongSweeps : 1),
        particles_(particles) {
    patches_ = Array<Executor, PairPatch>(clusters, PairPatch{}), to_find_ = Array<Executor, int>(clusters, 0);
    list_all_patches();
    if (!Memory<Executor>::kOnHost) {  // a device lists particles only up to the capacity
      std::vector<PairPatch> patches(clusters);
      for (PairPatch& patch : patches) patch.particle_count = kInitialParticles;
      reserve(patches);
    }
    order_ = Array<Executor, int>(clusters, 0);
    colouring_.reserve(static_cast<std::size_t>(clusters), static_cast<std::size_t>(particles));
    colour_begin_.reserve(static_cast<std::size_t>(clusters) + 1),
        replanned_.reserve(static_cast<std::size_t>(clusters));
    closable_gap_ = Array<Executor, R>(clusters, R(0));
    violations_ = Array<Executor, ViolationCount>(clusters, ViolationCount{});
  }

  /// Lower bound of the gap that truncation leaves, m.
  static R least_gap(double thickness) { return R(kLeastGap * thickness); }

  Pairs<R> pairs() const {
    return {patches_.data(), blocks_.data(), bits_.data(), patch_particles_.data(), kIndexScale<R> * particles_};
  }
  std::int64_t found() const { return found_; }  // pairs
  std::int64_t candidates() const { return candidates_; }
  int colours() const { return static_cast<int>(colour_begin_.size()) - 1; }

  void start_substep() { detected_ = false, earlier_pushes_ = kNotCounted; }

  /// Before a broad phase, which replaces the pairs. Those that pushed in this substep are counted.
  void start_search() {
    if (detected_ && earlier_pushes_ == kNotCounted) earlier_pushes_ = count_pushes();
    list_all_patches(), to_find_.upload(lacking_);
  }
  /// Particles that all patches together can list.
  std::size_t list_capacity() const { return patch_particles_.size(); }
  /// The clusters whose pairs the broad phase has to find: all, and after finish_search() those that lacked capacity.
  const int* clusters_to_find() const { return to_find_.data(); }
  int number_to_find() const { return static_cast<int>(lacking_.size()); }
  /// Takes over what a broad phase has found. Returns false if the capacity of some clusters was too small; they have
  /// more then.
  bool finish_search() {
    const std::span<const PairPatch> patches = patches_.on_host(staging_);
    lacking_.clear(), found_ = candidates_ = 0;
    for (int u = 0; u < std::ssize(patches); ++u) {
      const PairPatch& patch = patches[u];
      if (patch.all() > patch.capacity || patch.particle_count > patch.particle_capacity) lacking_.push_back(u);
      found_ += patch.pairs, candidates_ += patch.candidates;
    }
    if (lacking_.empty()) {
      color_patches(patches);
      return true;
    }
    replanned_.assign(patches.begin(), patches.end());
    reserve(replanned_);
    return false;
  }

  /// Narrow phase: the planes of all pairs, and which of them are contacts.
  void detect(const Trajectories<R>& motions) {
    for_all_patches(NarrowPhase<R>{motions, pairs(), params_, closable_gap_.data()});
    detected_ = true;
  }
  /// Tells whether contacts were detected in this substep.
  bool detected() const { return detected_; }

  /// One projection of all contacts. `factor`: of the friction, of each particle and a row of padding; null: 1.
  void solve(const Trajectories<R>& motions, const R* factor) {
    const auto sweep = [&]<SelfFriction kFriction>() {
      const SolveContacts<R, kFriction> solve{pairs(), motions.moved, friction_, factor};
      parallel_region(executor_, width_, [&](const auto& team) {
        for (int k = 0; k < sweeps_; ++k) in_colours_of(team, solve);
      });
    };
    if (!(friction_ > R(0)))
      sweep.template operator()<SelfFriction::None>();
    else if (factor == nullptr)
      sweep.template operator()<SelfFriction::Same>();
    else
      sweep.template operator()<SelfFriction::Mapped>();
  }
  /// Number of contacts that pushed in the last substep.
  int pushes() const { return earlier_pushes_ != kNotCounted ? earlier_pushes_ : detected_ ? count_pushes() : 0; }

  /// Counts the pairs that would intersect at the end of the motions.
  ViolationCount violations_at_end(const Trajectories<R>& motions) {
    find_violations(motions, false, nullptr);
    return sum_violations();
  }
  /// Counts them too, and makes contacts of those that are none, for the next projection.
  ViolationCount violations_to_project(const Trajectories<R>& motions) {
    find_violations(motions, true, nullptr);
    return sum_violations();
  }
  /// Counts those that truncation can still resolve: they have a particle that is not truncated yet.
  ViolationCount violations_to_truncate(const Trajectories<R>& motions, const MotionState* states) {
    find_violations(motions, false, states);
    return sum_violations();
  }

  // What the guard does with the violating pairs that the last count has found.

  /// Pushes particles ahead of kinematic ones.
  void push_by_kinematic(const Trajectories<R>& motions, MotionState* states) const {
    in_colours(PushByKinematic<R>{motions, pairs(), params_, violations_.data(), states});
  }
  /// Moves particles along with kinematic ones. Returns whether any moved.
  bool move_with_kinematic(const Trajectories<R>& motions, const KinematicOwners& owners, MotionState* states) {
    in_colours(MoveWithKinematic<R>{motions, pairs(), owners, violations_.data(), states});
    return sum_violations().resolvable > 0;
  }
  /// Marks particles that must be truncated.
  void mark_violating(const Trajectories<R>& motions, MotionState* states, R* fraction) const {
    in_colours(MarkViolating<R>{motions, pairs(), violations_.data(), states, fraction});
  }
  /// Marks them, and computes the fraction of its displacement relative to `rest_motion` (m) that each of them keeps.
  void compute_truncation(const Trajectories<R>& motions, MotionState* states, R* fraction,
                          const Vector3<R>& rest_motion) const {
    in_colours(MarkViolating<R>{motions, pairs(), violations_.data(), states, fraction},
               ComputeTruncation<R>{motions, pairs(), params_, states, fraction, rest_motion});
  }

  /// Runs the kernels one after the other, each on every patch with pairs, so that no two patches that share a particle
  /// are processed at once.
  template <class... Kernels>
  void in_colours(const Kernels&... kernels) const {
    parallel_region(executor_, width_, [&](const auto& team) { (in_colours_of(team, kernels), ...); });
  }
  template <class Team, class Kernel>
  void in_colour(const Team& team, int colour, const Kernel& kernel) const {
    parallel_for_interleaved(team, colour_begin_[colour + 1] - colour_begin_[colour],
                             IndexedGroups<Kernel>{kernel, order_.data() + colour_begin_[colour]});
  }

  std::size_t bytes() const {
    return patches_.bytes() + blocks_.bytes() + bits_.bytes() + patch_particles_.bytes() + order_.bytes() +
           closable_gap_.bytes() + violations_.bytes() + to_find_.bytes();
  }

 private:
  static constexpr double kPushDistance =
      0.1;                                   // of the thickness, beyond the minimum distance: nearer pairs are contacts
  static constexpr double kLeastGap = 0.02;  // of the thickness
  static constexpr double kLong =
      0.01;  // s: in longer substeps layers fall so far that one sweep leaves uneven contacts
  static constexpr int kLongSweeps = 3;              // over all contacts, a projection
  static constexpr std::int64_t kPairGrain = 8'000;  // a hundred microseconds of work
  static constexpr int kInitialParticles = 256;      // particle capacity of a patch at first
  static constexpr std::size_t kMaxBlocks = 2147483647 / kPairBlock;
  static constexpr int kNotCounted = -1;

  int patches() const { return static_cast<int>(patches_.size()); }
  template <class Team, class Kernel>
  void in_colours_of(const Team& team, const Kernel& kernel) const {
    for (int colour = 0; colour < colours(); ++colour) in_colour(team, colour, kernel);
  }
  template <class Kernel>
  void for_all_patches(const Kernel& kernel) const {
    parallel_region(executor_, found_ < kPairGrain ? 1 : threads_of(executor_), [&](const auto& team) {
      parallel_for_interleaved(team, colour_begin_.back(), IndexedGroups<Kernel>{kernel, order_.data()});
    });
  }

  void find_violations(const Trajectories<R>& motions, bool projects, const MotionState* states) {
    for_all_patches(
        FindViolations<R>{motions, pairs(), params_, closable_gap_.data(), projects, states, violations_.data()});
  }
  ViolationCount sum_violations() const {
    return parallel_reduce<ViolationCount>(executor_, patches(), SumViolations<R>{pairs(), violations_.data()});
  }
  int count_pushes() const {
    return static_cast<int>(parallel_reduce<Sum>(executor_, patches(), CountPushes<R>{pairs()}).value);
  }

  void list_all_patches() {
    lacking_.resize(patches_.size());
    std::iota(lacking_.begin(), lacking_.end(), 0);
  }

  /// Reserves capacity for a quarter more than the lacking patches have, behind all others. Where the memory ends, all
  /// patches are laid out anew, and all lack their pairs.
  void reserve(std::vector<PairPatch>& patches) {
    const auto blocks_for = [](const PairPatch& patch) { return patch.all() + patch.all() / 4 + 1; };
    const auto list_for = [](const PairPatch& patch) {
      return patch.particle_count + patch.particle_count / 4 + kPairBlock;
    };
    const auto fits = [&] {
      std::size_t blocks = blocks_used_, listed = listed_used_;
      for (const int u : lacking_) blocks += blocks_for(patches[u]), listed += list_for(patches[u]);
      return blocks <= bits_.size() && listed <= patch_particles_.size();
    };
    if (!fits()) list_all_patches(), blocks_used_ = listed_used_ = 0;
    for (const int u : lacking_) {
      PairPatch& patch = patches[u];
      patch.begin = static_cast<int>(blocks_used_), patch.particles_begin = static_cast<int>(listed_used_);
      patch.capacity = blocks_for(patch), patch.particle_capacity = list_for(patch);
      blocks_used_ += patch.capacity, listed_used_ += patch.particle_capacity;
      if (blocks_used_ > kMaxBlocks)
        throw OutOfMemory("self-collision: found more than " + std::to_string(kMaxBlocks * kPairBlock) +
                          " pairs that may come near; allowed: fewer; take a smaller thickness, or smaller steps");
    }
    patches_.upload(patches), to_find_.upload(lacking_);
    if (blocks_used_ > bits_.size()) {
      // It has grown before, and may grow again in a jam.
      const std::size_t blocks = blocks_used_ + (bits_.size() > 0 ? blocks_used_ / 4 : 0);
      blocks_ = {}, bits_ = {};
      blocks_ = Array<Executor, ContactBlock<R>>(blocks), bits_ = Array<Executor, PairBits>(blocks);
    }
    if (listed_used_ > patch_particles_.size())
      patch_particles_ = {}, patch_particles_ = Array<Executor, int>(listed_used_ + listed_used_ / 4);
  }

  /// Greedy colouring, and the order of the patches by colour: those that share a particle get different colours.
  void color_patches(const std::span<const PairPatch>& patches) {
    const std::span<const int> listed = patch_particles_.on_host(colouring_.staging);
    auto& [colour, order, uncoloured, later, used, staging] = colouring_;
    colour.assign(patches.size(), -1), order.clear();
    for (int u = 0; u < std::ssize(patches); ++u)
      if (patches[u].pairs > 0) order.push_back(u);
    uncoloured = order;
    for (int base = 0; !uncoloured.empty(); base += 64, uncoloured.swap(later)) {
      used.assign(static_cast<std::size_t>(particles_) + 1, 0), later.clear();
      for (const int u : uncoloured) {
        const std::span of(listed.data() + patches[u].particles_begin, patches[u].particle_count);
        std::uint64_t all = 0;
        for (const int i : of) all |= used[i];
        if (~all == 0) {
          later.push_back(u);
          continue;
        }
        colour[u] = base + std::countr_one(all);
        for (const int i : of) used[i] |= std::uint64_t{1} << (colour[u] - base);
      }
    }
    std::ranges::sort(order, {}, [&](int u) { return std::pair(colouring_.colour[u], u); });
    colour_begin_.assign(1, 0);
    for (std::size_t k = 0; k < order.size(); ++k)
      if (k + 1 == order.size() || colour[order[k + 1]] != colour[order[k]])
        colour_begin_.push_back(static_cast<int>(k) + 1);
    width_ = found_ < kPairGrain ? 1 : std::max(1, colour_begin_.back() / std::max(1, 2 * colours()));
    order.resize(patches.size());
    order_.upload(order);
  }

  /// Working memory of color_patches(), reserved for all patches and particles.
  struct Colouring {
    std::vector<int> colour;                    // of each patch; -1: no pairs
    std::vector<int> order, uncoloured, later;  // patches with pairs; those left in this round; in the next one
    std::vector<std::uint64_t> used;            // of each particle: colours of this round, a bit each
    std::vector<int> staging;                   // the particles of the patches of a device
    void reserve(std::size_t patches, std::size_t particles) {
      for (std::vector<int>* list : {&colour, &order, &uncoloured, &later}) list->reserve(patches);
      used.reserve(particles + 1);
    }
  };

  Executor executor_;
  ContactParams<R> params_;
  R friction_;
  int sweeps_, particles_;
  Array<Executor, PairPatch> patches_;
  std::vector<PairPatch> staging_;    // the same, of a device
  std::vector<PairPatch> replanned_;  // the same, with more capacity
  std::vector<int> lacking_;          // clusters whose pairs are not found
  Array<Executor, int> to_find_;      // the same
  std::size_t blocks_used_ = 0, listed_used_ = 0;
  Array<Executor, int> patch_particles_;
  Array<Executor, ContactBlock<R>> blocks_;
  Array<Executor, PairBits> bits_;
  Array<Executor, int> order_;        // of the patches with pairs, by colour
  std::vector<int> colour_begin_{0};  // in order_
  Colouring colouring_;
  int width_ = 1;  // number of threads that the pairs can keep busy
  std::int64_t found_ = 0, candidates_ = 0;
  Array<Executor, R> closable_gap_;             // see NarrowPhase
  Array<Executor, ViolationCount> violations_;  // of each patch, at the last count
  bool detected_ = false;
  int earlier_pushes_ = kNotCounted;  // of contacts of this substep that a broad phase has replaced
};

}  // namespace malha
