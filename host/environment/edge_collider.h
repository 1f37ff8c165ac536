// SPDX-License-Identifier: Apache-2.0
// Collider of deformable bodies with edges and corners of the environment. Made only for scenes with objects that name
// "edges".
#pragma once
#include <array>
#include <deque>
#include <vector>

#include "host/environment/edge_group.h"
#include "host/model/self_surface.h"

namespace malha {

template <class Executor, class R>
class EdgeCollider {
 public:
  EdgeCollider(const Executor& executor, const Model& model) : executor_(executor), x0_(model.x) {
    const SelfSurface bodies = bodies_surface(model);
    std::vector<std::vector<const EnvironmentMesh*>> groups;
    for (const EnvironmentMesh& mesh : model.environment) {
      if (!mesh.spec.edges) continue;
      const bool rests = mesh.spec.motion.empty();
      const auto same = std::find_if(groups.begin(), groups.end(),
                                     [&](const auto& group) { return rests && group[0]->spec.motion.empty(); });
      if (same == groups.end())
        groups.push_back({&mesh});
      else
        same->push_back(&mesh);
    }
    for (const auto& objects : groups) groups_.emplace_back(executor, model, bodies.simplices, objects);
  }

  void detect_contacts(const Particles<R>& particles, double start, double end) {
    for (auto& group : groups_) group.detect_contacts(particles, x0_.points(), start, end);
  }
  void solve_contacts(const Particles<R>& particles) {
    for (auto& group : groups_) group.solve_contacts(particles);
  }

  /// Final guard: no primitives intersect afterwards. `can_project`: contacts may be projected before displacements are
  /// truncated. Marks truncated particles in `marks` as owned by their group. Returns whether any particle moved.
  bool resolve_intersections(const Particles<R>& particles, bool can_project, KinematicMarks<R> marks) {
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool moved = false;
      for (marks.number = 0; marks.number < groups(); ++marks.number)
        moved = groups_[marks.number].resolve_intersections(particles, can_project && round == 0, marks) || moved;
      any = any || moved;
      if (!moved || (groups_.size() == 1 && round == 0)) break;
    }
    return any;
  }

  /// Appends the motion of each group in this substep.
  void append_motion(std::vector<Pose>& motion) const {
    for (const auto& group : groups_) motion.push_back(group.motion());
  }

  /// Lets particles that are nearer than the minimum distance now keep their distance until they move away by
  /// themselves.
  void keep_overlaps() {
    for (auto& group : groups_) group.keep_overlaps();
  }

  /// Stores the positions from which the next substep starts.
  void end_substep(const Particles<R>& particles) {
    parallel_for(executor_, particles.count, CopyPoints<R, Displaced<R>>{particles.p, x0_.points()});
  }

  int contacts() const {
    int sum = 0;
    for (const auto& group : groups_) sum += group.contacts();
    return sum;
  }
  EdgeStats facts() const {
    EdgeStats sum;
    for (const auto& group : groups_) sum += group.facts();
    sum.bytes = bytes();
    return sum;
  }
  std::size_t bytes() const {
    std::size_t sum = x0_.bytes();
    for (const auto& group : groups_) sum += group.bytes();
    return sum;
  }

  /// The state that later substeps depend on, for checkpoints.
  EdgeMemory<R> save_state() const {
    EdgeMemory<R> memory;
    memory.x0 = x0_.template download<std::array<R, 3>>();
    for (const auto& group : groups_) group.save(memory);
    return memory;
  }
  void restore_state(const EdgeMemory<R>& memory) {
    x0_.upload(memory.x0);
    for (std::size_t g = 0; g < groups_.size(); ++g) groups_[g].restore_state(memory, g);
  }
  int groups() const { return static_cast<int>(groups_.size()); }

 private:
  static constexpr int kRounds = 8;  // of the groups in turn, where they jam a body between them

  Executor executor_;
  ScatteredArray<Executor, R> x0_;
  std::deque<EdgeGroup<Executor, R>> groups_;
};

}  // namespace malha
