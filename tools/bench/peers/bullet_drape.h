// SPDX-License-Identifier: Apache-2.0
// A cloth on environment meshes by Bullet, where the build found it: a soft body against BVHs of triangles.
#pragma once
#include <memory>

#include "malha/simulation.h"

namespace malha::bench {

/// Links of full stiffness on the edges and diagonals that malha's cloth has, as many iterations a step as malha has
/// projections; no bending, no drag. It goes on from where the simulation is. One thread: Bullet has no other way.
class BulletDrape {
 public:
  /// The scene's only body is a cloth with a density, of distance constraints first. What moves is moved once a step.
  explicit BulletDrape(const Simulation& simulation);
  ~BulletDrape();
  BulletDrape(const BulletDrape&) = delete;
  BulletDrape& operator=(const BulletDrape&) = delete;

  void step();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace malha::bench
