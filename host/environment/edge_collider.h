// SPDX-License-Identifier: Apache-2.0
// Contacts of deformable bodies with edges and corners of the environment. Made only for scenes with objects that name
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

  /// The end of a substep: nothing crosses. `pushes`: whether what would may first be pushed. Notes what is held in
  /// `held`, by numbers of groups. Returns whether anything moved.
  bool resolve_intersections(const Particles<R>& particles, bool pushes, KinematicMarks<R> held) {
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool moved = false;
      for (held.number = 0; held.number < groups(); ++held.number)
        moved = groups_[held.number].resolve_intersections(particles, pushes && round == 0, held) || moved;
      any = any || moved;
      if (!moved || (groups_.size() == 1 && round == 0)) break;
    }
    return any;
  }

  /// Adds how each group moves in this substep.
  void append_motion(std::vector<Pose>& motion) const {
    for (const auto& group : groups_) motion.push_back(group.moves());
  }

  /// What is nearer than is wanted now stays as near until it opens by itself.
  void keep_overlaps() {
    for (auto& group : groups_) group.keep_overlaps();
  }

  /// Where all is now is where the next substep begins.
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

  /// It copies what a later substep depends on, for checkpoints.
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
  static constexpr int kRounds = 8;  // of groups that move apart, where they jam what is between them

  Executor executor_;
  ScatteredArray<Executor, R> x0_;
  std::deque<EdgeGroup<Executor, R>> groups_;
};

}  // namespace malha
