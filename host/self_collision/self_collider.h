// SPDX-License-Identifier: Apache-2.0
// Self-collision of deformable bodies: a broad phase whose candidates serve several substeps, contacts of near pairs,
// their projection, and the guarantee that no primitives intersect. Made only for scenes that name self_collision.
//
// The guarantee rests on three facts: (1) the start, the end and the truncated position of every particle lie in its
// swept bounds of the last broad phase, or it is clamped to them, or the broad phase runs again; (2) a pair that is no
// candidate cannot come nearer than its minimum distance while all particles stay in their bounds; (3) every candidate
// pair has a plane that separates its sides at the start and must separate them at the end, or its displacements are
// truncated.
//
// Each state has one owner: the start positions with their origin, the distances that pairs keep and the
// displacements ParticleTrajectories, the swept bounds PairSearch, the pairs with their contacts and
// violations SelfContacts, and the momenta of jammed bodies JamCorrector. The collider has the algorithm, and what
// the final guard may still do in a substep.
#pragma once
#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "host/measure/solver_stats.h"
#include "host/self_collision/jam_corrector.h"
#include "host/self_collision/pair_search.h"
#include "host/self_collision/particle_trajectories.h"

namespace malha {

template <class Executor, class R>
class SelfCollider {
 public:
  /// `particles`: at the start.
  SelfCollider(const Executor& executor, const Model& model, const Particles<R>& particles);

  /// Starts a substep. Contacts are detected in its first projection, when the predicted positions are known.
  void start_substep() {
    contacts_.start_substep(), jam_.start_substep(), budget_ = {};
    if (search_.has_crossings() && substep_ == 0) exclude_initial_intersections();
  }

  /// One projection of all contacts.
  void solve_contacts(const Particles<R>& particles) {
    trajectories_.load(particles);
    if (!contacts_.detected()) search_.update(motions(), contacts_), narrow_phase();
    project_contacts(particles);
  }

  /// Final guard of a substep: no primitives intersect afterwards. Displacements of a jam are truncated; where
  /// nothing is pinned or touches the environment, end_substep() gives bodies their momentum back. `owners`: of
  /// particles that environment objects have moved in this substep, and whose inverse mass is 0. Returns whether
  /// anything had to move.
  bool resolve_intersections(const Particles<R>& particles, const std::function<bool()>& has_environment_contacts,
                             const KinematicOwners& owners = {});

  /// Notes whether guards that ran last have moved bodies through each other.
  void note_intersections(const Particles<R>& particles) {
    trajectories_.load(particles);
    if (outside() > 0) detect({0, 0, 0}, 1);
    kinematic_penetration_ = violations_at_end() > 0 || kinematic_penetration_;
  }

  /// Returns true if a kinematic particle may have gone through a body in this substep.
  bool has_kinematic_penetration() const { return kinematic_penetration_; }

  /// See JamCorrector.
  void note_truncation(const Particles<R>& particles, bool lifts) { jam_.note_truncation(particles, motions(), lifts); }

  /// Stores the positions from which the next substep starts, after one of h seconds. Bodies in a jam get their momenta
  /// back, or, where pins or objects (at most as fast as `object_speed`, m/s) push them, are not much faster than
  /// those.
  void end_substep(const Particles<R>& particles, double h, double object_speed) {
    jam_.end_substep(particles, motions(), h, object_speed);
    trajectories_.start_from(particles);
    substep_ = substep_ + 1 < substeps_ ? substep_ + 1 : 0;
    if (substep_ == 0) update_origin(particles);
    if (kinematic_penetration_) ++facts_.substeps_kinematic_penetration;
    kinematic_penetration_ = false;
  }

  /// Starts from positions that were set from outside and in which nothing intersects.
  void start_from(const Particles<R>& particles) { trajectories_.start_from(particles), update_origin(particles); }

  /// Pairs that are nearer than the thickness now keep their distance until they separate by themselves
  /// (kernels/self_collision/contact_distance.h).
  void keep_overlaps() { trajectories_.keep_overlaps(); }

  /// Number of contacts that pushed in the last substep.
  int contacts() const { return contacts_.pushes(); }

  const SelfSurface& surface() const { return surface_; }
  SelfStats facts() const {
    SelfStats facts = facts_;
    facts.searches = search_.searches();
    facts.candidates = contacts_.candidates(), facts.pairs = contacts_.found(), facts.colours = contacts_.colours();
    return facts;
  }
  std::size_t bytes() const {
    return trajectories_.bytes() + search_.bytes() + contacts_.bytes() + jam_.bytes() + states_.bytes() +
           fraction_.bytes();
  }

  /// The state that later substeps depend on, for checkpoints.
  SelfMemory<R> save_state() const {
    SelfMemory<R> memory;
    trajectories_.save(memory), search_.save(memory);
    memory.substeps_kinematic_penetration = {facts_.substeps_kinematic_penetration};
    return memory;
  }
  void restore_state(const SelfMemory<R>& memory) {
    contacts_.start_substep();
    trajectories_.restore(memory), search_.restore(memory, contacts_);
    facts_.substeps_kinematic_penetration = memory.substeps_kinematic_penetration.at(0), substep_ = 0;
  }

 private:
  static constexpr int kGrain = 8192;
  static constexpr int kMoreProjections = 8;
  static constexpr double kRounding = 0.05;  // of the least gap

  static double thickness(const Model& model) { return model.scene.self_collision->thickness; }
  static SelfStats facts_at_start(const Model& model, const SelfSurface& surface) {
    SelfStats facts{.particles = surface.particles, .edges = surface.edges, .triangles = surface.triangles};
    if (model.scene.self_collision->ignores_crossings) facts.crossings = std::ssize(crossings_at_start(model, surface));
    return facts;
  }
  static std::size_t first_of(const SelfSurface& surface) {
    const auto at = std::ranges::find(surface.takes_part, 1);
    return at == surface.takes_part.end() ? 0 : static_cast<std::size_t>(at - surface.takes_part.begin());
  }

  Trajectories<R> motions() const { return trajectories_.view(); }
  void update_origin(const Particles<R>& particles) {
    if (trajectories_.update_origin(particles)) search_.invalidate();
  }
  /// Excludes pairs around intersections of the initial state that persist.
  void exclude_initial_intersections() {
    const auto found = crossings_and_touches(surface_, trajectories_.start_positions());
    std::vector<CrossingBodies> crosses(found.empty() ? 0 : count_, 0);
    for (const auto& [edge, triangle] : found) {
      const CrossingBodies both = crossing_bit(surface_.body[edge[0]], surface_.body[triangle[0]]);
      for (const int i : edge) crosses[i] |= both;
      for (const int i : triangle) crosses[i] |= both;
    }
    search_.exclude(crosses);
    trajectories_.mark_crossing(search_.crosses());
  }

  void narrow_phase() {
    trajectories_.grow_contact_distances(contacts_);
    contacts_.detect(motions());
  }
  void project_contacts(const Particles<R>& particles) {
    contacts_.solve(motions(), particles.friction);
    trajectories_.store(particles);
  }

  /// Broad and narrow phase along the present motion: see PairSearch::search.
  void detect(const Vector3<double>& rest_motion, int ahead) {
    search_.search(motions(), rest_motion, ahead, contacts_);
    narrow_phase();
  }
  /// Number of particles outside of their swept bounds.
  double outside() const { return search_.check_bounds(motions()).outside; }
  /// Clamps particles to their swept bounds. Kinematic ones stay where they are, and are searched for.
  void keep_in_bounds(const Particles<R>& particles) {
    search_.clamp_to_bounds(motions(), particles.p);
    if (outside() > 0) detect({0, 0, 0}, 1);
  }

  // Numbers of pairs that would intersect: see SelfContacts.
  int violations() {
    return budget_.projects ? resolvable(contacts_.violations_to_project(motions())) : violations_at_end();
  }
  int violations_at_end() { return resolvable(contacts_.violations_at_end(motions())); }
  int resolvable(const ViolationCount& count) {
    kinematic_penetration_ = kinematic_penetration_ || count.immovable > 0;
    return count.resolvable;
  }

  /// Stores displacements that kinematic particles have changed. Particles that leave their bounds are kept in them, or
  /// searched for where they are too many.
  void apply_motion(const Particles<R>& particles) {
    trajectories_.store(particles), trajectories_.load(particles);
    const double left_bounds = outside();
    if (left_bounds > search_.most_clamped())
      detect({0, 0, 0}, 1);
    else if (left_bounds > 0)
      keep_in_bounds(particles);
  }
  /// Truncates displacements until no pair would intersect. Particles of bodies whose momenta are restored move with
  /// the mean motion of these; others are at rest in the world. Returns whether any displacement was truncated.
  bool truncate(const Particles<R>& particles, MotionState* states);

  /// The budget says what the guard may still do in a substep. It projects in its first call: later that hardly ever
  /// helps.
  struct Budget {
    bool projects = true;
    int pushes = 8, kinematic_moves = 16;
  };

  Executor executor_;
  SelfSurface surface_;
  int count_, substeps_, substep_ = 0;  // particles; substeps of a step, and since it began
  SelfStats facts_;
  ParticleTrajectories<Executor, R> trajectories_;
  PairSearch<Executor, R> search_;
  SelfContacts<Executor, R> contacts_;
  JamCorrector<Executor, R> jam_;
  Budget budget_;
  bool kinematic_penetration_ = false;   // whether a kinematic particle went through a body in this substep
  Array<Executor, MotionState> states_;  // Unchanged, except during a guard
  Array<Executor, R> fraction_;          // see MarkViolating
};

template <class Executor, class R>
SelfCollider<Executor, R>::SelfCollider(const Executor& executor, const Model& model, const Particles<R>& particles)
    : executor_(executor),
      surface_(self_surface(model)),
      count_(model.count()),
      substeps_(model.scene.solver.substeps),
      facts_(facts_at_start(model, surface_)),
      trajectories_(executor, particles, model.x, first_of(surface_), thickness(model), model.thickness_factor,
                    kRounding * double(SelfContacts<Executor, R>::least_gap(thickness(model)))),
      search_(executor, surface_, model.x, thickness(model), trajectories_.origin(), facts_.crossings > 0,
              at_rest_in_bodies(model)),
      contacts_(executor, count_, search_.clusters(), thickness(model), model.scene.self_collision->friction,
                model.scene.solver.dt / substeps_),
      jam_(executor, surface_) {
  const auto rows = static_cast<std::size_t>(count_) + 1;  // a row of padding
  states_ = Array<Executor, MotionState>(rows, MotionState::Unchanged);
  fraction_ = Array<Executor, R>(rows, R(0));
}

/// The steps are bounds, broad phase, narrow phase, projection, pushes by kinematic particles, truncation, and motion
/// with kinematic particles, each only if what precedes it leaves pairs that would intersect.
template <class Executor, class R>
bool SelfCollider<Executor, R>::resolve_intersections(const Particles<R>& particles,
                                                      const std::function<bool()>& has_environment_contacts,
                                                      const KinematicOwners& owners) {
  kinematic_penetration_ = false;
  trajectories_.load(particles);
  double left_bounds = outside();
  // Motions that were larger than predicted are searched along, once. Particles that objects have moved since the first
  // call are not clamped: the objects would move them again.
  if (left_bounds > (budget_.projects ? search_.most_clamped_at_end() : 0)) {
    detect({0, 0, 0}, search_.horizon());
    left_bounds = outside();
  }
  const bool in_bounds = left_bounds == 0;
  int left = in_bounds ? violations() : 0;
  if (in_bounds && left == 0) return false;
  const CountFixed<R> fixed{particles.w, search_.takes_part()};
  const bool any_fixed = parallel_reduce<Sum>(executor_, count_, fixed, kGrain).value != 0;
  jam_.save_motion(particles, motions(), any_fixed || has_environment_contacts());

  if (!in_bounds) keep_in_bounds(particles), left = violations();
  for (int more = 0; left > 0 && budget_.projects && more < kMoreProjections; ++more) {
    project_contacts(particles);
    trajectories_.load(particles), search_.clamp_to_bounds(motions(), particles.p);
    left = violations();
  }
  budget_.projects = false;
  if (left == 0) return true;

  MotionState* const states = states_.data();
  const MarkPushing<R> mark_pushing{motions(), states};
  const bool driven = any_fixed && parallel_reduce<Sum>(executor_, count_, mark_pushing, kGrain).value > 0;
  for (; driven && budget_.pushes > 0 && violations_at_end() > 0; --budget_.pushes) {
    contacts_.push_by_kinematic(motions(), states);
    apply_motion(particles);
  }
  bool truncated = false;
  for (bool again = true; again;) {
    truncated = truncate(particles, states) || truncated;
    left = driven ? violations_at_end() : 0;
    // Particles that kinematic ones still penetrate move with these, and others must make way for them.
    again = left > 0 && budget_.kinematic_moves-- > 0 && contacts_.move_with_kinematic(motions(), owners, states);
    if (again) apply_motion(particles);
  }
  if (left > 0) kinematic_penetration_ = true;
  if (truncated) ++facts_.substeps_truncated;
  Memory<Executor>::fill(states, count_ + 1, MotionState::Unchanged);
  return true;
}

template <class Executor, class R>
bool SelfCollider<Executor, R>::truncate(const Particles<R>& particles, MotionState* states) {
  R* const fraction = fraction_.data();
  Vector3<double> rest_motion{0, 0, 0};
  if (jam_.restores_momenta() && violations_at_end() > 0) {
    contacts_.mark_violating(motions(), states, fraction);
    rest_motion = jam_.motion_of_truncated(motions(), states, trajectories_.max_rounding());
    Memory<Executor>::fill(states, count_ + 1, MotionState::Unchanged);
  }
  // A truncated particle that moves with its body may leave its bounds. Then search along the paths of this substep.
  if (search_.check_bounds(motions(), rest_motion).outside_if_truncated > 0) {
    detect(rest_motion, 1);
    search_.invalidate();
  }
  const auto violations = [&] { return resolvable(contacts_.violations_to_truncate(motions(), states)); };
  const int found = violations();
  for (int left = found; left > 0; left = violations()) {
    contacts_.compute_truncation(motions(), states, fraction, rounded<R>(rest_motion));
    const TruncateDisplacements<R> truncate{motions(), particles.p, fraction, states, rounded<R>(rest_motion)};
    parallel_for(executor_, count_, truncate, kGrain);
  }
  return found > 0;
}

// Compiled once a precision (self_collider_float.cpp, self_collider_double.cpp): they hold many kernels.
extern template class SelfCollider<OpenMP, float>;
extern template class SelfCollider<OpenMP, double>;

}  // namespace malha
