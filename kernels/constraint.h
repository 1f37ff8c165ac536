// One projection, written once for every constraint: gather, evaluate, PBD or XPBD update, scatter.
#pragma once
#include "kernels/pack.h"

namespace malha {

/// What of a mesh a constraint stands on.
enum class Element { Edges, Hinges };

/// A constraint's own number in a scene: its key, its default and its smallest value.
struct Parameter {
  const char* name;
  double standard;
  double minimum;
  bool minimum_allowed;
};

/// Stiff: PBD, dp = -k' w grad C / sum w |grad C|^2 (Müller et al. 2006).
/// Compliant: XPBD, dlambda = (-C - alpha~ lambda) / (sum w |grad C|^2 + alpha~) (Macklin, Müller, Chentanez 2016).
enum class Update { Stiff, Compliant };

/// Constraints that share no movable particle: `begin` is a multiple of the pack's lanes; the first `plain` are full
/// packs without pins; padding repeats the last constraint, so that its loads are harmless.
struct Batch {
  int begin, count, plain;
};

/// Projects one pack of a batch. Indices, rest values and lambda are in batch order, aligned to a pack.
template <class Kind, class R, Update update>
struct Project {
  using S = Lane<R>;
  Vec4<R>* p;  // predicted positions and w = 1 / m
  const int* index[Kind::particles];
  const R* rest;
  R* lambda;     // Compliant only: accumulated over the iterations of a substep
  R stiffness;   // Stiff only: k'
  R compliance;  // Compliant only: alpha~ = alpha / dt^2
  Batch batch;

  KERNEL void operator()(int pack) const {
    constexpr int n = Kind::particles;
    const int at = batch.begin + pack * kLanes<R>;
    Vector3<S> q[n], grad[n];
    S w[n], l;
    for (int j = 0; j < n; ++j) gather(p, index[j] + at, q[j], w[j]);
    load(rest + at, l);
    const S C = Kind::evaluate(q, l, grad);
    S sum = w[0] * dot(grad[0], grad[0]);
    for (int j = 1; j < n; ++j) sum = sum + w[j] * dot(grad[j], grad[j]);

    const S zero(R(0)), one(R(1));
    const auto moves = sum > S(tiny<R>());  // no gradient or no movable particle: skip, never NaN
    S dlambda;
    if constexpr (update == Update::Stiff) {
      dlambda = -C * S(stiffness) / select(moves, sum, one);
      if constexpr (Kind::inequality) dlambda = larger(dlambda, zero);
      dlambda = select(moves, dlambda, zero);
    } else {
      const S alpha(compliance);
      S total;
      load(lambda + at, total);
      dlambda = (-C - alpha * total) / select(moves, sum + alpha, one);
      if constexpr (Kind::inequality) dlambda = larger(dlambda, -total);
      dlambda = select(moves, dlambda, zero);
      store(total + dlambda, lambda + at);
    }
    for (int j = 0; j < n; ++j) q[j] = q[j] + grad[j] * (w[j] * dlambda);

    const int lanes = batch.count - pack * kLanes<R>;
    if (pack * kLanes<R> < batch.plain) {
      for (int j = 0; j < n; ++j) scatter(p, index[j] + at, q[j], w[j]);
    } else {
      for (int j = 0; j < n; ++j) scatter_movable(p, index[j] + at, lanes < kLanes<R> ? lanes : kLanes<R>, q[j], w[j]);
    }
  }
};

}  // namespace malha
