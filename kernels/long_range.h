// long_range: C = r - |p - a| >= 0 for a particle p and each pinned particle a that it hangs on, r their distance over
// the surface at rest times (1 + limit) (Kim, Chentanez, Müller, "Long Range Attachments", 2012). Pins do not give way,
// so that a projection moves its own particle alone: one pass over the particles, no colouring.
#pragma once
#include "kernels/particles.h"

namespace malha {

template <class R>
struct LimitReach {
  Points<R> p;
  const R* w;           // of each particle, 1/kg
  const int* particle;  // of each item
  const int* begin;     // into anchor and reach, per item, one more at the end
  const int* anchor;    // the farthest first: where two contradict each other, the nearest has the last word
  const R* reach;       // m
  KERNEL void operator()(int item) const {
    const int i = particle[item];
    if (!(w[i] > R(0))) return;
    Vector3<R> at = p[i];
    for (int k = begin[item]; k < begin[item + 1]; ++k) {
      if (w[anchor[k]] > R(0)) continue;  // no pin any more
      const Vector3<R> d = p[anchor[k]] - at;
      const R d2 = dot(d, d);
      if (d2 > reach[k] * reach[k]) at = at + d * (R(1) - reach[k] / root(d2));
    }
    p.set(i, at);
  }
};

}  // namespace malha
