// SPDX-License-Identifier: Apache-2.0
// Particles that objects of the environment carry in the present substep, where bodies collide with themselves: others
// must get out of their way.
#pragma once
#include <cstddef>
#include <vector>

#include "host/base/array.h"
#include "host/base/point_array.h"
#include "kernels/environment/edge_contact.h"
#include "kernels/parallel/compute.h"

namespace malha {

template <class Executor, class R>
class KinematicParticles {
 public:
  KinematicParticles(const Executor& executor, std::size_t particles)
      : executor_(executor), w_(particles, R(0)), by_(particles, kNobody), start_(particles) {}

  /// Nothing is carried yet.
  void start(const Particles<R>& particles) {
    clear(particles);
    parallel_for(executor_, particles.count, Copy{particles.p.d, start_.points()});
  }
  /// All goes back to where start() found it.
  void start_again(const Particles<R>& particles) {
    clear(particles);
    parallel_for(executor_, particles.count, Copy{start_.points(), particles.p.d});
  }

  /// What is free stays where the substep began.
  void stand_still(const Particles<R>& particles) {
    parallel_for(executor_, particles.count, StandStill<R>{particles});
  }

  /// For passes that carry particles; numbers of objects count from `first`.
  HeldByEdges<R> of(Carrier first) { return {w_.data(), by_.data(), first}; }

  /// With no inverse mass where objects carry them.
  Particles<R> in(Particles<R> particles) const {
    particles.w = w_.data();
    return particles;
  }
  /// Which objects those are, and how these move in the substep, from the world to the world.
  Carriers carriers(const std::vector<Pose>& motion) {
    motion_ = Array<Executor, Pose>(motion);
    return {by_.data(), motion_.data()};
  }

  std::size_t bytes() const { return w_.bytes() + by_.bytes() + motion_.bytes() + start_.bytes(); }

 private:
  using Copy = CopyPoints<R, Points<R>, Points<R>>;

  void clear(const Particles<R>& particles) {
    Memory<Executor>::copy(particles.w, w_.size(), w_.data());
    Memory<Executor>::fill(by_.data(), by_.size(), kNobody);
  }

  Executor executor_;
  Array<Executor, R> w_;         // 1/kg, of what is carried none
  Array<Executor, Carrier> by_;  // whom it is carried by
  Array<Executor, Pose> motion_;
  PointArray<Executor, R> start_;  // how far all would go if nothing were carried
};

}  // namespace malha
