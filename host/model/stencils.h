// SPDX-License-Identifier: Apache-2.0
// Iteration over the stencils of a model, with their weights (kernels/projection/stencil.h).
#pragma once
#include <algorithm>

#include "host/model/model.h"
#include "kernels/constraints/constraint_registry.h"
#include "kernels/projection/rest.h"

namespace malha {

/// Calls f(Kind(), Kind::Stencil()) with the kind of a set of stencils.
template <class F>
void with_stencil(const ConstraintSet& set, F&& f) {
  with_kind(set.type, [&]<class Kind>(Kind kind) {
    if constexpr (Kind::filtered == Filtered::Stencil) f(kind, typename Kind::Stencil());
  });
}

/// One stencil of a set.
template <class Kind>
struct StencilOf {
  using Stencil = typename Kind::Stencil;
  static constexpr int n = Kind::particles;
  const int* particles;
  double alpha;  // compliance
  double weights[Stencil::vectors][n];
  double own[Stencil::coefficients];  // parameters of the stencil, see Stencil::weights()

  /// The largest stiffness at a corner.
  double stiffest() const {
    double most = 0;
    for (const auto& of_vector : weights)
      for (const double weight : of_vector) most = std::max(most, weight * weight / alpha);
    return most;
  }
};

/// Stencil c of a set of the model.
template <class Kind>
StencilOf<Kind> stencil_of(const Model& model, const ConstraintSet& set, int c) {
  using Stencil = typename Kind::Stencil;
  StencilOf<Kind> one{&set.particles[std::size_t(c) * Kind::particles], set.alpha(c), {}, {}};
  Vector3<double> q[Kind::particles];
  rest_positions(model, set).corners<Kind>(c, q);
  Stencil::weights(q, material_of<Kind>(set, c), one.weights, one.own);
  return one;
}

/// Calls f(StencilOf<Kind>) for each stencil of the model.
template <class F>
void for_each_stencil(const Model& model, F&& f) {
  for (const ConstraintSet& set : model.stencils)
    with_stencil(set, [&]<class Kind, class Stencil>(Kind, Stencil) {
      for (int c = 0; c < set.count(); ++c) f(stencil_of<Kind>(model, set, c));
    });
}

}  // namespace malha
