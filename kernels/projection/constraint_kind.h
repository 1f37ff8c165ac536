// SPDX-License-Identifier: Apache-2.0
// The concept of a constraint kind, which every file of kernels/constraints/ satisfies. A kind that lacks a part does
// not compile, and the compiler names the concept below that it breaks.
//
// The compiler cannot check the following, so that tests/projection/constraints*_test.cpp check it for every kind of
// the registry:
//   evaluate() returns s C and s grad C, where s > 0 depends on the positions p alone, never on the rest values.
//     grad is the derivative of C and invariant to rigid motion: its sum and its sum of torques are zero.
//     Where there is no direction (coincident points, no area) every gradient is exactly zero, and C is finite.
//     Where `valid` is false (padding) every gradient is zero, whatever p and the rest values are, NaN included.
//   rest() is finite on any mesh; its first value is the one that C is compared with.
//
// A kind may also have `multipliers` and step(), which solves several constraints at once
// (kernels/projection/block_solve.h), with energy(), the elastic energy times the compliance; and a Remainder, a kind
// for the part of a mesh that has no element of its own kind.
#pragma once
#include <type_traits>

#include "kernels/projection/element.h"
#include "kernels/simd/vec.h"

namespace malha {

/// A parameter of a kind in a scene: its key, its default and its range.
struct Parameter {
  const char* name;
  double default_value;
  double minimum;
  bool minimum_allowed;
  double maximum = INFINITY;
};

/// The ways in which a scene may give the stiffness of a kind.
struct Strength {
  bool accepts_stiffness;  // the keys "stiffness" and "compliance"
  const char* modulus;     // key of a material modulus, the only way where those keys are not accepted; null: none
  const char* unit;        // of the modulus
};

/// How Desbrun's filter treats a kind: as a spring between its two particles; as a stencil
/// (kernels/projection/stencil.h); or not at all, because it is projected after the filter, as inequalities have to be.
enum class Filtered { Spring, Stencil, After };

/// Tells whether a kind is the bending of a surface. PBD filters it where its projection would be too soft.
template <class Kind>
constexpr bool bends() {
  return Kind::element == Element::Hinges || Kind::element == Element::WingedTriangles;
}

namespace kind {

template <class K>
concept HasName = requires {
  K::name[0];
}
&&K::name[0] != '\0';
template <class K>
concept HasElement = requires {
  K::element == Element::Edges;
}
&&K::particles == facts_of(K::element).particles;
template <class K>
concept DeclaresInequality = requires {
  bool(K::inequality);
};
template <class K>
concept HasParameter = requires {
  Parameter(K::parameter);
};
template <class K>
concept HasStrength = requires {
  Strength(K::strength);
};
template <class K>
concept ConvertsModulus = K::strength.accepts_stiffness || requires {
  double(K::compliance(1.0, 1.0));
};
template <class K>
concept DeclaresFiltered = requires {
  Filtered(K::filtered);
}
&&(K::filtered == Filtered::After || !K::inequality) && (K::filtered != Filtered::Spring || K::particles == 2);
template <class K, class T, int n, int m = T::vectors, int coefficients = T::coefficients>
concept StencilType = (coefficients > 0) &&
                      requires(const Vector3<double> (&X)[n], double (&c)[m][n], double (&own)[coefficients],
                               const Vector3<float> (&f)[m], const float* from, Vector3<float> (&d)[m]) {
  T::weights(X, 1.0, c, own);
  T::target(f, from, d);
}
&&(!K::strength.accepts_stiffness || requires(const Vector3<double> (&X)[n]) { double(T::lever(X)); });
template <class K>
concept HasStencilIfFiltered = K::filtered != Filtered::Stencil || StencilType<K, typename K::Stencil, K::particles>;
template <class K>
concept HasRestValues = K::rest_values >
0 && requires(const Vector3<double> (&X)[K::particles], double (&rest)[K::rest_values]) { K::rest(X, 1.0, rest); };
template <class K, class S, class Mask = decltype(S() == S())>
concept HasEvaluate = requires(const Vector3<S> (&p)[K::particles], const S* rest, const Mask& valid,
                               Vector3<S> (&grad)[K::particles], S& scale) {
  requires std::is_same_v<decltype(K::evaluate(p, rest, valid, grad, scale)), S>;
};

}  // namespace kind

template <class K>
concept ConstraintKind =
    kind::HasName<K> && kind::HasElement<K> && kind::DeclaresInequality<K> && kind::HasParameter<K> &&
    kind::HasStrength<K> && kind::ConvertsModulus<K> && kind::DeclaresFiltered<K> && kind::HasStencilIfFiltered<K> &&
    kind::HasRestValues<K> && kind::HasEvaluate<K, float> && kind::HasEvaluate<K, double>;

}  // namespace malha
