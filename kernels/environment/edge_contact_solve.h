// SPDX-License-Identifier: Apache-2.0
// Contacts with edges of the environment push, all at once: a particle that several push is split into one for each,
// with a part of its mass (mass splitting: Tonge, Benevolenski, Voroshilov 2012), which conserves momentum, never
// overshoots, and gives the same bits whatever the order. The parts are as large as what each would push alone, not
// equal: a contact that hardly pushes takes no mass from those that do, nor friction.
//
// Where the closest points lie at the end of an edge or on the rim of a triangle, the neighbours of that edge or
// triangle are usually as near and push straight, while this contact pushes aslant: it brakes or drives what slides,
// until the others have made it idle. So it takes a small part of the mass, and all of it only where no other pushes.
#pragma once
#include "kernels/environment/contact.h"
#include "kernels/self_collision/self_contact.h"

namespace malha {

/// Motion of the one side at the closest points relative to the other's.
template <class R>
KERNEL Vector3<R> relative_motion(const SelfContact<R>& c, const ScatteredPoints<R>& moved) {
  Vector3<R> sum{R(0), R(0), R(0)};
  for (int j = 0; j < 4; ++j) sum = sum + moved[c.i[j]] * c.weight[j];
  return sum;
}

/// What a contact gives to its particles.
template <class R>
struct Push {
  Vec4<R> impulse;  // on the one side, kg m; w: its claim to its particles' mass (kg m), 0 where it does not push
  R weight[4];
};

/// Whether the closest points lie at the end of an edge or on the rim of a triangle.
template <class R>
KERNEL bool at_rim(const SelfContact<R>& c) {
  return c.weight[0] == R(0) || c.weight[1] == R(0) || c.weight[2] == R(0) || c.weight[3] == R(0);
}

/// Its claim: what it has pushed and would push alone.
template <class R>
struct EstimateMassShares {
  /// Of the claim of a contact at a rim. Layers slide within 5 % of Coulomb's way from 0.02 to 0.1; heaps rest better
  /// with more.
  static constexpr double kAtRim = 0.1;
  ScatteredPoints<R> moved;
  const SelfContact<R>* contacts;
  const R* w;
  Push<R>* pushes;
  KERNEL void operator()(int k) const {
    const SelfContact<R>& c = contacts[k];
    R W = R(0), push = c.lambda;
    for (int j = 0; j < 4; ++j) W += c.weight[j] * c.weight[j] * w[c.i[j]];
    const R bias = c.bias - dot(c.n, relative_motion(c, moved));
    if (bias > R(0)) push += bias / W;
    if (at_rim(c)) push *= R(kAtRim);
    pushes[k].impulse.w = W > tiny<R>() ? push : R(0);
    for (int j = 0; j < 4; ++j) pushes[k].weight[j] = c.weight[j];
  }
};

/// Of the parts of its particles' mass that it claims: that of particle j is (share |weight_j|) / w_j.
template <class R>
KERNEL R inverse_mass(const SelfContact<R>& c, R share, const ScatteredPoints<R>& moved) {
  R W = R(0);
  for (int j = 0; j < 4; ++j) W += abs(c.weight[j]) * moved.of[c.i[j]].w;
  return W / share;
}

/// Every particle is split among its contacts by what each claims of it. moved's w = its inverse mass times all of
/// that.
template <class R>
struct SplitMasses {
  const R* w;
  const Keyed* ends;
  const int* begin;
  const Push<R>* pushes;
  ScatteredPoints<R> moved;
  KERNEL void operator()(int i) const {
    R sum = R(0);
    for (int e = begin[i]; e < begin[i + 1]; ++e) {
      const Push<R>& push = pushes[ends[e].value / 4];
      sum += push.impulse.w * abs(push.weight[ends[e].value % 4]);
    }
    moved.of[i].w = w[i] * sum;
  }
};

/// A claim that is nearer to what will be pushed: what these parts of the mass would push, or, as what has pushed may
/// have to let go, a tenth of what it was. Nothing moves.
template <class R>
struct RefineMassShares {
  ScatteredPoints<R> moved;
  const SelfContact<R>* contacts;
  Push<R>* pushes;
  KERNEL void operator()(int k) const {
    R& share = pushes[k].impulse.w;
    if (!(share > R(0))) return;
    const SelfContact<R>& c = contacts[k];
    const R W = inverse_mass(c, share, moved);
    if (W > tiny<R>()) share = max(R(0.1) * share, c.lambda + (c.bias - dot(c.n, relative_motion(c, moved))) / W);
  }
};

/// The impulse of each active contact (times dt): a push, and friction on positions as in
/// kernels/environment/contact.h.
template <class R, class Friction>
struct SolveContactsJacobi {
  ScatteredPoints<R> moved;
  SelfContact<R>* contacts;
  Friction friction;
  Push<R>* pushes;
  KERNEL void operator()(int k) const {
    Push<R>& push = pushes[k];
    const R share = push.impulse.w;
    push.impulse.w = R(0);
    if (!(share > R(0))) return;
    SelfContact<R>& c = contacts[k];
    const R W = inverse_mass(c, share, moved);
    if (!(W > tiny<R>())) return;
    const Vector3<R> motion = relative_motion(c, moved);
    const R along = dot(c.n, motion);
    const R dlambda = max((c.bias - along) / W, -c.lambda);
    c.lambda += dlambda;
    const Vector3<R> slide = motion - c.n * along;
    const Vector3<R> friction_impulse =
        clamp_to_friction_cone(c.friction_impulse + slide * (R(1) / W), friction(c) * c.lambda);
    const Vector3<R> impulse = c.n * dlambda - (friction_impulse - c.friction_impulse);
    c.friction_impulse = friction_impulse;
    push.impulse = {impulse.x, impulse.y, impulse.z, R(1)};
  }
};

/// Every particle takes its share of its contacts' impulses, in their order.
template <class R, class Turn>
struct GatherPushes {
  Displaced<R> p;
  const R* w;
  const Keyed* ends;
  const int* begin;
  const Push<R>* pushes;
  Turn turn;
  KERNEL void operator()(int i) const {
    if (begin[i] == begin[i + 1] || !(w[i] > R(0))) return;
    Vector3<R> sum{R(0), R(0), R(0)};
    for (int e = begin[i]; e < begin[i + 1]; ++e) {
      const Push<R>& push = pushes[ends[e].value / 4];
      if (push.impulse.w > R(0)) sum = sum + push.impulse.xyz() * push.weight[ends[e].value % 4];
    }
    p.add_displacement(i, turn(sum) * w[i]);
  }
};

/// Contacts that pushed in the last substep.
template <class R>
struct CountPushing {
  const SelfContact<R>* contacts;
  KERNEL Sum operator()(int k) const { return {contacts[k].lambda > R(0) ? 1.0 : 0.0}; }
};

}  // namespace malha
