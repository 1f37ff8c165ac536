// pressure: C = V - r V0 in m^3, V = sum over triangles of (p1 x p2) . p3 / 6 the enclosed volume, V0 that at rest,
// over all the particles of a closed mesh at once (Müller et al. 2006, section 4.4, who leave out the 1/6; a compliance
// in m^5/N needs it). -C / alpha is the pressure inside above that outside, Pa. Two reductions and one update, no
// colouring. Positions are taken relative to one particle: on a closed mesh this changes nothing but the rounding.
#pragma once
#include "kernels/particles.h"
#include "kernels/sum.h"

namespace malha {

/// What a triangle adds to the enclosed volume, m^3.
template <class R>
struct EnclosedVolume {
  Points<R> p;
  const int* corners;  // three a triangle
  int origin;          // a particle of the mesh
  KERNEL Sum operator()(int t) const {
    const Vector3<R> o = p[origin];
    const Vector3<R> a = p[corners[3 * t]] - o, b = p[corners[3 * t + 1]] - o;
    return {double(dot(cross(a, b), p[corners[3 * t + 2]] - o)) / 6};
  }
};

/// grad_i = sum over the triangles (i, j, k) around i of p_j x p_k / 6, m^2; stores it and returns w |grad|^2.
template <class R>
struct PressureGradient {
  Points<R> p;
  const R* w;           // of each particle
  const int* particle;  // of each item
  const int* begin;     // into `around`, per item, one more at the end
  const int* around;    // pairs (j, k)
  int origin;
  Points<R> grad;  // per item
  KERNEL Sum operator()(int item) const {
    const Vector3<R> o = p[origin];
    Vector3<R> sum{R(0), R(0), R(0)};
    for (int t = begin[item]; t < begin[item + 1]; ++t)
      sum = sum + cross(p[around[2 * t]] - o, p[around[2 * t + 1]] - o);
    const Vector3<R> g = sum * R(1.0 / 6);
    grad.set(item, g);
    return {double(w[particle[item]]) * double(dot(g, g))};
  }
};

/// What the launches of a projection leave for each other.
struct PressureState {
  Sum volume, grad2;  // m^3; of w |grad|^2
  double lambda = 0, dlambda = 0;
  bool moves = false;
};

/// The push (XPBD, Macklin et al. 2016, equation 18). One item.
template <class R>
struct PushPressure {
  PressureState* state;
  double target;  // m^3
  bool compliant;
  double alpha, stiffness;
  KERNEL void operator()(int) const {
    const double C = state->volume.value - target, sum = state->grad2.value;
    state->moves = sum > double(tiny<R>());  // collapsed to a point, or wholly pinned: no direction
    if (!state->moves) return;
    state->dlambda = compliant ? (-C - alpha * state->lambda) / (sum + alpha) : -stiffness * C / sum;
    state->lambda += state->dlambda;
  }
};

/// p += w grad dlambda.
template <class R>
struct ApplyPressure {
  Points<R> p;
  const R* w;
  const int* particle;
  Points<R> grad;
  const PressureState* state;
  KERNEL void operator()(int item) const {
    const int i = particle[item];
    if (w[i] > R(0) && state->moves) p.set(i, p[i] + grad[item] * (w[i] * R(state->dlambda)));
  }
};

}  // namespace malha
