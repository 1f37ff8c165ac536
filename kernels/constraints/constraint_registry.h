// SPDX-License-Identifier: Apache-2.0
// Registry of constraint kinds, with an include and a name for each. Colouring, batching, scenes, reports and tests
// iterate over it.
#pragma once
#include <type_traits>

#include "kernels/constraints/bending.h"
#include "kernels/constraints/distance.h"
#include "kernels/constraints/isometric_bending.h"
#include "kernels/constraints/membrane.h"
#include "kernels/constraints/neo_hookean.h"
#include "kernels/constraints/orthotropic.h"
#include "kernels/constraints/plate.h"
#include "kernels/constraints/seam.h"
#include "kernels/constraints/volume.h"

namespace malha {

template <ConstraintKind... Kinds>
struct KindList {};

/// Seams come first. A symmetric sweep projects the first kinds last, so that nothing opens a seam after it.
using ConstraintKinds = KindList<Seam, SurfaceAttachment, Distance, DistanceLimit, Membrane, OrthotropicMembrane,
                                 Bending, IsometricBending, Plate, OrthotropicPlate, Volume, NeoHookean>;

/// Calls f(Kind{}) for every kind, in the order in which they are projected.
template <class F, ConstraintKind... Kinds>
KERNEL void for_each_constraint(F&& f, KindList<Kinds...>) {
  (f(Kinds{}), ...);
}
template <class F>
KERNEL void for_each_constraint(F&& f) {
  for_each_constraint(static_cast<F&&>(f), ConstraintKinds{});
}

/// Index of a kind in a list, by which kernels identify it; -1: not in the list.
template <class Kind, ConstraintKind... Kinds>
constexpr int kind_index(KindList<Kinds...>) {
  int number = -1, next = 0;
  ((std::is_same_v<Kind, Kinds> ? void(number = next++) : void(++next)), ...);
  return number;
}

/// Calls f(Kind{}) for the kind of this name, if it is in the list. The host identifies kinds by their names.
template <class Name, class F, class Kinds = ConstraintKinds>
void with_kind(const Name& name, const F& f, Kinds kinds = {}) {
  for_each_constraint(
      [&]<class Kind>(Kind kind) {
        if (name == Kind::name) f(kind);
      },
      kinds);
}

/// The name of a kind in scenes: variants of another kind have that of it.
template <class Kind>
constexpr const char* name_in_scenes() {
  if constexpr (requires { typename Kind::Isotropic; })
    return Kind::Isotropic::name;
  else
    return Kind::name;
}

/// Tells whether scenes may name a kind among the constraints of a body. Those of seams belong to the scene.
template <class Kind>
constexpr bool is_of_mesh() {
  return !facts_of(Kind::element).sewn;
}

}  // namespace malha
