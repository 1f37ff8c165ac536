// SPDX-License-Identifier: Apache-2.0
// Collider of deformable bodies with edges and corners of the environment. Made only for scenes with objects that name
// "edges".
#pragma once
#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "host/attachments/object_motion.h"
#include "host/environment/edge_group.h"
#include "host/model/self_surface.h"

namespace malha {

template <class Executor, class R>
class EdgeCollider {
 public:
  EdgeCollider(const Executor& executor, const Model& model) : executor_(executor), x0_(model.x) {
    const SelfSurface bodies = bodies_surface(model);
    for (const std::vector<const EnvironmentMesh*>& objects : edge_groups(model))
      if (deforms(*objects[0]))
        deforming_.emplace_back(executor, model, bodies.simplices, objects);
      else
        groups_.emplace_back(executor, model, bodies.simplices, objects);
  }

  void detect_contacts(const Particles<R>& particles, double start, double end) {
    for_each([&](auto& group) { group.detect_contacts(particles, x0_.points(), start, end); });
  }
  void solve_contacts(const Particles<R>& particles) {
    for_each([&](auto& group) { group.solve_contacts(particles); });
  }

  /// Final guard: no primitives intersect afterwards. `can_project`: contacts may be projected before displacements are
  /// truncated. Marks truncated particles in `marks` as owned by their group. Returns whether any particle moved.
  bool resolve_intersections(const Particles<R>& particles, bool can_project, KinematicMarks<R> marks) {
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool moved = false;
      marks.number = 0;
      for_each([&]<bool kDeforms>(EdgeGroup<Executor, R, kDeforms>& group) {
        // No motion of a mesh that deforms is rigid: what it moves has no owner.
        if (kDeforms) marks.number = kNoOwner;
        moved = group.resolve_intersections(particles, can_project && round == 0, marks) || moved;
        ++marks.number;
      });
      any = any || moved;
      if (!moved || (groups() == 1 && round == 0)) break;
    }
    return any;
  }

  /// Appends the motion of each group of rigid objects in this substep.
  void append_motion(std::vector<Pose>& motion) const {
    for (const auto& group : groups_) motion.push_back(group.motion());
  }
  /// Tells whether there are meshes that deform.
  bool has_deforming() const { return !deforming_.empty(); }
  /// Number of these groups.
  int rigid_groups() const { return static_cast<int>(groups_.size()); }

  /// Lets particles that are nearer than the minimum distance now keep their distance until they move away by
  /// themselves.
  void keep_overlaps() {
    for_each([](auto& group) { group.keep_overlaps(); });
  }

  /// Stores the positions from which the next substep starts.
  void end_substep(const Particles<R>& particles) {
    parallel_for(executor_, particles.count, CopyPoints<R, Displaced<R>>{particles.p, x0_.points()});
  }

  int contacts() const {
    int sum = 0;
    for_each([&](const auto& group) { sum += group.contacts(); });
    return sum;
  }
  EdgeStats facts() const {
    EdgeStats sum;
    for_each([&](const auto& group) { sum += group.facts(); });
    sum.bytes = bytes();
    return sum;
  }
  std::size_t bytes() const {
    std::size_t sum = x0_.bytes();
    for_each([&](const auto& group) { sum += group.bytes(); });
    return sum;
  }

  /// The state that later substeps depend on, for checkpoints.
  EdgeMemory<R> save_state() const {
    EdgeMemory<R> memory;
    memory.x0 = x0_.template download<std::array<R, 3>>();
    for_each([&](const auto& group) { group.save(memory); });
    return memory;
  }
  void restore_state(const EdgeMemory<R>& memory) {
    x0_.upload(memory.x0);
    std::size_t g = 0;
    for_each([&](auto& group) { group.restore_state(memory, g++); });
  }
  int groups() const { return static_cast<int>(groups_.size() + deforming_.size()); }
  /// Largest number of particles in any substep so far whose pairs with a deforming mesh were left out.
  int most_left_out() const {
    int most = 0;
    for (const auto& group : deforming_) most = std::max(most, group.most_left_out());
    return most;
  }

 private:
  static constexpr int kRounds = 8;  // of the groups in turn, where they jam a body between them

  /// Calls work(group) for all groups: first those of rigid objects, then the meshes that deform, one a group.
  template <class Work>
  void for_each(const Work& work) {
    for (auto& group : groups_) work(group);
    for (auto& group : deforming_) work(group);
  }
  template <class Work>
  void for_each(const Work& work) const {
    for (const auto& group : groups_) work(group);
    for (const auto& group : deforming_) work(group);
  }

  Executor executor_;
  ScatteredArray<Executor, R> x0_;
  std::deque<EdgeGroup<Executor, R>> groups_;
  std::deque<EdgeGroup<Executor, R, true>> deforming_;
};

}  // namespace malha
