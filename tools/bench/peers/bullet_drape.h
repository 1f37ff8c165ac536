// SPDX-License-Identifier: Apache-2.0
// A cloth on environment meshes by Bullet, if the build found it: a soft body against BVHs of triangles.
#pragma once
#include <memory>

#include "malha/simulation.h"

namespace malha::bench {

/// A cloth that starts in the state of a simulation: links of full stiffness on the edges and diagonals of malha's
/// cloth, as many iterations per step as malha has projections, no bending, no drag. Bullet runs it on one thread.
class BulletDrape {
 public:
  /// The scene's only body must be a cloth with a density, whose first constraints are distance constraints. Moving
  /// meshes are moved once per step.
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
