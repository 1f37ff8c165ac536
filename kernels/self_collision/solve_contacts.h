// SPDX-License-Identifier: Apache-2.0
// Solver of self-contacts: Gauss-Seidel over blocks of pairs that share no particle (Müller et al. 2006; the
// accumulated push of a contact is never below 0), with Coulomb friction on positions (Macklin et al. 2014).
#pragma once
#include <type_traits>

#include "kernels/parallel/compute.h"
#include "kernels/self_collision/contact_block.h"

namespace malha {

/// Friction of self-contacts. Mapped: it has the mean of the factors at the two points of a contact.
enum class SelfFriction { None, Same, Mapped };

/// Groups: patches of one colour, which share no particle.
template <class R, SelfFriction kFriction>
struct SolveContacts {
  using Shared = void;
  static constexpr int kMostThreads = 32;  // half of them have a pair of a block
  Pairs<R> pairs;
  Vec4<R>* moved;             // p - x0; w: 1/kg
  R friction;                 // Coulomb's mu
  const R* factor = nullptr;  // of the friction, of each particle and the padding, where mapped

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    // Contacts whose closest point is on a boundary have oblique normals and would brake or push sliding bodies.
    // Interior contacts are usually as near: solve them first, and boundary contacts on the rest.
    for (const bool rim : {false, true})
      pairs.patches[group.index].for_each_block([&](int b, int) KERNEL_LAMBDA {
        const PairBits bits = pairs.bits[b];
        const unsigned selected = rim ? bits.rim : bits.near & ~bits.rim;
        constexpr int lanes = kLanes<R, Isa>;
        constexpr unsigned all = (1ull << lanes) - 1;
        if (selected == 0) return;
        group.for_each(kPairBlock / lanes, [&](int pack) KERNEL_LAMBDA {
          const int k = pack * lanes;
          if (selected >> k & all) solve<Lane<R, Isa>>(pairs.blocks[b], k, selected >> k & all);
        });
      });
  }

 private:
  template <class S>
  KERNEL void solve(ContactBlock<R>& block, int k, unsigned selected) const {
    const S zero(R(0)), one(R(1));
    Vector3<S> m[4], n;
    S u[4], w[4], bias, lambda;
    for (int j = 0; j < 4; ++j) gather_rows(moved, block.i[j] + k, m[j], u[j]);
    load(block.n[0] + k, n.x), load(block.n[1] + k, n.y), load(block.n[2] + k, n.z);
    for (int j = 0; j < 3; ++j) load(block.w[j] + k, w[1 + j]);
    w[0] = -(w[1] + w[2] + w[3]);
    load(block.bias + k, bias), load(block.lambda + k, lambda);
    const Vector3<S> motion = m[0] * w[0] + m[1] * w[1] + m[2] * w[2] + m[3] * w[3];
    const S along = dot(n, motion);
    const auto active = ((lambda > zero) | (along < bias)) & mask_from_bits<S>(selected);
    if (movemask(active) == 0) return;
    const S W = w[0] * w[0] * u[0] + w[1] * w[1] * u[1] + w[2] * w[2] * u[2] + w[3] * w[3] * u[3];
    const auto moves = active & (W > S(tiny<R>()));
    const S per = select(moves, one / W, zero);
    const S dlambda = select(moves, max((bias - along) * per, -lambda), zero);
    lambda = lambda + dlambda;
    store(lambda, block.lambda + k);
    Vector3<S> impulse = n * dlambda;
    if constexpr (kFriction != SelfFriction::None) {
      Vector3<S> friction_impulse;
      load(block.friction_impulse[0] + k, friction_impulse.x), load(block.friction_impulse[1] + k, friction_impulse.y),
          load(block.friction_impulse[2] + k, friction_impulse.z);
      const Vector3<S> trial = friction_impulse + (motion - n * along) * per;
      const S length = sqrt(dot(trial, trial)), most = mu_of(block, k, w) * lambda;
      const Vector3<S> clamped = trial * select(length > most, most / length, one);
      impulse = impulse - (clamped - friction_impulse);
      store(clamped.x, block.friction_impulse[0] + k), store(clamped.y, block.friction_impulse[1] + k),
          store(clamped.z, block.friction_impulse[2] + k);
    }
    // Inactive lanes keep their values, to the bit: their weights may be NaN.
    for (int j = 0; j < 4; ++j)
      scatter_rows(moved, block.i[j] + k, m[j] + or_zero(moves, impulse * (w[j] * u[j])), u[j]);
  }

  template <class S>
  KERNEL S mu_of(const ContactBlock<R>& block, int k, const S (&w)[4]) const {
    if constexpr (kFriction == SelfFriction::Same) return S(friction);
    S sum = S(R(0));  // the weights of each side add up to 1
    for (int j = 0; j < 4; ++j) {
      S own;
      if constexpr (std::is_same_v<S, R>)
        own = factor[block.i[j][k] / kIndexScale<R>];
      else
        for (int l = 0; l < S::lanes; ++l) set_lane(own, l, factor[block.i[j][k + l] / kIndexScale<R>]);
      sum = sum + abs(w[j]) * own;
    }
    return sum * S(R(0.5) * friction);
  }
};

/// Counts the contacts of a patch that pushed in the last projection.
template <class R>
struct CountPushes {
  Pairs<R> pairs;
  KERNEL Sum operator()(int u) const {
    int count = 0;
    pairs.patches[u].for_each_block([&](int b, int) KERNEL_LAMBDA {
      for (unsigned near = pairs.bits[b].near; near != 0; near &= near - 1)
        count += pairs.blocks[b].lambda[lowest_bit(near)] > R(0) ? 1 : 0;
    });
    return {double(count)};
  }
};

}  // namespace malha
