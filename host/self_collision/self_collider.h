// SPDX-License-Identifier: Apache-2.0
// Deformable bodies against themselves and each other, substep by substep: pairs from a search that serves some
// substeps, contacts of those that are near, their projection, and the guarantee that nothing crosses. Made only for
// scenes that name self_collision.
//
// What keeps the guarantee: (1) start, end and hold point of every particle lie in the box that it was searched with,
// or it is searched again; (2) a pair that was not kept cannot come as near as is wanted while all stay in their boxes;
// (3) every pair that was kept has a plane that parts it at the start, and must part it at the end, or it is held.
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

  /// Contacts are laid with the first projection of a substep, when it is known where all would go.
  void start_substep() {
    contacts_valid_ = false, cached_contact_count_ = -1, gives_back_ = Returns::Nothing;
    pushes_ = true, drives_left_ = kMostDrives, carries_left_ = kMostCarries;
    if (last_.crosses == 1 && substep_ == 0) leave_out_crossings();
  }

  /// One projection of all contacts.
  void solve_contacts(const Particles<R>& particles);

  /// The end of a substep: nothing crosses. What jams is held back; where touches() says that nothing holds the bodies,
  /// they keep their momentum all the same. `carriers`: of what others move by now; it has no inverse mass. Returns
  /// whether anything had to move.
  bool hold_apart(const Particles<R>& particles, const std::function<bool()>& touches, const Carriers& carriers = {});

  /// After others have had the last word: whether they sent bodies through each other.
  void note_crossing(const Particles<R>& particles) {
    store_motion(particles);
    if (look_where_all_are(within_rounding<R>()).outside > 0) note_pushed(), search(common(), 1), look();
    kinematic_penetration_ = count_violations(false, nullptr) > 0 || kinematic_penetration_;
  }

  /// Whether what is fixed may have gone through a body, as far as is known.
  bool went_through() const { return kinematic_penetration_; }

  /// Before velocities are taken from how far all went. Where a mesh `lifts` what was then held back, the way back is
  /// no speed.
  void note_held(const Particles<R>& particles, bool lifts) {
    if (gives_back_ == Returns::Nothing) return;  // nothing was held
    if (lifts) parallel_for(executor_, count_, ForgetLift<R>{particles, x0_.points(), origin()}, kGrain);
    parallel_for(executor_, count_, NoteChange<R>{particles.p, x0_.points(), origin(), before_.data()}, kGrain);
  }

  /// Where all is now is where the next substep begins, after one of h seconds. What jammed gets its momenta back, or,
  /// where pins or objects (at most as fast as `objects`, m/s) drive it, is not much faster than those.
  void end_substep(const Particles<R>& particles, double h, double objects);

  /// Others have put all where it is now, and nothing crosses there.
  void start_from(const Particles<R>& particles) { note_places(particles), stay_near(particles); }

  /// What is nearer than the thickness now stays as near until it opens by itself
  /// (kernels/self_collision/contact_distance.h).
  void keep_overlaps() {
    parallel_for(executor_, count_, ResetContactDistances<R>{x0_.points().of, R(thickness_)}, kGrain);
    overlaps_ = true;
  }

  /// Contacts that pushed in the last substep.
  int contacts() const;

  const SelfSurface& surface() const { return surface_; }
  SelfStats facts() const;
  std::size_t bytes() const;

  /// What a later substep depends on, for checkpoints.
  SelfMemory<R> save_state() const;
  void restore_state(const SelfMemory<R>& memory);

 private:
  using Points4 = ScatteredArray<Executor, R>;
  enum class Returns { Nothing, Momenta, Speed };  // of what jammed, at the end of a substep

  static constexpr int kGrain = PairSearch<Executor, R>::kGrain;
  static constexpr int kMoreProjections = 8;
  static constexpr int kMostDrives = 8, kMostCarries = 16;  // in a substep, whatever jams
  static constexpr double kMostSpeed = 2;                   // of what drives a jam, if nothing in it was faster
  static constexpr double kLong = 0.01;  // s: in longer substeps a layer falls so far that one sweep is far from even
  static constexpr int kLongSweeps = 3;
  static constexpr double kNear = 0.1;         // of the thickness: what comes as near in a substep may be pushed
  static constexpr double kFit = 0.5;          // of what lies beyond a way: constraints may take the rest
  static constexpr double kLeastGap = 0.02;    // of the thickness
  static constexpr double kRounding = 0.05;    // of the least gap
  static constexpr double kNearOrigin = 0.25;  // of how far from the origin rounding takes as much

  static BroadPhaseParams<R> search_rules(double thickness) {
    return {R(0.1 * thickness), R(0.25), R(thickness), R(0.5 * thickness)};
  }
  static ContactParams<R> near_rules(double h, double thickness) {
    return {R(recovery_share(h)), R(kNear * thickness), R(kLeastGap * thickness)};
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

  Vector3<R> origin() const { return to_R(last_.origin); }
  /// `first_` may be so far from the origin, m.
  double reach_of_origin() const {
    return kNearOrigin * kRounding * double(rules_.least) / std::numeric_limits<R>::epsilon();
  }
  /// The one of before, or `first`, if that is too far from it. Types that carry nothing of places have none but 0.
  Vec3 origin_near(const Vec3& first, const Vec3& before) const {
    const Vec3 way = minus(first, before);
    const double apart = std::max({std::abs(way[0]), std::abs(way[1]), std::abs(way[2])});
    if (!kCompensated<R> || !(apart > reach_of_origin()) || !(apart < double(std::numeric_limits<R>::max())))
      return before;
    return {double(R(first[0])), double(R(first[1])), double(R(first[2]))};
  }
  void note_places(const Particles<R>& particles) {
    parallel_for(executor_, count_, CopyPoints<R, FromOrigin<R>>{{particles.p, origin()}, x0_.points()});
  }
  /// The origin follows those that take part. What was searched was told from the one of before.
  void stay_near(const Particles<R>& particles) {
    if constexpr (!kCompensated<R>) return;
    Vec3 first = x0_.get(first_);
    for (int k = 0; k < 3; ++k) first[k] += last_.origin[k];
    const Vec3 origin = origin_near(first, last_.origin);
    if (origin == last_.origin) return;
    last_.origin = origin, last_.valid = 0;
    note_places(particles);
  }

  Trajectories<R> motions() const { return {x0_.points().of, moved_.points().of, origin()}; }
  CommonFrame<R> frame() const { return {to_R(last_.frame_offset), to_R(last_.frame_velocity)}; }
  void store_motion(const Particles<R>& particles) {
    parallel_for(executor_, count_, ComputeDisplacements<R>{particles.p, particles.w, motions()}, kGrain);
  }

  SumMotion<R> sum_motion() const { return {moved_.points(), takes_part_.data()}; }
  /// `moves`, `rest`: see CheckSweptBounds.
  CheckSweptBounds<R> stay_in_reach(double share, const Vector3<R>* moves = nullptr, const Vec3& rest = {}) const {
    return {motions(), search_.reach(), frame(), moves, R(share), takes_part_.data(), to_R(rest)};
  }
  /// How far all move alike, m.
  static Vec3 common(const MeanMotion& mean) {
    const Vector3<double> a = mean.value();
    return {a.x, a.y, a.z};
  }
  Vec3 common() const { return common(parallel_reduce<MeanMotion>(executor_, count_, sum_motion(), kGrain)); }
  BoundsViolations look_where_all_are(double share, const Vec3& rest = {}) const {
    return parallel_reduce<BoundsViolations>(executor_, count_, stay_in_reach(share, nullptr, rest), kGrain);
  }
  /// How far all move alike, and where they are if the frame moves so.
  SelfChecks<R> look_at_the_start() const {
    SelfChecks<R>* const checks = checks_.data();
    parallel_reduce_into(executor_, count_, sum_motion(), &checks->mean, kGrain);
    parallel_for(executor_, 1, FindCommon<R>{checks});
    parallel_reduce_into(executor_, count_, stay_in_reach(kFit, &checks->common), &checks->stay, kGrain);
    return checks_.get(0);
  }
  /// Where all are and, if they stay in their boxes, how many pairs are about to cross (ViolationCount). A device finds
  /// both before it is asked: pairs of what leaves its box are searched anew.
  std::pair<BoundsViolations, int> look_at_the_end() {
    if constexpr (Memory<Executor>::kOnHost) {
      const BoundsViolations stay = look_where_all_are(within_rounding<R>());
      return {stay, stay.outside == 0 ? count_violations(pushes_, nullptr) : 0};
    } else {
      SelfChecks<R>* const checks = checks_.data();
      parallel_reduce_into(executor_, count_, stay_in_reach(within_rounding<R>()), &checks->stay);
      find_violations(pushes_, nullptr);
      parallel_reduce_into(executor_, search_.units(), SumLeft<R>{search_.pairs(), left_.data()}, &checks->left);
      const SelfChecks<R> found = checks_.get(0);
      return {found.stay, found.stay.outside == 0 ? can_be_held(found.left) : 0};
    }
  }
  /// From here and now on, in a frame that moves so in this substep, so many substeps ahead.
  void search(const Vec3& moves, int ahead) {
    last_.frame_offset = {}, last_.frame_velocity = moves, last_.valid = last_.age = 1;
    search_.search(motions(), to_R(moves), ahead);
    ++facts_.searches;
  }

  /// What may meet in this substep, and its contacts.
  void update_contacts() {
    for (int k = 0; k < 3; ++k) last_.frame_offset[k] += last_.frame_velocity[k];
    const SelfChecks<R> checks = look_at_the_start();
    last_.frame_velocity = common(checks.mean);
    if (!last_.valid || checks.stay.outside > 0) {
      // As far ahead as the last one served; farther, where it served as long as it was to.
      last_.horizon = last_.age < last_.horizon ? last_.age : std::min(2 * last_.horizon, SearchMemory::kMostAhead);
      search(last_.frame_velocity, last_.horizon);
    } else {
      ++last_.age;
    }
    look();
    contacts_valid_ = true;
  }
  /// Around what crossed at the start and still does, pairs take no part.
  void leave_out_crossings() {
    const auto found = crossings_and_touches(surface_, without_padding(x0_.template download<Vec3>()));
    std::vector<CrossingBodies> crosses(found.empty() ? 0 : count_, 0);
    for (const auto& [edge, triangle] : found) {
      const CrossingBodies both = crossing_bit(surface_.body[edge[0]], surface_.body[triangle[0]]);
      for (const int i : edge) crosses[i] |= both;
      for (const int i : triangle) crosses[i] |= both;
    }
    search_.leave_out(crosses);
    parallel_for(executor_, count_, MarkCrossingBodies<R>{x0_.points().of, R(thickness_), search_.crosses()}, kGrain);
    last_.valid = 0, last_.crosses = found.empty() ? 0 : 1;
    overlaps_ = true;
  }

  void grow_contact_distances() {
    R* const nearest = nearest_.at_least(count_ + 1);
    Memory<Executor>::fill(nearest, count_ + 1, R(INFINITY));
    const FindNearestPairs<R> find{motions(), search_.pairs(), nearest};
    search_.region([&](const auto& team) { search_.in_phases(team, find); });
    const GrowContactDistances<R> grow{x0_.points().of, R(thickness_), nearest};
    overlaps_ = parallel_reduce<Sum>(executor_, count_, grow, kGrain).value > 0;
    if (!overlaps_) nearest_ = {};
  }

  void look() {
    if (overlaps_) grow_contact_distances();
    const NarrowPhase<R> look{motions(), search_.pairs(), rules_, room_.data()};
    search_.at_once(look);
  }
  void project_contacts(const Particles<R>& particles) {
    const auto with = [&]<bool rubs>() {
      const SolveContacts<R, rubs> push{search_.pairs(), moved_.points().of, friction_};
      search_.region([&](const auto& team) {
        for (int sweep = 0; sweep < sweeps_; ++sweep) search_.in_phases(team, push);
      });
    };
    friction_ > R(0) ? with.template operator()<true>() : with.template operator()<false>();
    parallel_for(executor_, count_, ApplyDisplacements<R>{motions(), particles.p}, kGrain);
  }

  SearchMemory start_near(const Model& model) const {
    SearchMemory start;
    if (!model.x.empty()) start.origin = origin_near(model.x[first_], {});
    return start;
  }
  /// These from the origin, as Displaced::near() has them, and a place of padding.
  std::vector<Vec3> places(const std::vector<Vec3>& x) const {
    std::vector<Vec3> all;
    for (const Vec3& a : x) {
      Vec3& place = all.emplace_back();
      for (int k = 0; k < 3; ++k) {
        const R stored = R(a[k]);
        place[k] = kCompensated<R> ? (stored - R(last_.origin[k])) + R(a[k] - double(stored)) : stored;
      }
    }
    all.push_back({0, 0, 0});
    return all;
  }

  int count_pushes() const {
    return static_cast<int>(parallel_reduce<Sum>(executor_, search_.units(), CountPushes<R>{search_.pairs()}).value);
  }
  /// Before others are laid in the same substep.
  void note_pushed() {
    if (cached_contact_count_ < 0) cached_contact_count_ = count_pushes();
  }

  /// Where all would go before any is held, once a substep.
  void note_motion(const Particles<R>& particles) {
    if (gives_back_ != Returns::Nothing) return;
    parallel_for(executor_, count_, NoteMotion<R>{particles.v, motions(), before_.at_least(count_)}, kGrain);
    if (runs_.size() == 0) lay_out_runs();
    gives_back_ = Returns::Momenta;
  }
  /// Particles that take part, body by body.
  void lay_out_runs() {
    std::vector<int> body(count_);
    for (int i = 0; i < count_; ++i) body[i] = surface_.takes_part[i] ? surface_.body[i] : -1;
    const std::vector<ParticleRun> runs = particle_runs(body);
    runs_ = Array<Executor, ParticleRun>(runs);
    held_sums_ = Array<Executor, HeldSums>(runs.size(), HeldSums{});
    held_motions_ = Array<Executor, HeldMotion>(runs.size(), HeldMotion{});
    chosen_ = Array<Executor, int>(runs.size(), 0);
  }
  int runs() const { return static_cast<int>(runs_.size()); }

  /// Gives bodies of which something was held the momenta that this took, or keeps them from what their drivers' push
  /// and the springs that this draws would make of their speed.
  void restore_momenta(const Particles<R>& particles, double h, double objects) {
    parallel_for(executor_, runs(),
                 SumHeld<R>{particles, x0_.points(), origin(), before_.data(), 1 / h, runs_.data(), held_sums_.data()},
                 1);
    const std::vector<ParticleRun> runs = runs_.download();
    const std::vector<HeldSums> sums = held_sums_.download();
    std::vector<int> changed(surface_.body.empty() ? 0 : *std::ranges::max_element(surface_.body) + 1), chosen;
    for (std::size_t r = 0; r < runs.size(); ++r) changed[runs[r].group] |= sums[r].changed;
    HeldSums all;
    double pins = 0;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      chosen.push_back(changed[runs[r].group]);
      if (chosen.back()) all += sums[r];
      pins = std::max(pins, sums[r].pins);
    }
    chosen_.upload(chosen);
    if (gives_back_ == Returns::Speed) {
      const LimitSpeed<R> limit{particles, before_.data(), runs_.data(), chosen_.data(),
                                kMostSpeed * std::max(pins / h, objects)};
      if (limit.most > 0) parallel_for(executor_, this->runs(), limit, 1);
      return;
    }
    const RigidGain gain = rigid_return(all);
    parallel_for(executor_, this->runs(),
                 AddRigidGain<R>{particles, x0_.points(), origin(), runs_.data(), chosen_.data(), gain.kept,
                                 gain.centre, gain.velocity, gain.omega},
                 1);
  }

  /// Bodies of which something is about to be held move so on the whole, m. They do not where that would round them
  /// through each other, far from what the origin follows.
  Vec3 motion_of_held() {
    parallel_for(executor_, runs(), SumHeldMotion<R>{motions(), held_.data(), runs_.data(), held_motions_.data()}, 1);
    HeldMotion all;
    for (const HeldMotion& one : held_motions_.download())
      all.mean += one.mean, all.farthest = std::max(all.farthest, one.farthest);
    const bool fine = all.farthest * std::numeric_limits<R>::epsilon() < kRounding * double(rules_.least);
    return fine ? common(all.mean) : Vec3{};
  }

  void keep_in_reach(const Particles<R>& particles) {
    parallel_for(executor_, count_,
                 ClampToSweptBounds<R>{motions(), search_.reach(), frame(), particles.p, takes_part_.data()}, kGrain);
  }

  /// How many pairs are about to cross that holding back can still help.
  int count_violations(bool adds, const MotionState* held) {
    find_violations(adds, held);
    return can_be_held(sum_left());
  }
  void find_violations(bool adds, const MotionState* held) {
    search_.at_once(FindViolations<R>{motions(), search_.pairs(), rules_, room_.data(), adds, held, left_.data()});
  }
  int can_be_held(const ViolationCount& left) {
    kinematic_penetration_ = kinematic_penetration_ || left.fixed > 0;
    return left.free;
  }
  ViolationCount sum_left() const {
    return parallel_reduce<ViolationCount>(executor_, search_.units(), SumLeft<R>{search_.pairs(), left_.data()});
  }

  /// `left`: pairs that are about to cross, if all are in their boxes. `carriers`: none where nothing is fixed. `free`:
  /// whether nothing else holds the bodies either.
  void hold_crossing(const Particles<R>& particles, const BoundsViolations& stay, int left, const Carriers* carriers,
                     bool free) {
    if (stay.outside > 0) keep_in_reach(particles), left = count_violations(pushes_, nullptr);
    // Once a substep: where something was driven or carried since, they hardly ever help.
    for (int more = 0; left > 0 && pushes_ && more < kMoreProjections; ++more) {
      project_contacts(particles);
      store_motion(particles);
      keep_in_reach(particles);
      left = count_violations(pushes_, nullptr);
    }
    pushes_ = false;
    if (left == 0) return;
    bool any = false;
    if (carriers != nullptr && push_by_kinematic(particles)) {
      do {
        any = truncate_displacements(particles, false) || any;
      } while ((left = count_violations(false, nullptr)) > 0 && carries_left_-- > 0 &&
               move_with_kinematic(particles, *carriers));
      kinematic_penetration_ = kinematic_penetration_ || left > 0;
    } else {
      any = truncate_displacements(particles, free);
    }
    if (any) ++facts_.held;
    Memory<Executor>::fill(held_.at_least(count_ + 1), count_ + 1, MotionState::Free);
  }

  /// What pins would go through is driven before them. Returns whether any do.
  bool push_by_kinematic(const Particles<R>& particles) {
    const MarkDriven<R> mark{motions(), held_.at_least(count_ + 1)};
    if (parallel_reduce<Sum>(executor_, count_, mark, kGrain).value == 0) return false;
    for (; drives_left_ > 0 && count_violations(false, nullptr) > 0; --drives_left_) {
      const PushByKinematic<R> drive{motions(), search_.pairs(), rules_, left_.data(), held_.at_least(count_ + 1)};
      search_.region([&](const auto& team) { search_.in_phases(team, drive); });
      take_motion(particles);
    }
    return true;
  }
  /// What pins went through all the same is carried with them. Returns whether anything is.
  bool move_with_kinematic(const Particles<R>& particles, const Carriers& carriers) {
    const MoveWithKinematic<R> carry{motions(), search_.pairs(), carriers, left_.data(), held_.data()};
    search_.region([&](const auto& team) { search_.in_phases(team, carry); });
    if (sum_left().free == 0) return false;
    take_motion(particles);
    return true;
  }
  /// Where particles moved to, and, where they left their boxes for it, what they may meet there. What is held is then
  /// at rest in the world: boxes that stand there serve for that too.
  void take_motion(const Particles<R>& particles) {
    parallel_for(executor_, count_, ApplyDisplacements<R>{motions(), particles.p}, kGrain);
    store_motion(particles);
    if (look_where_all_are(within_rounding<R>()).outside == 0) return;
    note_pushed();
    search({}, 1);
    look();
  }

  /// Returns whether anything had to be. `free`: what is held moves as its bodies do on the whole; else it is at rest
  /// in the world.
  bool truncate_displacements(const Particles<R>& particles, bool free) {
    MotionState* const held = held_.at_least(count_ + 1);
    R* const part = part_.at_least(count_ + 1);
    Vec3 rest{};
    if (free && count_violations(false, held) > 0) {
      const MarkViolating<R> mark{motions(), search_.pairs(), left_.data(), held, part};
      search_.region([&](const auto& team) { search_.in_phases(team, mark); });
      rest = motion_of_held();
      Memory<Executor>::fill(held, count_ + 1, MotionState::Free);
    }
    // That may lie outside of boxes that move with the common motion. What may be met there: all that lies on the ways
    // of this substep.
    if (look_where_all_are(within_rounding<R>(), rest).unheld > 0) {
      note_pushed();
      search(rest, 1);
      look();
      last_.valid = 0;
    }
    const int found = count_violations(false, held);
    for (int left = found; left > 0; left = count_violations(false, held)) {
      const MarkViolating<R> limit{motions(), search_.pairs(), left_.data(), held, part};
      const ComputeTruncation<R> parts{motions(), search_.pairs(), rules_, held, part, to_R(rest)};
      search_.region([&](const auto& team) { search_.in_phases(team, limit), search_.in_phases(team, parts); });
      parallel_for(executor_, count_, TruncateDisplacements<R>{motions(), particles.p, part, held, to_R(rest)}, kGrain);
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
  std::size_t first_ = 0;  // of those that take part: the origin follows it
  SearchMemory last_;
  PairSearch<Executor, R> search_;
  int sweeps_ = 1;  // over all contacts, a projection
  bool contacts_valid_ = false;
  bool overlaps_ = true;                // whether particles may have less than the thickness for their contact distance
  bool kinematic_penetration_ = false;  // whether something fixed went through a body in this substep
  int cached_contact_count_ = -1;       // contacts that did, where others were laid since
  SelfStats facts_;
  Array<Executor, unsigned char> takes_part_;
  Points4 x0_, moved_;
  Array<Executor, R> room_;
  Array<Executor, ViolationCount> left_;
  Array<Executor, SelfChecks<R>> checks_{1, SelfChecks<R>{}};
  ScratchBuffer<Executor, MotionState> held_;
  ScratchBuffer<Executor, R> part_, nearest_;
  bool pushes_ = true;                      // whether what is about to cross may still be projected in this substep
  int drives_left_ = 0, carries_left_ = 0;  // in this substep
  Returns gives_back_ = Returns::Nothing;
  ScratchBuffer<Executor, Vec4<R>> before_;  // see NoteMotion
  Array<Executor, ParticleRun> runs_;        // this and the following: made once something jams
  Array<Executor, HeldSums> held_sums_;
  Array<Executor, HeldMotion> held_motions_;
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
      rules_(near_rules(model.scene.solver.dt / substeps_, thickness_)),
      first_(first_of(surface_)),
      last_(start_near(model)),
      search_(executor, surface_, model.x, thickness_, search_rules(thickness_), last_.origin) {
  if (model.scene.self_collision->ignores_crossings) facts_.crossings = std::ssize(crossings_at_start(model, surface_));
  last_.crosses = facts_.crossings > 0 ? 1 : 0;
  facts_.particles = surface_.particles, facts_.edges = surface_.edges, facts_.triangles = surface_.triangles;
  const double h = model.scene.solver.dt / model.scene.solver.substeps;
  if (h > kLong) sweeps_ = kLongSweeps;
  takes_part_ = Array<Executor, unsigned char>(surface_.takes_part);
  x0_ = Points4(places(model.x)), moved_ = Points4(model.x.size() + 1);
  room_ = Array<Executor, R>(search_.units(), R(0)),
  left_ = Array<Executor, ViolationCount>(search_.units(), ViolationCount{});
}

template <class Executor, class R>
void SelfCollider<Executor, R>::solve_contacts(const Particles<R>& particles) {
  store_motion(particles);
  if (!contacts_valid_) update_contacts();
  project_contacts(particles);
}

template <class Executor, class R>
bool SelfCollider<Executor, R>::hold_apart(const Particles<R>& particles, const std::function<bool()>& touches,
                                           const Carriers& carriers) {
  kinematic_penetration_ = false;  // of the last word
  store_motion(particles);
  auto [stay, left] = look_at_the_end();
  if (stay.outside > 0) {  // further than was foreseen: what may be met on that way is looked for, once
    note_pushed();
    search(common(), last_.horizon);
    look();
    stay = look_where_all_are(within_rounding<R>());
    if (stay.outside == 0) left = count_violations(pushes_, nullptr);
  }
  if (stay.outside == 0 && left == 0) return false;
  const CountFixed<R> fixed{particles.w, takes_part_.data()};
  const bool free = parallel_reduce<Sum>(executor_, count_, fixed, kGrain).value == 0;
  note_motion(particles);
  if (!free || touches()) gives_back_ = Returns::Speed;
  hold_crossing(particles, stay, left, free ? nullptr : &carriers, gives_back_ == Returns::Momenta);
  return true;
}

template <class Executor, class R>
void SelfCollider<Executor, R>::end_substep(const Particles<R>& particles, double h, double objects) {
  if (gives_back_ != Returns::Nothing) restore_momenta(particles, h, objects);
  note_places(particles);
  substep_ = substep_ + 1 < substeps_ ? substep_ + 1 : 0;
  if (substep_ == 0) stay_near(particles);
  if (kinematic_penetration_) ++last_.driven_through;
  kinematic_penetration_ = false;
}

template <class Executor, class R>
int SelfCollider<Executor, R>::contacts() const {
  return cached_contact_count_ >= 0 ? cached_contact_count_ : count_pushes();
}

template <class Executor, class R>
SelfStats SelfCollider<Executor, R>::facts() const {
  SelfStats facts = facts_;
  facts.driven_through = last_.driven_through;
  facts.candidates = search_.candidates(), facts.pairs = search_.found(), facts.phases = search_.phases();
  return facts;
}

template <class Executor, class R>
std::size_t SelfCollider<Executor, R>::bytes() const {
  return takes_part_.bytes() + x0_.bytes() + moved_.bytes() + search_.bytes() + room_.bytes() + left_.bytes() +
         held_.bytes() + part_.bytes() + nearest_.bytes() + checks_.bytes() + before_.bytes() + runs_.bytes() +
         held_sums_.bytes() + held_motions_.bytes() + chosen_.bytes();
}

template <class Executor, class R>
SelfMemory<R> SelfCollider<Executor, R>::save_state() const {
  SelfMemory<R> memory;
  memory.x0 = without_padding(x0_.template download<std::array<R, 3>>());
  for (const Vec4<R>& a : without_padding(search_.from().download())) memory.from.push_back({a.x, a.y, a.z, a.w});
  for (const Vec4<R>& a : without_padding(search_.way().download())) memory.way.push_back({a.x, a.y, a.z});
  memory.contact_distance = x0_.download_fourth(count_);
  memory.search = {last_};
  return memory;
}

template <class Executor, class R>
void SelfCollider<Executor, R>::restore_state(const SelfMemory<R>& memory) {
  std::vector<std::array<R, 3>> x0 = memory.x0;
  x0.push_back({});
  x0_.upload(x0), x0_.upload_fourth(memory.contact_distance);
  overlaps_ = true;
  last_ = memory.search.at(0), substep_ = 0;
  if (last_.valid == 0) return;
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
