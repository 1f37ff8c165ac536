// The last word of a substep: no surface crosses another. What stops one may press it into another.
#pragma once
#include "host/solver/solver.h"
#include "kernels/particles.h"

namespace malha {

/// Bodies from each other (`self`) and from edges of the environment, in turns; each may be absent, as the collider.
/// `timed(pass, work)` runs work().
template <class Self, class Edges, class Collider, class R, class Timed>
void hold_apart(Self& self, Edges& edges, const Collider& collider, const Particles<R>& all, const Timed& timed) {
  constexpr int most_rounds = 16;
  const auto touches = [&] { return collider && (collider->contacts() > 0 || (edges && edges->contacts() > 0)); };
  for (int round = 0;; ++round) {
    if (self)
      timed(Pass::SelfCollision, [&] {
        round == 0 ? self->hold_apart(all, touches) : self->hold_apart(edges->held(all), touches, edges->carriers());
      });
    bool moved = false;
    if (edges && round < most_rounds) timed(Pass::Edges, [&] { moved = edges->hold_apart(all, round == 0); });
    if (!moved || !self) break;
  }
}

}  // namespace malha
