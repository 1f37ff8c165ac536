// Views of the particles: 16 bytes each in float.
#pragma once
#include "kernels/vec.h"

namespace malha {

template <class R>
struct Particles {
  int count;
  Vec4<R>* x;  // position at the start of the substep, m; fourth: unused
  Vec4<R>* v;  // velocity, m/s; fourth: unused
  Vec4<R>* p;  // predicted position, m; fourth: w = 1 / m, 1/kg, 0 where pinned
};

}  // namespace malha
