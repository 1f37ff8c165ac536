// The last word of a substep about an environment mesh: what its neighbours dragged through the surface, past every
// contact that its own path announced, is put back before it.
#pragma once
#include "host/collision/find_contact.h"

namespace malha {

template <class R>
struct HoldBack : MovingSurface {
  Particles<R> particles;
  const LastSeen* seen;

  KERNEL void operator()(int i) const {
    if (particles.w[i] > R(0)) look(i);
  }

 private:
  void look(int i) const {
    const Point a = to_local(before, in_double(particles.x[i])), b = to_local(after, in_double(particles.p[i]));
    // No surface lies within `distance` of where the particle was last seen, nor on a way that stays there.
    const LastSeen& last = seen[i];
    if (within(last, a) && within(last, b)) return;
    const Crossing crossing = surface->crossing(a, b, 0, sides != Sides::TwoSided);
    if (!crossing.hit) return;
    const bool from_behind = dot(crossing.normal, b - a) > 0;  // two-sided only
    const Point n = from_behind ? -crossing.normal : crossing.normal;
    const Point shift = rotate(after, n) * (thickness - dot(n, b - crossing.q));
    particles.p.set(i, particles.p[i] + Vector3<R>{R(shift.x), R(shift.y), R(shift.z)});
  }

  static bool within(const LastSeen& last, const Point& a) {
    const Point d = a - last.at;
    return last.distance > 0 && dot(d, d) < last.distance * last.distance;
  }
};

}  // namespace malha
