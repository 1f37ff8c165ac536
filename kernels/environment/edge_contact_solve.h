// SPDX-License-Identifier: Apache-2.0
// Solver of contacts with edges of the environment: Jacobi with mass splitting (Tonge, Benevolenski, Voroshilov 2012).
// A particle with several contacts is split among them, which conserves momentum, never overshoots, and gives the same
// bits in any order. The shares of its mass are proportional to what each contact would push alone, not equal: a
// contact that hardly pushes takes no mass from those that do, nor friction.
//
// If the closest points lie at the end of an edge or on the boundary of a triangle, the contact has an oblique normal
// and would brake or push sliding bodies, while the contacts of the neighbouring edges or triangles usually are as
// near. So it claims a small share of the mass, and gets all of it only where no other contact pushes.
#pragma once
#include "kernels/environment/contact.h"
#include "kernels/environment/edge_contact.h"

namespace malha {

/// Motion of the first side relative to the second at the closest points.
template <class R>
KERNEL Vector3<R> relative_motion(const EdgeContact<R>& c, const ScatteredPoints<R>& moved) {
  Vector3<R> sum{R(0), R(0), R(0)};
  for (int j = 0; j < 4; ++j) sum = sum + moved[c.i[j]] * c.weight[j];
  return sum;
}

/// Impulse of a contact on its particles.
template <class R>
struct ContactImpulse {
  Vec4<R> impulse;  // on the first side, kg m; w: claim to the mass of its particles (kg m), 0 if inactive
  R weight[4];
};

/// Returns true if the closest points lie at the end of an edge or on the boundary of a triangle.
template <class R>
KERNEL bool is_boundary_contact(const EdgeContact<R>& c) {
  return c.weight[0] == R(0) || c.weight[1] == R(0) || c.weight[2] == R(0) || c.weight[3] == R(0);
}

/// Claim of a contact: what it has pushed so far and would push alone.
template <class R>
struct EstimateMassShares {
  /// Factor of the claim of a boundary contact. Layers slide within 5 % of Coulomb's distance from 0.02 to 0.1; heaps
  /// rest better with more.
  static constexpr double kBoundaryClaim = 0.1;
  ScatteredPoints<R> moved;
  const EdgeContact<R>* contacts;
  const R* w;
  ContactImpulse<R>* impulses;
  KERNEL void operator()(int k) const {
    const EdgeContact<R>& c = contacts[k];
    R W = R(0), push = c.lambda;
    for (int j = 0; j < 4; ++j) W += c.weight[j] * c.weight[j] * w[c.i[j]];
    const R bias = c.bias - dot(c.n, relative_motion(c, moved));
    if (bias > R(0)) push += bias / W;
    if (is_boundary_contact(c)) push *= R(kBoundaryClaim);
    impulses[k].impulse.w = W > tiny<R>() ? push : R(0);
    for (int j = 0; j < 4; ++j) impulses[k].weight[j] = c.weight[j];
  }
};

/// Inverse mass of a contact with its shares of the particles' masses: that of particle j is (share |weight_j|) / w_j.
template <class R>
KERNEL R inverse_mass(const EdgeContact<R>& c, R share, const ScatteredPoints<R>& moved) {
  R W = R(0);
  for (int j = 0; j < 4; ++j) W += abs(c.weight[j]) * moved.of[c.i[j]].w;
  return W / share;
}

/// Splits every particle among its contacts by their claims: stores its inverse mass times their sum in moved's w.
template <class R>
struct SplitMasses {
  const R* w;
  const Keyed* ends;
  const int* begin;
  const ContactImpulse<R>* impulses;
  ScatteredPoints<R> moved;
  KERNEL void operator()(int i) const {
    R sum = R(0);
    for (int e = begin[i]; e < begin[i + 1]; ++e) {
      const ContactImpulse<R>& push = impulses[ends[e].value / 4];
      sum += push.impulse.w * abs(push.weight[ends[e].value % 4]);
    }
    moved.of[i].w = w[i] * sum;
  }
};

/// Refines the claims to what the contacts would push with these shares, but at least a tenth of the old claim, since a
/// contact that has pushed may have to release. Nothing moves.
template <class R>
struct RefineMassShares {
  ScatteredPoints<R> moved;
  const EdgeContact<R>* contacts;
  ContactImpulse<R>* impulses;
  KERNEL void operator()(int k) const {
    R& share = impulses[k].impulse.w;
    if (!(share > R(0))) return;
    const EdgeContact<R>& c = contacts[k];
    const R W = inverse_mass(c, share, moved);
    if (W > tiny<R>()) share = max(R(0.1) * share, c.lambda + (c.bias - dot(c.n, relative_motion(c, moved))) / W);
  }
};

/// Computes the impulse of each active contact (times dt): a push, and friction on positions as in
/// kernels/environment/contact.h. A Friction with carry(k) tells how far the surface of contact k carries what sticks
/// to it.
template <class R, class Friction>
struct SolveContactsJacobi {
  ScatteredPoints<R> moved;
  EdgeContact<R>* contacts;
  Friction friction;
  ContactImpulse<R>* impulses;
  KERNEL void operator()(int k) const {
    ContactImpulse<R>& push = impulses[k];
    const R share = push.impulse.w;
    push.impulse.w = R(0);
    if (!(share > R(0))) return;
    EdgeContact<R>& c = contacts[k];
    const R W = inverse_mass(c, share, moved);
    if (!(W > tiny<R>())) return;
    const Vector3<R> motion = relative_motion(c, moved);
    const R along = dot(c.n, motion);
    const R dlambda = max((c.bias - along) / W, -c.lambda);
    c.lambda += dlambda;
    Vector3<R> slide = motion - c.n * along;
    if constexpr (requires { friction.carry(k); }) {
      const Vector3<R> carry = friction.carry(k);
      slide = slide - (carry - c.n * dot(c.n, carry));
    }
    const Vector3<R> friction_impulse =
        clamp_to_friction_cone(c.friction_impulse + slide * (R(1) / W), friction(c) * c.lambda);
    const Vector3<R> impulse = c.n * dlambda - (friction_impulse - c.friction_impulse);
    c.friction_impulse = friction_impulse;
    push.impulse = {impulse.x, impulse.y, impulse.z, R(1)};
  }
};

/// Applies the impulses of its contacts to every particle, in a fixed order.
template <class R, class Rotation>
struct ApplyImpulses {
  Displaced<R> p;
  const R* w;
  const Keyed* ends;
  const int* begin;
  const ContactImpulse<R>* impulses;
  Rotation rotation;
  KERNEL void operator()(int i) const {
    if (begin[i] == begin[i + 1] || !(w[i] > R(0))) return;
    Vector3<R> sum{R(0), R(0), R(0)};
    for (int e = begin[i]; e < begin[i + 1]; ++e) {
      const ContactImpulse<R>& push = impulses[ends[e].value / 4];
      if (push.impulse.w > R(0)) sum = sum + push.impulse.xyz() * push.weight[ends[e].value % 4];
    }
    p.add_displacement(i, rotation(sum) * w[i]);
  }
};

/// Counts contacts that pushed in the last substep.
template <class R>
struct CountPushing {
  const EdgeContact<R>* contacts;
  KERNEL Sum operator()(int k) const { return {contacts[k].lambda > R(0) ? 1.0 : 0.0}; }
};

}  // namespace malha
