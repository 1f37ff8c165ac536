// SPDX-License-Identifier: Apache-2.0
// Final guards of a substep: no surface intersects another. Resolving one intersection may cause another, so the guards
// of bodies, of environment edges and of environment meshes run in turns.
#pragma once
#include <vector>

#include "host/measure/solver_stats.h"
#include "host/self_collision/kinematic_particles.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Separates bodies from each other (`self`), from edges of the environment (`edges`) and, after these moved particles,
/// from its objects (`collider`); each may be absent. Particles that meshes and edges moved are kinematic for
/// self-collision from then on. `timed(pass, work)` runs work().
template <class Self, class Edges, class Colliders, class Kinematic, class R, class Timed>
void apply_final_guards(Self& self, Edges& edges, Colliders& collider, Kinematic& kinematic, const Particles<R>& all,
                        const Timed& timed) {
  constexpr int max_rounds = 4;  // of all jams that resolve, 99.99 of 100 did in 3
  if (!self && !edges) return;
  const auto has_environment_contacts = [&] {
    return collider && (collider->contacts() > 0 || (edges && edges->contacts() > 0));
  };
  const auto owners = [&] {
    return kinematic->owners([&](std::vector<Pose>& motion) {
      if (edges) edges->append_motion(motion);
      if (collider) collider->append_motion(motion);
    });
  };
  const auto marks_from = [&](KinematicOwner first) {
    return kinematic ? kinematic->marks_from(first) : KinematicMarks<R>{};
  };
  const KinematicOwner first_mesh = edges ? edges->rigid_groups() : 0;
  bool moved = false, any_moved_with_mesh = false;
  if (self) timed(Pass::SelfCollision, [&] { moved = self->resolve_intersections(all, has_environment_contacts); });
  if (kinematic && (moved || edges)) kinematic->start(all);

  const auto run_in_turns = [&](bool move_with_meshes, bool with_edges) {
    for (int round = 0; round < max_rounds; ++round) {
      bool moved_by_edges = false, moved_by_meshes = false;
      if (self && round > 0)
        timed(Pass::SelfCollision, [&] {
          moved = self->resolve_intersections(kinematic->with_infinite_mass(all), has_environment_contacts, owners()) ||
                  moved;
        });
      if (edges && with_edges)
        timed(Pass::Edges, [&] { moved_by_edges = edges->resolve_intersections(all, round == 0, marks_from(0)); });
      if (collider && (moved || moved_by_edges))
        timed(Pass::Collision,
              [&] { moved_by_meshes = collider->resolve_crossings(all, marks_from(first_mesh), move_with_meshes); });
      any_moved_with_mesh = any_moved_with_mesh || moved_by_meshes;
      if (!moved_by_meshes && !(moved_by_edges && self)) return;
    }
    if (self) timed(Pass::SelfCollision, [&] { self->note_intersections(kinematic->with_infinite_mass(all)); });
  };
  run_in_turns(true, true);
  // Where edges and corners of a mesh that deforms would push bodies through each other, bodies cross these instead:
  // their pairs are then left out until they do not cross the mesh any more, but bodies never come apart again.
  const bool yields = self && edges && edges->has_deforming() && self->has_kinematic_penetration();
  if (yields) {
    kinematic->restore_displacements(all);
    timed(Pass::SelfCollision, [&] { moved = self->resolve_intersections(all, has_environment_contacts) || moved; });
    run_in_turns(true, false);
  }
  if (!self || !any_moved_with_mesh || !self->has_kinematic_penetration()) return;
  // A particle that moves with a mesh goes as far as the mesh; one that is only clamped in front of it may leave enough
  // space for all.
  kinematic->restore_displacements(all);
  run_in_turns(false, !yields);
  // Meshes at rest never force anything through a body: at worst all movable particles stay where the substep began,
  // where nothing intersects.
  if (!self->has_kinematic_penetration() || collider->moves()) return;
  kinematic->reset_movable_particles(all);
  timed(Pass::SelfCollision, [&] { self->resolve_intersections(all, has_environment_contacts); });
}

}  // namespace malha
