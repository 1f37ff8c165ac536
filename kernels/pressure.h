// pressure: C = V - r V0 in m^3, V = sum over triangles of (p1 x p2) . p3 / 6 the enclosed volume, V0 that at rest,
// over all the particles of a closed mesh at once (Müller et al. 2006, section 4.4, who leave out the 1/6; a compliance
// in m^5/N needs it). -C / alpha is the pressure inside above that outside, Pa. Three reductions and one update, no
// colouring. Positions are taken relative to one particle: on a closed mesh this changes nothing but the rounding.
//
// The gradient of a particle is a third of its faces' area, and grows with them. Where stiff edges are not resolved, a
// particle whose faces are stretched is pushed out the more for it, which stretches them further: scans grew spikes of
// hundreds of m/s. A particle is therefore pushed on no more than kMostStretched times the area that its faces have at
// rest, at the size at which the body has its volume. What a clamped particle leaves is taken by the others, so that
// the volume is met to first order all the same, and the momenta of the push that it lacks are given back to the body
// as a rigid motion. Where nothing is clamped the bits are those of the plain projection.
#pragma once
#include "kernels/angular_velocity.h"
#include "kernels/particles.h"
#include "kernels/sum.h"

namespace malha {

/// The largest ratio of the area that pressure acts on to the area at rest: lengths that double.
inline constexpr double kMostStretched = 4;

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

/// Sums over the particles of a mesh. The push that clamped particles lack, per unit of lambda, is a force in m^2 with
/// a moment about the origin particle in m^3.
struct GradientSum {
  double grad2 = 0, least = 0;  // w grad C . g, g the gradient that is applied; and what is taken for it at least
  double force[3] = {}, moment[3] = {};
  double clamped = 0, pinned = 0;  // particles
  KERNEL GradientSum& operator+=(const GradientSum& o) {
    grad2 += o.grad2, least += o.least, clamped += o.clamped, pinned += o.pinned;
    for (int k = 0; k < 3; ++k) force[k] += o.force[k], moment[k] += o.moment[k];
    return *this;
  }
};

/// grad_i = sum over the triangles (i, j, k) around i of p_j x p_k / 6, m^2; stores it, clamped to `most`, and sums up.
template <class R>
struct PressureGradient {
  Points<R> p;
  const R* w;           // of each particle
  const int* particle;  // of each item
  const int* begin;     // into `around`, per item, one more at the end
  const int* around;    // pairs (j, k)
  const R* most;        // of each item: the largest gradient, m^2; null: none
  int origin;
  Points<R> grad;  // per item
  KERNEL GradientSum operator()(int item) const {
    const Vector3<R> o = p[origin];
    Vector3<R> sum{R(0), R(0), R(0)};
    for (int t = begin[item]; t < begin[item + 1]; ++t)
      sum = sum + cross(p[around[2 * t]] - o, p[around[2 * t + 1]] - o);
    const Vector3<R> g = sum * R(1.0 / 6);
    const R weight = w[particle[item]];
    const double g2 = double(dot(g, g)), allowed = most ? double(most[item]) : INFINITY;
    GradientSum sums;
    sums.pinned = weight > R(0) ? 0 : 1;
    sums.grad2 = double(weight) * g2;
    if (!(weight > R(0)) || !(g2 > allowed * allowed)) {
      grad.set(item, g);
      return sums;
    }
    const double kept = allowed / root(g2);
    grad.set(item, g * R(kept));
    const Vector3<double> lacks = in_double(g) * (1 - kept), m = cross(in_double(p[particle[item]] - o), lacks);
    return {sums.grad2 * kept, 0, {lacks.x, lacks.y, lacks.z}, {m.x, m.y, m.z}, 1, 0};
  }
};

/// The mass of a mesh's movable particles, and its moments about the origin particle.
struct InertiaSum {
  double mass = 0, r[3] = {}, I[6] = {};  // kg, kg m, kg m^2 (as in SpinSum)
  KERNEL InertiaSum& operator+=(const InertiaSum& o) {
    mass += o.mass;
    for (int k = 0; k < 3; ++k) r[k] += o.r[k];
    for (int k = 0; k < 6; ++k) I[k] += o.I[k];
    return *this;
  }
};

/// What the launches of a projection leave for each other.
struct PressureState {
  Sum volume;        // m^3
  GradientSum sums;  // of the gradient
  InertiaSum inertia;
  double lambda = 0, dlambda = 0;
  bool moves = false;
  Vector3<double> place{}, shift{}, turn{};  // m; of the rigid motion about there, per unit of lambda

  /// A body that pins hold has no momenta to keep.
  KERNEL bool returns_momenta() const { return sums.clamped > 0 && sums.pinned == 0; }
};

/// Of one item; nothing where no momenta are to be given back.
template <class R>
struct MeasureInertia {
  const PressureState* state;
  Points<R> p;
  const R* w;
  const int* particle;
  int origin;
  KERNEL InertiaSum operator()(int item) const {
    if (!state->returns_momenta()) return {};
    const int i = particle[item];
    const double m = 1 / double(w[i]);
    const Vector3<double> r = in_double(p[i] - p[origin]), mr = r * m;
    InertiaSum sum{m, {mr.x, mr.y, mr.z}};
    add_inertia(sum.I, m, r);
    return sum;
  }
};

/// The push (XPBD, Macklin et al. 2016, equation 18). One item.
template <class R>
struct PushPressure {
  PressureState* state;
  Points<R> p;
  int origin;
  double target;  // m^3
  bool compliant;
  double alpha, stiffness;
  KERNEL void operator()(int) const {
    const double C = state->volume.value - target, sum = larger(state->sums.grad2, state->sums.least);
    state->moves = sum > double(tiny<R>());  // collapsed to a point, or wholly pinned: no direction
    if (!state->moves) return;
    state->dlambda = compliant ? (-C - alpha * state->lambda) / (sum + alpha) : -stiffness * C / sum;
    state->lambda += state->dlambda;
    if (state->returns_momenta()) find_motion();
  }

 private:
  /// The rigid motion with the momenta of the push that clamped particles lack. It changes no volume.
  KERNEL void find_motion() const {
    const InertiaSum& all = state->inertia;
    const GradientSum& lacks = state->sums;
    const Vector3<double> force{lacks.force[0], lacks.force[1], lacks.force[2]};
    const Vector3<double> c = Vector3<double>{all.r[0], all.r[1], all.r[2]} * (1 / all.mass);
    const Vector3<double> m = Vector3<double>{lacks.moment[0], lacks.moment[1], lacks.moment[2]} - cross(c, force);
    SpinSum spin{{m.x, m.y, m.z}};
    for (int k = 0; k < 6; ++k) spin.I[k] = all.I[k];
    centre_inertia(spin.I, all.mass, c);
    state->place = in_double(p[origin]) + c;
    state->shift = force * (1 / all.mass);
    state->turn = angular_velocity(spin);
  }
};

/// The gradient as a force on each particle of the mesh. One item.
template <class R>
struct PutPressure {
  const int* particle;
  Points<R> grad, force;
  KERNEL void operator()(int item) const { force.set(particle[item], grad[item]); }
};

/// How fast the volume grows along the way on which the filter takes the gradient at the substep's start. Half of what
/// it was there counts at least: a body that has turned far is pushed the less.
template <class R>
struct SumAlongPressure {
  const int* particle;
  Points<R> grad, start, way;  // the gradient now; that at the start, and its way, of each particle
  KERNEL GradientSum operator()(int item) const {
    const int i = particle[item];
    GradientSum sums;
    sums.grad2 = double(dot(grad[item], way[i])), sums.least = 0.5 * double(dot(start[i], way[i]));
    return sums;
  }
};

/// p += way dlambda. One particle of the body.
template <class R>
struct ApplyFilteredPressure {
  Points<R> p, way;
  const int* members;
  const PressureState* state;
  KERNEL void operator()(int member) const {
    const int i = members[member];
    if (state->moves) p.set(i, p[i] + way[i] * R(state->dlambda));
  }
};

/// p += w grad dlambda, and the rigid motion that keeps the momenta.
template <class R>
struct ApplyPressure {
  Points<R> p;
  const R* w;
  const int* particle;
  Points<R> grad;
  const PressureState* state;
  KERNEL void operator()(int item) const {
    const int i = particle[item];
    if (!(w[i] > R(0)) || !state->moves) return;
    Vector3<R> way = grad[item] * (w[i] * R(state->dlambda));
    if (state->returns_momenta())
      way = way + rounded<R>((state->shift + cross(state->turn, in_double(p[i]) - state->place)) * state->dlambda);
    p.set(i, p[i] + way);
  }
};

}  // namespace malha
