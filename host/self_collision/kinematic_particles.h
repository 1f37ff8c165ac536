// SPDX-License-Identifier: Apache-2.0
// Particles that move with objects of the environment in the present substep: self-collision treats them as kinematic.
#pragma once
#include <cstddef>
#include <vector>

#include "host/base/array.h"
#include "host/base/point_array.h"
#include "kernels/environment/edge_detection.h"
#include "kernels/parallel/compute.h"
#include "kernels/self_collision/kinematic_push.h"

namespace malha {

template <class Executor, class R>
class KinematicParticles {
 public:
  KinematicParticles(const Executor& executor, std::size_t particles)
      : executor_(executor), w_(particles, R(0)), owner_(particles, kNoOwner), start_(particles) {}

  /// Clears the marks and saves the displacements of all particles.
  void start(const Particles<R>& particles) {
    clear(particles);
    parallel_for(executor_, particles.count, Copy{particles.p.d, start_.points()});
  }
  /// Clears the marks and restores the displacements that start() saved.
  void restore_displacements(const Particles<R>& particles) {
    clear(particles);
    parallel_for(executor_, particles.count, Copy{start_.points(), particles.p.d});
  }

  /// Moves movable particles back to where the substep began.
  void reset_movable_particles(const Particles<R>& particles) {
    parallel_for(executor_, particles.count, ResetMovableParticles<R>{particles});
  }

  /// Marks for a pass that moves particles with its objects, whose numbers count from `first`.
  KinematicMarks<R> marks_from(KinematicOwner first) { return {w_.data(), owner_.data(), first}; }

  /// The particles, with inverse mass 0 where they move with objects.
  Particles<R> with_infinite_mass(Particles<R> particles) const {
    particles.w = w_.data();
    return particles;
  }
  /// Owners of the particles, and the motion of each owner in the substep (world to world), which append(motions)
  /// lists.
  template <class Append>
  KinematicOwners owners(const Append& append) {
    motion_of_owners_.clear(), append(motion_of_owners_);
    if (motion_.size() == motion_of_owners_.size())
      motion_.upload(motion_of_owners_);
    else
      motion_ = Array<Executor, Pose>(motion_of_owners_);
    return {owner_.data(), motion_.data()};
  }

  std::size_t bytes() const { return w_.bytes() + owner_.bytes() + motion_.bytes() + start_.bytes(); }

 private:
  using Copy = CopyPoints<R, Points<R>, Points<R>>;

  void clear(const Particles<R>& particles) {
    Memory<Executor>::copy(particles.w, w_.size(), w_.data());
    Memory<Executor>::fill(owner_.data(), owner_.size(), kNoOwner);
  }

  Executor executor_;
  Array<Executor, R> w_;                   // 1/kg; 0 for marked particles
  Array<Executor, KinematicOwner> owner_;  // of each particle
  Array<Executor, Pose> motion_;
  std::vector<Pose> motion_of_owners_;  // the same, before it is uploaded
  PointArray<Executor, R> start_;       // displacements before any particle is marked
};

}  // namespace malha
