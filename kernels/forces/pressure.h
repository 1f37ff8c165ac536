// SPDX-License-Identifier: Apache-2.0
// pressure: C = V - r V0 in m^3, V = sum over triangles of (p1 x p2) . p3 / 6 the enclosed volume, V0 that at rest,
// over all the particles of a closed mesh at once (Müller et al. 2006, section 4.4, who leave out the 1/6; a compliance
// in m^5/N needs it). -C / alpha is the pressure inside above that outside, Pa. Three reductions and one update, no
// colouring. Positions are taken relative to one particle: on a closed mesh this changes nothing but the rounding.
//
// The gradient at a particle is a third of its faces' area, and grows with them. Where stiff edges are not resolved,
// the pressure on stretched faces stretches them further: scans grew spikes of hundreds of m/s. The gradient of a
// particle is therefore clamped to kMaxStretch times the area of its faces at rest, scaled to the size at which the
// body has its volume. The other particles take over the rest, so that the volume is still correct to first order, and
// the momenta of the missing push are added to the body as a rigid motion. Without clamped particles the bits are those
// of the plain projection.
#pragma once
#include "kernels/forces/angular_velocity.h"
#include "kernels/parallel/compute.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Largest ratio of the area on which pressure acts to the area at rest, that of doubled lengths.
inline constexpr double kMaxStretch = 4;

/// Contribution of a triangle to the enclosed volume, m^3.
template <class At>
struct EnclosedVolume {
  At p;
  const int* corners;  // three a triangle
  int origin;          // a particle of the mesh
  KERNEL Sum operator()(int t) const {
    const auto a = p.difference(corners[3 * t], origin), b = p.difference(corners[3 * t + 1], origin);
    return {double(dot(cross(a, b), p.difference(corners[3 * t + 2], origin))) / 6};
  }
};

/// Sums over the particles of a mesh. The push that clamped particles lack, per unit of lambda, is a force in m^2 with
/// a moment about the origin particle in m^3.
struct GradientSum {
  double grad2 = 0;  // w grad C . g, g the gradient that is applied
  double force[3] = {}, moment[3] = {};
  double clamped = 0, pinned = 0;  // particles
  KERNEL GradientSum& operator+=(const GradientSum& o) {
    grad2 += o.grad2, clamped += o.clamped, pinned += o.pinned;
    for (int k = 0; k < 3; ++k) force[k] += o.force[k], moment[k] += o.moment[k];
    return *this;
  }
};

/// grad_i = sum over the triangles (i, j, k) around i of p_j x p_k / 6, m^2.
template <class R, class At>
struct Fans {
  At p;
  const int* begin;   // into `around`, per item, one more at the end
  const int* around;  // pairs (j, k)
  int origin;
  KERNEL Vector3<R> gradient(int item) const {
    Vector3<R> sum{R(0), R(0), R(0)};
    for (int t = begin[item]; t < begin[item + 1]; ++t)
      sum = sum + cross(p.difference(around[2 * t], origin), p.difference(around[2 * t + 1], origin));
    return sum * R(1.0 / 6);
  }
};

/// Stores the gradient at the start of the substep, clamped to `most`, and returns its sums.
template <class R>
struct PressureGradient {
  Fans<R, StartPositions<R>> fans;
  const R* w;           // of each particle
  const int* particle;  // of each item
  const R* most;        // of each item: the largest gradient, m^2; null: none
  Points<R> grad;       // per item
  KERNEL GradientSum operator()(int item) const {
    const Vector3<R> g = fans.gradient(item);
    const R weight = w[particle[item]];
    const double g2 = double(dot(g, g)), allowed = most ? double(most[item]) : INFINITY;
    GradientSum sums;
    sums.pinned = weight > R(0) ? 0 : 1;
    sums.grad2 = double(weight) * g2;
    if (!(weight > R(0)) || !(g2 > allowed * allowed)) {
      grad.set(item, g);
      return sums;
    }
    const double kept = allowed / sqrt(g2);
    grad.set(item, g * R(kept));
    const Vector3<double> lacks = in_double(g) * (1 - kept);
    const Vector3<double> m = cross(in_double(fans.p.difference(particle[item], fans.origin)), lacks);
    return {sums.grad2 * kept, {lacks.x, lacks.y, lacks.z}, {m.x, m.y, m.z}, 1, 0};
  }
};

/// Derivative of the volume along the direction of the projection: w grad at the start of the substep, or what a filter
/// makes of that (`way`, of each particle).
struct AlongSum {
  double now = 0, start = 0;
  KERNEL AlongSum& operator+=(const AlongSum& o) {
    now += o.now, start += o.start;
    return *this;
  }
  /// At least half of the value at the start: after a large rotation the push is smaller.
  KERNEL double value() const { return max(now, 0.5 * start); }
};
template <class R>
struct SumAlongPressure {
  Fans<R, Displaced<R>> fans;
  const int* particle;
  Points<R> start;  // the gradient there, of each item
  const R* w;       // without a filter
  Points<R> way;    // with one
  KERNEL AlongSum operator()(int item) const {
    const int i = particle[item];
    const Vector3<R> g = start[item], along = way.x ? way[i] : g * w[i];
    return {double(dot(fans.gradient(item), along)), double(dot(g, along))};
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

/// State between the launches of a projection.
struct PressureState {
  Sum volume;        // m^3
  GradientSum sums;  // of the gradient at the start of a substep
  AlongSum along;
  InertiaSum inertia;
  double lambda = 0, dlambda = 0;
  bool moves = false;
  Vector3<double> centre{}, shift{}, turn{};  // m, from the origin particle; of the rigid motion, per unit of lambda

  /// Momenta are corrected only for bodies with clamped particles and without pins.
  KERNEL bool returns_momenta() const { return sums.clamped > 0 && sums.pinned == 0; }
};

/// Contribution of one item; 0 if no momenta are corrected.
template <class R>
struct MeasureInertia {
  const PressureState* state;
  Displaced<R> p;
  const R* w;
  const int* particle;
  int origin;
  KERNEL InertiaSum operator()(int item) const {
    if (!state->returns_momenta()) return {};
    const int i = particle[item];
    const double m = 1 / double(w[i]);
    const Vector3<double> r = in_double(p.start_difference(i, origin)), mr = r * m;
    InertiaSum sum{m, {mr.x, mr.y, mr.z}};
    add_inertia(sum.I, m, r);
    return sum;
  }
};

/// Computes, at the start of a substep, the rigid motion with the momenta of the push that clamped particles lack. It
/// does not change the volume.
struct StartPressure {
  PressureState* state;
  KERNEL void operator()(int) const {
    state->lambda = 0;
    if (!state->returns_momenta()) return;
    const InertiaSum& all = state->inertia;
    const GradientSum& lacks = state->sums;
    const Vector3<double> force{lacks.force[0], lacks.force[1], lacks.force[2]};
    const Vector3<double> c = Vector3<double>{all.r[0], all.r[1], all.r[2]} * (1 / all.mass);
    const Vector3<double> m = Vector3<double>{lacks.moment[0], lacks.moment[1], lacks.moment[2]} - cross(c, force);
    SpinSum spin{{m.x, m.y, m.z}};
    for (int k = 0; k < 6; ++k) spin.I[k] = all.I[k];
    centre_inertia(spin.I, all.mass, c);
    state->centre = c;
    state->shift = force * (1 / all.mass);
    state->turn = angular_velocity(spin);
  }
};

/// Computes dlambda (XPBD, Macklin et al. 2016, equation 18). Launched with one item.
struct PushPressure {
  PressureState* state;
  double target;  // m^3
  bool compliant;
  double alpha, stiffness;
  KERNEL void operator()(int) const {
    const double C = state->volume.value - target, sum = state->along.value();
    state->moves = sum > 1e-200;  // collapsed to a point, or wholly pinned: no direction
    if (!state->moves) return;
    state->dlambda = compliant ? (-C - alpha * state->lambda) / (sum + alpha) : -stiffness * C / sum;
    state->lambda += state->dlambda;
  }
};

/// Stores the gradient as a force on each particle of the mesh.
template <class R>
struct StorePressureForce {
  const int* particle;
  Points<R> grad, force;
  KERNEL void operator()(int item) const { force.set(particle[item], grad[item]); }
};

/// d += way dlambda for the particles of the body.
template <class R>
struct ApplyFilteredPressure {
  Displaced<R> p;
  Points<R> way;
  const int* members;
  const PressureState* state;
  KERNEL void operator()(int member) const {
    const int i = members[member];
    if (state->moves) p.add_displacement(i, way[i] * R(state->dlambda));
  }
};

/// Inverse masses of items at which seams hold further particles, the followers: those of all together, 0 if one is
/// pinned.
template <class R>
struct JoinInverseMasses {
  const R* w;            // of each particle
  const int* particle;   // of each item
  const int* begin;      // of the followers of each item, one more at the end
  const int* followers;  // particles
  R* joined;             // of each particle; set for the items
  KERNEL void operator()(int item) const {
    const int i = particle[item];
    joined[i] = w[i];
    if (begin[item] == begin[item + 1]) return;
    double mass = 1 / double(w[i]);
    for (int k = begin[item]; k < begin[item + 1]; ++k) mass += 1 / double(w[followers[k]]);  // infinite of a pin
    joined[i] = R(1 / mass);
  }
};

/// d += w grad dlambda, and the rigid motion that keeps the momenta.
template <class R>
struct ApplyPressure {
  Displaced<R> p;
  const R* w;
  const int* particle;
  Points<R> grad;
  const PressureState* state;
  int origin;
  KERNEL void operator()(int item) const {
    if (moves(item)) p.add_displacement(particle[item], way(item));
  }

  KERNEL bool moves(int item) const { return w[particle[item]] > R(0) && state->moves; }
  KERNEL Vector3<R> way(int item) const {
    const int i = particle[item];
    Vector3<R> way = grad[item] * (w[i] * R(state->dlambda));
    if (state->returns_momenta()) {
      const Vector3<double> r = in_double(p.start_difference(i, origin)) - state->centre;
      way = way + rounded<R>((state->shift + cross(state->turn, r)) * state->dlambda);
    }
    return way;
  }
};

/// Moves the followers of items as these move.
template <class R>
struct FollowPressure {
  ApplyPressure<R> leaders;
  const int* item;      // of each follower
  const int* follower;  // particles
  KERNEL void operator()(int k) const {
    if (leaders.moves(item[k])) leaders.p.add_displacement(follower[k], leaders.way(item[k]));
  }
};

}  // namespace malha
