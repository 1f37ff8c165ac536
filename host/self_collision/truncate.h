// SPDX-License-Identifier: Apache-2.0
// Final guard of a substep: no surface intersects another. Stopping one may press it into another, so guards take
// turns.
#pragma once
#include <vector>

#include "host/measure/solver_stats.h"
#include "host/self_collision/kinematic_particles.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Bodies from each other (`self`), from edges of the environment and, after what these move, from its meshes, in
/// turns; each may be absent. What meshes and edges hold others must get out of the way of. `timed(pass, work)` runs
/// work().
template <class Self, class Edges, class EnvironmentCollider, class Kinematic, class R, class Timed>
void hold_apart(Self& self, Edges& edges, EnvironmentCollider& collider, Kinematic& kinematic, const Particles<R>& all,
                const Timed& timed) {
  constexpr int most_rounds = 4;  // of all jams that resolve, 99.99 of 100 did in 3
  if (!self && !edges) return;
  const auto touches = [&] { return collider && (collider->contacts() > 0 || (edges && edges->contacts() > 0)); };
  const auto carriers = [&] {
    std::vector<Pose> motion;
    if (edges) edges->append_motion(motion);
    if (collider) collider->append_motion(motion);
    return kinematic->carriers(motion);
  };
  const auto by = [&](Carrier first) { return kinematic ? kinematic->of(first) : HeldByEdges<R>{}; };
  const Carrier first_mesh = edges ? edges->groups() : 0;
  bool moved = false, carried = false;
  if (self) timed(Pass::SelfCollision, [&] { moved = self->hold_apart(all, touches); });
  if (kinematic && (moved || edges)) kinematic->start(all);

  const auto in_turns = [&](bool carries) {
    for (int round = 0; round < most_rounds; ++round) {
      bool held = false, crossed = false;
      if (self && round > 0)
        timed(Pass::SelfCollision, [&] { moved = self->hold_apart(kinematic->in(all), touches, carriers()) || moved; });
      if (edges) timed(Pass::Edges, [&] { held = edges->hold_apart(all, round == 0, by(0)); });
      if (collider && (moved || held))
        timed(Pass::Collision, [&] { crossed = collider->move_with_meshes(all, by(first_mesh), carries); });
      carried = carried || crossed;
      if (!crossed && !(held && self)) return;
    }
    if (self) timed(Pass::SelfCollision, [&] { self->note_crossing(kinematic->in(all)); });
  };
  in_turns(true);
  if (!self || !carried || !self->went_through()) return;
  // What a mesh carries has come as far as the mesh: what is only put before it may leave room for all.
  kinematic->start_again(all);
  in_turns(false);
  // Before objects that rest nothing is ever forced through: at worst all free particles stay where the substep began,
  // where nothing crosses.
  if (!self->went_through() || collider->moves()) return;
  kinematic->stand_still(all);
  timed(Pass::SelfCollision, [&] { self->hold_apart(all, touches); });
}

}  // namespace malha
