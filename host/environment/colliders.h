// SPDX-License-Identifier: Apache-2.0
// Colliders of the environment of a scene, as one: the kinds of objects that a scene has, each with a collider of its
// own. Made only for scenes that have an environment.
//
// A collider has these members; `particles` are in the solver's order, and a displacement p.d of a particle is that of
// the present substep:
//
//   set_poses(start, end)          the motion of its objects in a substep, s
//   end_motion()                   its objects rest where they are at the substep's end
//   append_motion(motion)          the motion of each object, world to world; objects() of them
//   moves()                        whether any object ever moves
//   detect_contacts(particles)     of the paths from x to p
//   solve_contacts(particles)      pushes particles out, with friction
//   restitute(particles, v, h)     once x and v are updated: sets v, and p where a particle bounces
//   bounces(), clamp_restitution(particles)   whether it may; cancels what would then cross an object
//   clamp_tunnelling(particles)    no path from x to p crosses an object, because p is moved in front of it
//   resolve_crossings(particles, marks, move_with_objects)   likewise, with marks on what it moves, which it tells
//   invalidate_contacts(particles), keep_overlaps(particles), contacts()
//   allocate_clearance(), max_contact_free_speed(particles, h, substeps, g)
//   max_penetration(particles, time), bytes()
#pragma once
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "host/base/point_array.h"
#include "host/environment/deforming_collider.h"
#include "host/environment/mesh_collider.h"
#include "host/environment/shape_collider.h"

namespace malha {

/// Moves the particles whose displacement differs from an earlier one back to where the substep began.
template <class R>
struct CancelChangedMotion {
  Displaced<R> p;
  Points<R> before;
  KERNEL void operator()(int i) const {
    if (!same(p.d[i], before[i])) p.clear_displacement(i);
  }
};

template <class Executor, class R>
class EnvironmentColliders {
 public:
  EnvironmentColliders(const Executor& executor, const Model& model) : executor_(executor) {
    const std::size_t shapes = shape_count(model), meshes = mesh_count(model);
    if (meshes > 0) meshes_.emplace(executor, model);
    if (shapes > 0) shapes_.emplace(executor, model);
    if (meshes + shapes < model.environment.size()) deforming_.emplace(executor, model);
    count_ = int(meshes_.has_value()) + int(shapes_.has_value()) + int(deforming_.has_value());
    if (count_ > 1) saved_displacements_ = PointArray<Executor, R>(model.x.size());
  }

  /// Detects the contacts of the paths from x to p, while the objects move from their poses at `start` to those at
  /// `end` (s).
  void detect_contacts(const Particles<R>& particles, double start, double end) {
    for_each([&](auto& one) { one.set_poses(start, end); });
    for_each([&](auto& one) { one.detect_contacts(particles); });
  }
  void solve_contacts(const Particles<R>& particles) {
    for_each([&](auto& one) { one.solve_contacts(particles); });
  }
  /// Applies restitution; nothing is moved through an object. See EnvironmentContacts.
  void restitute(const Particles<R>& particles, double resting_speed, double h) {
    for_each([&](auto& one) { one.restitute(particles, resting_speed, h); });
    if (bounces()) for_each([&](auto& one) { one.clamp_restitution(particles); });
  }
  bool bounces() const {
    return any_of([](const auto& one) { return one.bounces(); });
  }
  /// Number of contacts that pushed in the last substep.
  int contacts() const {
    int sum = 0;
    for_each([&](const auto& one) { sum += one.contacts(); });
    return sum;
  }
  /// Invalidates all contacts before substeps without contact detection.
  void invalidate_contacts(const Particles<R>& particles) {
    for_each([&](auto& one) { one.invalidate_contacts(particles); });
  }
  /// Lets particles that are nearer than the thickness now keep their distance until they move away by themselves.
  void keep_overlaps(const Particles<R>& particles) {
    for_each([&](auto& one) { one.keep_overlaps(particles); });
  }

  /// Final guard after the last iteration: clamps particles whose path crosses a surface, because constraints moved
  /// them farther than predicted. Where colliders push a particle at each other, it stays where the substep began.
  void clamp_tunnelling(const Particles<R>& particles) {
    if (count_ == 1) return for_each([&](auto& one) { one.clamp_tunnelling(particles); });
    resolve_in_turns(particles, {}, false);
  }
  /// Final guard after self-collision: particles that it has moved across a surface move with that object instead, from
  /// where the substep began. Without `move_with_objects` they are clamped in front of it instead. Marks them in
  /// `marks` as owned by their object. Returns whether any particle moved.
  bool resolve_crossings(const Particles<R>& particles, const KinematicMarks<R>& marks, bool move_with_objects) {
    bool moved = false;
    if (count_ == 1)
      for_each([&](auto& one) { moved = one.resolve_crossings(particles, marks, move_with_objects); });
    else
      moved = resolve_in_turns(particles, marks, move_with_objects);
    return moved;
  }
  /// Clamps particles after a substep of h seconds without contact detection in which some exceeded the speed limit;
  /// the state is that after the substep.
  void clamp_tunnelling_late(const Particles<R>& particles, double start, double h) {
    Particles<R> then = particles;
    then.x = then.p.x = before_.points();
    parallel_for(executor_, particles.count, ReconstructPrevious<R>{particles, then.x, R(h)});
    for_each([&](auto& one) { one.set_poses(start, start + h); });
    clamp_tunnelling(then);
    parallel_for(executor_, particles.count, CommitClamped<R>{particles, R(h), R(1 / h)});
  }

  /// Appends the motion of each object in this substep.
  void append_motion(std::vector<Pose>& motion) const {
    for_each([&](const auto& one) { one.append_motion(motion); });
  }
  /// Sets the objects to rest at their poses at the end of this substep.
  void end_motion() {
    for_each([](auto& one) { one.end_motion(); });
  }
  bool moves() const {
    return any_of([](const auto& one) { return one.moves(); });
  }

  /// Allocates memory for max_contact_free_speed() and clamp_tunnelling_late(), of this many particles.
  void allocate_clearance(std::size_t particles) {
    before_ = PointArray<Executor, R>(particles);
    for_each([](auto& one) { one.allocate_clearance(); });
  }
  /// Largest speed (m/s) of particles during the next `substeps` of h seconds at which none comes near enough to an
  /// object at rest for a contact or a clamp. 0: contacts must be detected. `g`: gravity, m/s^2.
  double max_contact_free_speed(const Particles<R>& particles, double h, int substeps, double g) {
    double speed = std::numeric_limits<double>::infinity();
    for_each([&](auto& one) {
      if (speed > 0) speed = std::min(speed, one.max_contact_free_speed(particles, h, substeps, g));
    });
    return speed;
  }

  /// Largest depth of a particle below a surface (m) at the given time, or when it was forced through one.
  double max_penetration(const Particles<R>& particles, double time) const {
    double deepest = 0;
    for_each([&](const auto& one) { deepest = std::max(deepest, one.max_penetration(particles, time)); });
    return deepest;
  }

  std::size_t bytes() const {
    std::size_t sum = saved_displacements_.bytes() + before_.bytes();
    for_each([&](const auto& one) { sum += one.bytes(); });
    return sum;
  }

  // Facts and state of deforming meshes; 0 and empty without.
  double fastest_vertex() const { return deforming_ ? deforming_->fastest_vertex() : 0; }
  std::vector<DeformingStats> deforming() const {
    return deforming_ ? deforming_->facts() : std::vector<DeformingStats>{};
  }
  int most_pinched() const { return deforming_ ? deforming_->most_pinched() : 0; }
  std::vector<float> overlaps() const { return deforming_ ? deforming_->overlaps() : std::vector<float>{}; }
  void restore_overlaps(const std::vector<float>& all) {
    if (deforming_) deforming_->restore_overlaps(all);
  }

  // Facts and state of rigid meshes.
  std::optional<ContactStats> facts() const { return meshes_ ? std::optional(meshes_->facts()) : std::nullopt; }
  /// Number of triangles of each mesh.
  std::vector<int> triangles() const { return meshes_ ? meshes_->triangles() : std::vector<int>{}; }
  // State for checkpoints, see MeshCollider.
  template <class F>
  void for_each_part(const F& f) const {
    if (meshes_) meshes_->for_each_part(f);
  }
  std::size_t box_count() const { return meshes_ ? meshes_->box_count() : 0; }
  std::size_t near_count() const { return meshes_ ? meshes_->near_count() : 0; }
  std::size_t max_entries() const { return meshes_ ? meshes_->max_entries() : 0; }
  void restore_state(const ProximityMemory& all) {
    if (meshes_) meshes_->restore_state(all);
  }
  // State of exact shapes.
  std::optional<ShapeMemory> save_shapes(std::size_t particles) const {
    return shapes_ ? std::optional(shapes_->save_state(particles)) : std::nullopt;
  }
  void restore_shapes(const ShapeMemory& memory, std::size_t particles) {
    if (shapes_) shapes_->restore_state(memory, particles);
  }
  /// Finds the overlaps of pairs that a layout has and another one had not: see ShapeCollider. Rigid meshes find theirs
  /// in the first query of a pair.
  void find_new_overlaps(const Particles<R>& particles, const LayoutMap& map, double time) {
    if (shapes_) shapes_->find_new_overlaps(particles, map, time);
    if (deforming_) deforming_->find_new_overlaps(particles, map, time);
  }

 private:
  static constexpr int kRounds = 8;  // as ClampTunnelling has of the meshes of one collider

  /// Calls work(collider) for the colliders that the scene has, in the order of their objects.
  template <class Work>
  void for_each(const Work& work) {
    if (meshes_) work(*meshes_);
    if (shapes_) work(*shapes_);
    if (deforming_) work(*deforming_);
  }
  template <class Work>
  void for_each(const Work& work) const {
    if (meshes_) work(*meshes_);
    if (shapes_) work(*shapes_);
    if (deforming_) work(*deforming_);
  }
  template <class Test>
  bool any_of(const Test& test) const {
    bool any = false;
    for_each([&](const auto& one) { any = any || test(one); });
    return any;
  }

  /// Several colliders resolve crossings in turns, until all of them find none. Returns whether any particle moved.
  bool resolve_in_turns(const Particles<R>& particles, KinematicMarks<R> marks, bool move_with_objects) {
    const KinematicOwner first = marks.number;
    int clean = 0;  // number of colliders that found no crossing since the last motion
    bool moved = false;
    const auto run_round = [&] {
      marks.number = first;
      for_each([&](auto& one) {
        if (clean == count_) return;
        clean = one.resolve_crossings(particles, marks, move_with_objects) ? 0 : clean + 1;
        moved = moved || clean == 0;
        marks.number += one.objects();
      });
    };
    for (int round = 0; round < kRounds && clean < count_; ++round) run_round();
    if (clean == count_) return moved;
    parallel_for(executor_, particles.count,
                 CopyPoints<R, Points<R>, Points<R>>{particles.p.d, saved_displacements_.points()});
    move_with_objects = false;
    run_round();
    parallel_for(executor_, particles.count, CancelChangedMotion<R>{particles.p, saved_displacements_.points()});
    clean = 0;
    run_round();  // moving objects push a particle from there
    return true;
  }

  Executor executor_;
  std::optional<MeshCollider<Executor, R>> meshes_;
  std::optional<ShapeCollider<Executor, R>> shapes_;
  std::optional<DeformingCollider<Executor, R>> deforming_;
  int count_ = 0;                                // number of colliders
  PointArray<Executor, R> saved_displacements_;  // of particles that several colliders push
  PointArray<Executor, R> before_;               // of clamp_tunnelling_late()
};

}  // namespace malha
