// SPDX-License-Identifier: Apache-2.0
// Self-collision of deformable bodies: a broad phase whose candidates serve several substeps, contacts of near pairs,
// their projection, and the guarantee that no primitives intersect. Made only for scenes that name self_collision.
//
// The guarantee rests on three facts: (1) the start, the end and the truncated position of every particle lie in its
// swept box of the last broad phase, or the broad phase runs again; (2) a pair that is no candidate cannot come nearer
// than its minimum distance while all particles stay in their boxes; (3) every candidate pair has a plane that
// separates its sides at the start and must separate them at the end, or its displacements are truncated.
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "host/measure/solver_stats.h"
#include "host/model/ordering/particle_runs.h"
#include "host/self_collision/pair_search.h"
#include "host/self_collision/rigid_momentum_fit.h"
#include "host/self_collision/self_memory.h"
#include "kernels/environment/edge_truncate.h"
#include "kernels/self_collision/contact_distance.h"
#include "kernels/self_collision/kinematic_push.h"
#include "kernels/self_collision/self_checks.h"
#include "kernels/self_collision/solve_contacts.h"

namespace malha {

template <class Executor, class R>
class SelfCollider {
 public:
  SelfCollider(const Executor& executor, const Model& model);

  /// Starts a substep. Contacts are detected in its first projection, when the predicted positions are known.
  void start_substep() {
    contacts_valid_ = false, cached_contact_count_ = -1, correction_ = MomentumCorrection::None;
    can_project_ = true, pushes_left_ = kMaxPushes, kinematic_moves_left_ = kMaxKinematicMoves;
    if (memory_.crosses == 1 && substep_ == 0) exclude_initial_intersections();
  }

  /// One projection of all contacts.
  void solve_contacts(const Particles<R>& particles);

  /// Final guard of a substep: no primitives intersect afterwards. Displacements of a jam are truncated; where
  /// nothing is pinned or touches the environment, end_substep() gives bodies their momentum back. `owners`: of
  /// particles that environment objects have moved in this substep, and whose inverse mass is 0. Returns whether
  /// anything had to move.
  bool resolve_intersections(const Particles<R>& particles, const std::function<bool()>& has_environment_contacts,
                             const KinematicOwners& owners = {});

  /// Notes whether guards that ran last have moved bodies through each other.
  void note_intersections(const Particles<R>& particles) {
    store_motion(particles);
    if (check_bounds(within_rounding<R>()).outside > 0) cache_contact_count(), search(common(), 1), narrow_phase();
    kinematic_penetration_ = count_violations(false, nullptr) > 0 || kinematic_penetration_;
  }

  /// Returns true if a kinematic particle may have gone through a body in this substep.
  bool has_kinematic_penetration() const { return kinematic_penetration_; }

  /// Records how truncation has changed the displacements; call it before velocities are derived from them. `lifts`: a
  /// mesh may have lifted particles that were truncated afterwards; the way back gives them no velocity.
  void note_truncation(const Particles<R>& particles, bool lifts) {
    if (correction_ == MomentumCorrection::None) return;  // nothing was truncated
    if (lifts) parallel_for(executor_, count_, RemoveUndoneLift<R>{particles, x0_.points(), origin()}, kGrain);
    parallel_for(executor_, count_,
                 ComputeTruncationChange<R>{particles.p, x0_.points(), origin(), saved_motion_.data()}, kGrain);
  }

  /// Stores the positions from which the next substep starts, after one of h seconds. Bodies in a jam get their momenta
  /// back, or, where pins or objects (at most as fast as `object_speed`, m/s) push them, are not much faster than
  /// those.
  void end_substep(const Particles<R>& particles, double h, double object_speed);

  /// Starts from positions that were set from outside and in which nothing intersects.
  void start_from(const Particles<R>& particles) { store_start_positions(particles), update_origin(particles); }

  /// Pairs that are nearer than the thickness now keep their distance until they separate by themselves
  /// (kernels/self_collision/contact_distance.h).
  void keep_overlaps() {
    parallel_for(executor_, count_, ResetContactDistances<R>{x0_.points().of, R(thickness_)}, kGrain);
    overlaps_ = true;
  }

  /// Number of contacts that pushed in the last substep.
  int contacts() const;

  const SelfSurface& surface() const { return surface_; }
  SelfStats facts() const;
  std::size_t bytes() const;

  /// The state that later substeps depend on, for checkpoints.
  SelfMemory<R> save_state() const;
  void restore_state(const SelfMemory<R>& memory);

 private:
  using Points4 = ScatteredArray<Executor, R>;
  enum class MomentumCorrection { None, Restore, CapSpeed };  // of jammed bodies, at the end of a substep

  static constexpr int kGrain = PairSearch<Executor, R>::kGrain;
  static constexpr int kMoreProjections = 8;
  static constexpr int kMaxPushes = 8, kMaxKinematicMoves = 16;  // in a substep
  static constexpr double kMaxSpeedRatio = 2;  // times the speed of what pushes a jam, if nothing in it was faster
  static constexpr double kLong =
      0.01;  // s: in longer substeps layers fall so far that one sweep leaves uneven contacts
  static constexpr int kLongSweeps = 3;
  static constexpr double kPushDistance =
      0.1;                                   // of the thickness, beyond the minimum distance: nearer pairs are contacts
  static constexpr double kFit = 0.5;        // of the margin of a swept box: constraints may use the rest
  static constexpr double kLeastGap = 0.02;  // of the thickness
  static constexpr double kRounding = 0.05;  // of the least gap
  static constexpr double kNearOrigin = 0.25;  // of the distance from the origin at which rounding reaches kRounding

  static BroadPhaseParams<R> broad_phase_params(double thickness) {
    return {R(0.1 * thickness), R(0.25), R(thickness), R(0.5 * thickness)};
  }
  static ContactParams<R> contact_params(double h, double thickness) {
    return {R(recovery_share(h)), R(kPushDistance * thickness), R(kLeastGap * thickness)};
  }
  static std::size_t first_of(const SelfSurface& surface) {
    const auto at = std::ranges::find(surface.takes_part, 1);
    return at == surface.takes_part.end() ? 0 : static_cast<std::size_t>(at - surface.takes_part.begin());
  }
  static Vector3<R> to_R(const Vec3& a) { return {R(a[0]), R(a[1]), R(a[2])}; }
  template <class T>
  static std::vector<T> without_padding(std::vector<T> list) {
    list.pop_back();
    return list;
  }

  Vector3<R> origin() const { return to_R(memory_.origin); }
  /// Largest distance (m) of `first_particle_` from the origin before the origin is moved.
  double max_distance_from_origin() const {
    return kNearOrigin * kRounding * double(rules_.least) / std::numeric_limits<R>::epsilon();
  }
  /// The previous origin, or `first` if that is too far from it. Types without a low part of positions keep origin 0.
  Vec3 origin_near(const Vec3& first, const Vec3& before) const {
    const Vec3 way = minus(first, before);
    const double apart = std::max({std::abs(way[0]), std::abs(way[1]), std::abs(way[2])});
    if (!kCompensated<R> || !(apart > max_distance_from_origin()) || !(apart < double(std::numeric_limits<R>::max())))
      return before;
    return {double(R(first[0])), double(R(first[1])), double(R(first[2]))};
  }
  void store_start_positions(const Particles<R>& particles) {
    parallel_for(executor_, count_, CopyPoints<R, FromOrigin<R>>{{particles.p, origin()}, x0_.points()});
  }
  /// Moves the origin along with the bodies. The last broad phase is invalid then: its boxes are relative to the old
  /// one.
  void update_origin(const Particles<R>& particles) {
    if constexpr (!kCompensated<R>) return;
    Vec3 first = x0_.get(first_particle_);
    for (int k = 0; k < 3; ++k) first[k] += memory_.origin[k];
    const Vec3 origin = origin_near(first, memory_.origin);
    if (origin == memory_.origin) return;
    memory_.origin = origin, memory_.valid = 0;
    store_start_positions(particles);
  }

  Trajectories<R> motions() const { return {x0_.points().of, moved_.points().of, origin()}; }
  CommonFrame<R> frame() const { return {to_R(memory_.frame_offset), to_R(memory_.frame_displacement)}; }
  void store_motion(const Particles<R>& particles) {
    parallel_for(executor_, count_, ComputeDisplacements<R>{particles.p, particles.w, motions()}, kGrain);
  }

  SumMotion<R> sum_motion() const { return {moved_.points(), takes_part_.data()}; }
  /// `moves`, `rest_motion`: see CheckSweptBounds.
  CheckSweptBounds<R> bounds_check(double share, const Vector3<R>* moves = nullptr,
                                   const Vec3& rest_motion = {}) const {
    return {motions(), search_.swept_bounds(), frame(), moves, R(share), takes_part_.data(), to_R(rest_motion)};
  }
  /// Common motion of all particles, m.
  static Vec3 common(const MeanMotion& mean) {
    const Vector3<double> a = mean.value();
    return {a.x, a.y, a.z};
  }
  Vec3 common() const { return common(parallel_reduce<MeanMotion>(executor_, count_, sum_motion(), kGrain)); }
  BoundsViolations check_bounds(double share, const Vec3& rest_motion = {}) const {
    return parallel_reduce<BoundsViolations>(executor_, count_, bounds_check(share, nullptr, rest_motion), kGrain);
  }
  /// Computes the common motion, and checks the swept bounds in a frame that moves with it.
  SelfChecks<R> check_start() const {
    SelfChecks<R>* const checks = checks_.data();
    parallel_reduce_into(executor_, count_, sum_motion(), &checks->mean, kGrain);
    parallel_for(executor_, 1, StoreCommonMotion<R>{checks});
    parallel_reduce_into(executor_, count_, bounds_check(kFit, &checks->common), &checks->stay, kGrain);
    return checks_.get(0);
  }
  /// Checks the swept bounds and, if all particles are inside, counts the pairs that would intersect (ViolationCount).
  /// On a device both are computed in one go and read once.
  std::pair<BoundsViolations, int> check_end() {
    if constexpr (Memory<Executor>::kOnHost) {
      const BoundsViolations stay = check_bounds(within_rounding<R>());
      return {stay, stay.outside == 0 ? count_violations(can_project_, nullptr) : 0};
    } else {
      SelfChecks<R>* const checks = checks_.data();
      parallel_reduce_into(executor_, count_, bounds_check(within_rounding<R>()), &checks->stay);
      find_violations(can_project_, nullptr);
      parallel_reduce_into(executor_, search_.clusters(), SumViolations<R>{search_.pairs(), violations_.data()},
                           &checks->violations);
      const SelfChecks<R> found = checks_.get(0);
      return {found.stay, found.stay.outside == 0 ? count_resolvable(found.violations) : 0};
    }
  }
  /// Broad phase from the present positions, in a frame that moves by `moves` in this substep, `ahead` substeps ahead.
  void search(const Vec3& moves, int ahead) {
    memory_.frame_offset = {}, memory_.frame_displacement = moves, memory_.valid = memory_.age = 1;
    search_.search(motions(), to_R(moves), ahead);
    ++facts_.searches;
  }

  /// Broad phase where the last one is no longer valid, and narrow phase.
  void update_contacts() {
    for (int k = 0; k < 3; ++k) memory_.frame_offset[k] += memory_.frame_displacement[k];
    const SelfChecks<R> checks = check_start();
    memory_.frame_displacement = common(checks.mean);
    if (!memory_.valid || checks.stay.outside > 0) {
      // Look ahead as far as the last broad phase served, or farther if it served to its horizon.
      memory_.horizon =
          memory_.age < memory_.horizon ? memory_.age : std::min(2 * memory_.horizon, SearchMemory::kMaxAhead);
      search(memory_.frame_displacement, memory_.horizon);
    } else {
      ++memory_.age;
    }
    narrow_phase();
    contacts_valid_ = true;
  }
  /// Excludes pairs around intersections of the initial state that persist.
  void exclude_initial_intersections() {
    const auto found = crossings_and_touches(surface_, without_padding(x0_.template download<Vec3>()));
    std::vector<CrossingBodies> crosses(found.empty() ? 0 : count_, 0);
    for (const auto& [edge, triangle] : found) {
      const CrossingBodies both = crossing_bit(surface_.body[edge[0]], surface_.body[triangle[0]]);
      for (const int i : edge) crosses[i] |= both;
      for (const int i : triangle) crosses[i] |= both;
    }
    search_.exclude(crosses);
    parallel_for(executor_, count_, MarkCrossingBodies<R>{x0_.points().of, R(thickness_), search_.crosses()}, kGrain);
    memory_.valid = 0, memory_.crosses = found.empty() ? 0 : 1;
    overlaps_ = true;
  }

  void grow_contact_distances() {
    R* const nearest = nearest_.at_least(count_ + 1);
    Memory<Executor>::fill(nearest, count_ + 1, R(INFINITY));
    const FindNearestPairs<R> find{motions(), search_.pairs(), nearest};
    search_.region([&](const auto& team) { search_.in_colours(team, find); });
    const GrowContactDistances<R> grow{x0_.points().of, R(thickness_), nearest};
    overlaps_ = parallel_reduce<Sum>(executor_, count_, grow, kGrain).value > 0;
    if (!overlaps_) nearest_ = {};
  }

  void narrow_phase() {
    if (overlaps_) grow_contact_distances();
    const NarrowPhase<R> narrow_phase{motions(), search_.pairs(), rules_, closable_gap_.data()};
    search_.for_all_patches(narrow_phase);
  }
  void project_contacts(const Particles<R>& particles) {
    const auto solve = [&]<bool kFriction>() {
      const SolveContacts<R, kFriction> push{search_.pairs(), moved_.points().of, friction_};
      search_.region([&](const auto& team) {
        for (int sweep = 0; sweep < sweeps_; ++sweep) search_.in_colours(team, push);
      });
    };
    friction_ > R(0) ? solve.template operator()<true>() : solve.template operator()<false>();
    parallel_for(executor_, count_, ApplyDisplacements<R>{motions(), particles.p}, kGrain);
  }

  SearchMemory initial_memory(const Model& model) const {
    SearchMemory start;
    if (!model.x.empty()) start.origin = origin_near(model.x[first_particle_], {});
    return start;
  }
  /// Positions relative to the origin, as Displaced::relative_to() has them, and a row of padding.
  std::vector<Vec3> padded_positions(const std::vector<Vec3>& x) const {
    std::vector<Vec3> all;
    for (const Vec3& a : x) {
      Vec3& place = all.emplace_back();
      for (int k = 0; k < 3; ++k) {
        const R stored = R(a[k]);
        place[k] = kCompensated<R> ? (stored - R(memory_.origin[k])) + R(a[k] - double(stored)) : stored;
      }
    }
    all.push_back({0, 0, 0});
    return all;
  }

  int count_pushes() const {
    return static_cast<int>(parallel_reduce<Sum>(executor_, search_.clusters(), CountPushes<R>{search_.pairs()}).value);
  }
  /// Caches the count before new contacts replace those that pushed in this substep.
  void cache_contact_count() {
    if (cached_contact_count_ < 0) cached_contact_count_ = count_pushes();
  }

  /// Saves the displacements before the first truncation of a substep.
  void save_motion(const Particles<R>& particles) {
    if (correction_ != MomentumCorrection::None) return;
    parallel_for(executor_, count_, SaveMotion<R>{particles.v, motions(), saved_motion_.at_least(count_)}, kGrain);
    if (runs_.size() == 0) build_runs();
    correction_ = MomentumCorrection::Restore;
  }
  /// Ranges of particles that take part, body by body.
  void build_runs() {
    std::vector<int> body(count_);
    for (int i = 0; i < count_; ++i) body[i] = surface_.takes_part[i] ? surface_.body[i] : -1;
    const std::vector<ParticleRun> runs = particle_runs(body);
    runs_ = Array<Executor, ParticleRun>(runs);
    truncation_sums_ = Array<Executor, TruncationSums>(runs.size(), TruncationSums{});
    truncated_motions_ = Array<Executor, TruncatedMotion>(runs.size(), TruncatedMotion{});
    chosen_ = Array<Executor, int>(runs.size(), 0);
  }
  int runs() const { return static_cast<int>(runs_.size()); }

  /// Gives bodies with truncated particles back the momenta that truncation took, or limits the speed that kinematic
  /// particles and the constraints strained by them would give these bodies.
  void restore_momenta(const Particles<R>& particles, double h, double object_speed) {
    parallel_for(executor_, runs(),
                 SumTruncation<R>{particles, x0_.points(), origin(), saved_motion_.data(), 1 / h, runs_.data(),
                                  truncation_sums_.data()},
                 1);
    const std::vector<ParticleRun> runs = runs_.download();
    const std::vector<TruncationSums> sums = truncation_sums_.download();
    std::vector<int> changed(surface_.body.empty() ? 0 : *std::ranges::max_element(surface_.body) + 1), chosen;
    for (std::size_t r = 0; r < runs.size(); ++r) changed[runs[r].group] |= sums[r].changed;
    TruncationSums all;
    double pins = 0;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      chosen.push_back(changed[runs[r].group]);
      if (chosen.back()) all += sums[r];
      pins = std::max(pins, sums[r].pins);
    }
    chosen_.upload(chosen);
    if (correction_ == MomentumCorrection::CapSpeed) {
      const LimitSpeed<R> limit{particles, saved_motion_.data(), runs_.data(), chosen_.data(),
                                kMaxSpeedRatio * std::max(pins / h, object_speed)};
      if (limit.max_speed > 0) parallel_for(executor_, this->runs(), limit, 1);
      return;
    }
    const RigidCorrection correction = fit_rigid_momentum(all);
    parallel_for(executor_, this->runs(),
                 AddRigidCorrection<R>{particles, x0_.points(), origin(), runs_.data(), chosen_.data(), correction.kept,
                                       correction.centre, correction.velocity, correction.omega},
                 1);
  }

  /// Mean motion of the bodies with particles that are about to be truncated, m; 0 where it would round them through
  /// each other, far from the origin.
  Vec3 motion_of_truncated() {
    parallel_for(executor_, runs(),
                 SumTruncatedMotion<R>{motions(), states_.data(), runs_.data(), truncated_motions_.data()}, 1);
    TruncatedMotion all;
    for (const TruncatedMotion& one : truncated_motions_.download())
      all.mean += one.mean, all.farthest = std::max(all.farthest, one.farthest);
    const bool fine = all.farthest * std::numeric_limits<R>::epsilon() < kRounding * double(rules_.least);
    return fine ? common(all.mean) : Vec3{};
  }

  void clamp_to_bounds(const Particles<R>& particles) {
    parallel_for(executor_, count_,
                 ClampToSweptBounds<R>{motions(), search_.swept_bounds(), frame(), particles.p, takes_part_.data()},
                 kGrain);
  }

  /// Number of pairs that would intersect and that truncation can still resolve.
  int count_violations(bool adds, const MotionState* states) {
    find_violations(adds, states);
    return count_resolvable(sum_violations());
  }
  void find_violations(bool adds, const MotionState* states) {
    search_.for_all_patches(
        FindViolations<R>{motions(), search_.pairs(), rules_, closable_gap_.data(), adds, states, violations_.data()});
  }
  int count_resolvable(const ViolationCount& left) {
    kinematic_penetration_ = kinematic_penetration_ || left.immovable > 0;
    return left.resolvable;
  }
  ViolationCount sum_violations() const {
    return parallel_reduce<ViolationCount>(executor_, search_.clusters(),
                                           SumViolations<R>{search_.pairs(), violations_.data()});
  }

  /// Resolves the intersections that remain. `left`: number of pairs that would intersect, if all particles are in
  /// their boxes. `owners`: null if no particle is fixed. `isolated`: no particle is fixed and none touches the
  /// environment, so that the bodies must keep their momenta.
  void resolve_violations(const Particles<R>& particles, const BoundsViolations& stay, int left,
                          const KinematicOwners* owners, bool isolated) {
    if (stay.outside > 0) clamp_to_bounds(particles), left = count_violations(can_project_, nullptr);
    // Only the first call of a substep projects: after pushes and moves it hardly ever helps.
    for (int more = 0; left > 0 && can_project_ && more < kMoreProjections; ++more) {
      project_contacts(particles);
      store_motion(particles);
      clamp_to_bounds(particles);
      left = count_violations(can_project_, nullptr);
    }
    can_project_ = false;
    if (left == 0) return;
    bool any = false;
    if (owners != nullptr && push_by_kinematic(particles)) {
      do {
        any = truncate_displacements(particles, false) || any;
      } while ((left = count_violations(false, nullptr)) > 0 && kinematic_moves_left_-- > 0 &&
               move_with_kinematic(particles, *owners));
      kinematic_penetration_ = kinematic_penetration_ || left > 0;
    } else {
      any = truncate_displacements(particles, isolated);
    }
    if (any) ++facts_.substeps_truncated;
    Memory<Executor>::fill(states_.at_least(count_ + 1), count_ + 1, MotionState::Unchanged);
  }

  /// Pushes particles that kinematic ones would penetrate ahead of these. Returns whether any kinematic particle moves.
  bool push_by_kinematic(const Particles<R>& particles) {
    const MarkPushing<R> mark{motions(), states_.at_least(count_ + 1)};
    if (parallel_reduce<Sum>(executor_, count_, mark, kGrain).value == 0) return false;
    for (; pushes_left_ > 0 && count_violations(false, nullptr) > 0; --pushes_left_) {
      const PushByKinematic<R> push{motions(), search_.pairs(), rules_, violations_.data(),
                                    states_.at_least(count_ + 1)};
      search_.region([&](const auto& team) { search_.in_colours(team, push); });
      apply_motion(particles);
    }
    return true;
  }
  /// Moves particles that kinematic ones still penetrate along with these. Returns whether there are any.
  bool move_with_kinematic(const Particles<R>& particles, const KinematicOwners& owners) {
    const MoveWithKinematic<R> move{motions(), search_.pairs(), owners, violations_.data(), states_.data()};
    search_.region([&](const auto& team) { search_.in_colours(team, move); });
    if (sum_violations().resolvable == 0) return false;
    apply_motion(particles);
    return true;
  }
  /// Applies the displacements and, if particles left their boxes, runs the broad phase again. Truncated particles are
  /// at rest in the world then, and so is the frame of the new boxes.
  void apply_motion(const Particles<R>& particles) {
    parallel_for(executor_, count_, ApplyDisplacements<R>{motions(), particles.p}, kGrain);
    store_motion(particles);
    if (check_bounds(within_rounding<R>()).outside == 0) return;
    cache_contact_count();
    search({}, 1);
    narrow_phase();
  }

  /// Returns whether any displacement was truncated. `isolated`: truncated particles move with the mean motion of their
  /// bodies; otherwise they are at rest in the world.
  bool truncate_displacements(const Particles<R>& particles, bool isolated) {
    MotionState* const states = states_.at_least(count_ + 1);
    R* const fraction = fraction_.at_least(count_ + 1);
    Vec3 rest_motion{};
    if (isolated && count_violations(false, states) > 0) {
      const MarkViolating<R> mark{motions(), search_.pairs(), violations_.data(), states, fraction};
      search_.region([&](const auto& team) { search_.in_colours(team, mark); });
      rest_motion = motion_of_truncated();
      Memory<Executor>::fill(states, count_ + 1, MotionState::Unchanged);
    }
    // A truncated position may lie outside of a box that moves with the common motion. Then search along the paths of
    // this substep.
    if (check_bounds(within_rounding<R>(), rest_motion).outside_if_truncated > 0) {
      cache_contact_count();
      search(rest_motion, 1);
      narrow_phase();
      memory_.valid = 0;
    }
    const int found = count_violations(false, states);
    for (int left = found; left > 0; left = count_violations(false, states)) {
      const MarkViolating<R> mark{motions(), search_.pairs(), violations_.data(), states, fraction};
      const ComputeTruncation<R> compute{motions(), search_.pairs(), rules_, states, fraction, to_R(rest_motion)};
      search_.region([&](const auto& team) { search_.in_colours(team, mark), search_.in_colours(team, compute); });
      parallel_for(executor_, count_,
                   TruncateDisplacements<R>{motions(), particles.p, fraction, states, to_R(rest_motion)}, kGrain);
    }
    return found > 0;
  }

  Executor executor_;
  SelfSurface surface_;
  int count_;
  double thickness_;
  R friction_;
  int substeps_, substep_ = 0;  // of a step, and since it began
  ContactParams<R> rules_{};
  std::size_t first_particle_ = 0;  // of those that take part; the origin follows it
  SearchMemory memory_;
  PairSearch<Executor, R> search_;
  int sweeps_ = 1;  // over all contacts, a projection
  bool contacts_valid_ = false;
  bool overlaps_ = true;                // whether contact distances may be below the thickness
  bool kinematic_penetration_ = false;  // whether a kinematic particle went through a body in this substep
  int cached_contact_count_ = -1;       // of the contacts that new ones have replaced; -1: none were
  SelfStats facts_;
  Array<Executor, unsigned char> takes_part_;
  Points4 x0_, moved_;
  Array<Executor, R> closable_gap_;
  Array<Executor, ViolationCount> violations_;
  Array<Executor, SelfChecks<R>> checks_{1, SelfChecks<R>{}};
  ScratchBuffer<Executor, MotionState> states_;
  ScratchBuffer<Executor, R> fraction_, nearest_;
  bool can_project_ = true;                         // whether violations may still be projected in this substep
  int pushes_left_ = 0, kinematic_moves_left_ = 0;  // in this substep
  MomentumCorrection correction_ = MomentumCorrection::None;
  ScratchBuffer<Executor, Vec4<R>> saved_motion_;  // see SaveMotion
  Array<Executor, ParticleRun> runs_;              // this and the following are allocated at the first truncation
  Array<Executor, TruncationSums> truncation_sums_;
  Array<Executor, TruncatedMotion> truncated_motions_;
  Array<Executor, int> chosen_;
};

template <class Executor, class R>
SelfCollider<Executor, R>::SelfCollider(const Executor& executor, const Model& model)
    : executor_(executor),
      surface_(self_surface(model)),
      count_(model.count()),
      thickness_(model.scene.self_collision->thickness),
      friction_(R(model.scene.self_collision->friction)),
      substeps_(model.scene.solver.substeps),
      rules_(contact_params(model.scene.solver.dt / substeps_, thickness_)),
      first_particle_(first_of(surface_)),
      memory_(initial_memory(model)),
      search_(executor, surface_, model.x, thickness_, broad_phase_params(thickness_), memory_.origin) {
  if (model.scene.self_collision->ignores_crossings) facts_.crossings = std::ssize(crossings_at_start(model, surface_));
  memory_.crosses = facts_.crossings > 0 ? 1 : 0;
  facts_.particles = surface_.particles, facts_.edges = surface_.edges, facts_.triangles = surface_.triangles;
  const double h = model.scene.solver.dt / model.scene.solver.substeps;
  if (h > kLong) sweeps_ = kLongSweeps;
  takes_part_ = Array<Executor, unsigned char>(surface_.takes_part);
  x0_ = Points4(padded_positions(model.x)), moved_ = Points4(model.x.size() + 1);
  closable_gap_ = Array<Executor, R>(search_.clusters(), R(0)),
  violations_ = Array<Executor, ViolationCount>(search_.clusters(), ViolationCount{});
}

template <class Executor, class R>
void SelfCollider<Executor, R>::solve_contacts(const Particles<R>& particles) {
  store_motion(particles);
  if (!contacts_valid_) update_contacts();
  project_contacts(particles);
}

template <class Executor, class R>
bool SelfCollider<Executor, R>::resolve_intersections(const Particles<R>& particles,
                                                      const std::function<bool()>& has_environment_contacts,
                                                      const KinematicOwners& owners) {
  kinematic_penetration_ = false;
  store_motion(particles);
  auto [stay, left] = check_end();
  if (stay.outside > 0) {  // a motion was larger than predicted: search along it, once
    cache_contact_count();
    search(common(), memory_.horizon);
    narrow_phase();
    stay = check_bounds(within_rounding<R>());
    if (stay.outside == 0) left = count_violations(can_project_, nullptr);
  }
  if (stay.outside == 0 && left == 0) return false;
  const CountFixed<R> fixed{particles.w, takes_part_.data()};
  const bool any_fixed = parallel_reduce<Sum>(executor_, count_, fixed, kGrain).value != 0;
  save_motion(particles);
  if (any_fixed || has_environment_contacts()) correction_ = MomentumCorrection::CapSpeed;
  resolve_violations(particles, stay, left, any_fixed ? &owners : nullptr, correction_ == MomentumCorrection::Restore);
  return true;
}

template <class Executor, class R>
void SelfCollider<Executor, R>::end_substep(const Particles<R>& particles, double h, double object_speed) {
  if (correction_ != MomentumCorrection::None) restore_momenta(particles, h, object_speed);
  store_start_positions(particles);
  substep_ = substep_ + 1 < substeps_ ? substep_ + 1 : 0;
  if (substep_ == 0) update_origin(particles);
  if (kinematic_penetration_) ++memory_.substeps_kinematic_penetration;
  kinematic_penetration_ = false;
}

template <class Executor, class R>
int SelfCollider<Executor, R>::contacts() const {
  return cached_contact_count_ >= 0 ? cached_contact_count_ : count_pushes();
}

template <class Executor, class R>
SelfStats SelfCollider<Executor, R>::facts() const {
  SelfStats facts = facts_;
  facts.substeps_kinematic_penetration = memory_.substeps_kinematic_penetration;
  facts.candidates = search_.candidates(), facts.pairs = search_.found(), facts.colours = search_.colours();
  return facts;
}

template <class Executor, class R>
std::size_t SelfCollider<Executor, R>::bytes() const {
  return takes_part_.bytes() + x0_.bytes() + moved_.bytes() + search_.bytes() + closable_gap_.bytes() +
         violations_.bytes() + states_.bytes() + fraction_.bytes() + nearest_.bytes() + checks_.bytes() +
         saved_motion_.bytes() + runs_.bytes() + truncation_sums_.bytes() + truncated_motions_.bytes() +
         chosen_.bytes();
}

template <class Executor, class R>
SelfMemory<R> SelfCollider<Executor, R>::save_state() const {
  SelfMemory<R> memory;
  memory.x0 = without_padding(x0_.template download<std::array<R, 3>>());
  for (const Vec4<R>& a : without_padding(search_.from().download())) memory.from.push_back({a.x, a.y, a.z, a.w});
  for (const Vec4<R>& a : without_padding(search_.way().download())) memory.way.push_back({a.x, a.y, a.z});
  memory.contact_distance = x0_.download_fourth(count_);
  memory.search = {memory_};
  return memory;
}

template <class Executor, class R>
void SelfCollider<Executor, R>::restore_state(const SelfMemory<R>& memory) {
  std::vector<std::array<R, 3>> x0 = memory.x0;
  x0.push_back({});
  x0_.upload(x0), x0_.upload_fourth(memory.contact_distance);
  overlaps_ = true;
  memory_ = memory.search.at(0), substep_ = 0;
  if (memory_.valid == 0) return;
  std::vector<Vec4<R>> from, way;
  for (const auto& a : memory.from) from.push_back({a[0], a[1], a[2], a[3]});
  for (const auto& a : memory.way) way.push_back({a[0], a[1], a[2], R(0)});
  from.push_back({}), way.push_back({});
  search_.start_from(from, way);
  search_.search_again();
}

// Compiled once a precision (self_collider_float.cpp, self_collider_double.cpp): they hold many kernels.
extern template class SelfCollider<OpenMP, float>;
extern template class SelfCollider<OpenMP, double>;

}  // namespace malha
