// SPDX-License-Identifier: Apache-2.0
// A particle that a hand has taken, between two steps.
#pragma once
#include "malha/mesh.h"

namespace malha {

struct ParticleHandle {
  int particle;           ///< as in Simulation::positions()
  Vec3 to;                ///< the point that pulls it, or the place where it is held (m)
  double compliance = 0;  ///< of the spring to that point, m/N; 0: it is held
  bool is_held() const { return compliance == 0; }
};

}  // namespace malha
