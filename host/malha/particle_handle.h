// SPDX-License-Identifier: Apache-2.0
// A particle that the user drags or holds.
#pragma once
#include "malha/mesh.h"

namespace malha {

/// A particle that the user pulls by a spring or holds: Simulation::pull(), Simulation::hold().
struct ParticleHandle {
  int particle;           ///< index into Simulation::positions()
  Vec3 to;                ///< m: the point to which it is pulled, or at which it is held
  double compliance = 0;  ///< m/N, of the spring to that point; 0: the particle is held there
  bool is_held() const { return compliance == 0; }
};

}  // namespace malha
