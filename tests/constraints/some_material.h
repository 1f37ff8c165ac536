// SPDX-License-Identifier: Apache-2.0
// A material for each kind of the registry, for tests that iterate over it: those of two moduli have different ones,
// along a slanted direction.
#pragma once
#include <optional>
#include <type_traits>

#include "kernels/constraints/constraint_registry.h"
#include "malha/scene.h"

namespace malha {

template <class Kind>
constexpr bool is_orthotropic() {
  return std::is_same_v<Material<Kind>, Orthotropic>;
}

template <class Kind>
Material<Kind> some_material(double parameter = Kind::parameter.default_value) {
  if constexpr (is_orthotropic<Kind>())
    return {parameter, 0.4, 0.15, {0.6, 0.9, 0.3}};
  else
    return parameter;
}
/// The same for a set of constraints, and for a scene with the modulus Y.
template <class Kind>
std::optional<Orthotropic> some_orthotropic() {
  if constexpr (is_orthotropic<Kind>()) return some_material<Kind>();
  return {};
}
template <class Kind>
std::optional<Orthotropy> some_orthotropy(double Y) {
  if constexpr (is_orthotropic<Kind>()) return Orthotropy{0.4 * Y, 0.15 * Y, Vec3{0.6, 0.9, 0.3}};
  return {};
}

}  // namespace malha
