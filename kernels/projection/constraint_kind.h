// SPDX-License-Identifier: Apache-2.0
// What a constraint kind is, said once: the contract that every file of kernels/constraints/ keeps. A kind that lacks a
// part does not compile, and the compiler names the concept below that it breaks.
//
// Beyond what a compiler can see, and tests/projection/constraints*_test.cpp check for every kind of the registry:
//   evaluate() answers s C and s grad C, where s > 0 depends on the places p alone, never on the rest values.
//     grad is the derivative of C, and blind to rigid motion: its sum and its sum of torques are zero.
//     Where there is no direction (coincident points, no area) every gradient is exactly zero, and C is finite.
//     Where `held` is false (padding) every gradient is zero, whatever p and the rest values are, NaN included.
//   rest() is finite on whatever mesh; its first value is the one that C is compared with.
//
// A kind may also have `multipliers` and step(), which meets several constraints at once
// (kernels/projection/block_solve.h), with energy() times its modulus; and a Remainder, a kind for what its own element
// leaves of a mesh.
#pragma once
#include <type_traits>

#include "kernels/projection/element.h"
#include "kernels/simd/pack.h"

namespace malha {

/// A constraint's own number in a scene: its key, its default and its range.
struct Parameter {
  const char* name;
  double default_value;
  double minimum;
  bool minimum_allowed;
  double maximum = INFINITY;
};

/// What a scene may say about how stiff a kind is.
struct Strength {
  bool free;            // "stiffness" or "compliance"
  const char* modulus;  // a material's, by its key: beside the free ones, or, where there are none, always. Or null
  const char* unit;     // of the modulus
};

/// What a kind is to Desbrun's filter: a spring between its two particles; a stencil (kernels/projection/stencil.h); or
/// nothing, because it is projected after the filter, as an inequality has to be.
enum class Filtered { Spring, Stencil, After };

/// What a kind makes of places that coincide, or of a triangle without area: no gradient, so that a projection skips
/// them; or the gradient that it has anywhere but where all of its particles are in one place.
enum class Degenerate { Skipped, Projected };

namespace kind {

template <class K>
concept IsNamed = requires {
  K::name[0];
}
&&K::name[0] != '\0';
template <class K>
concept StandsOnAnElement = requires {
  K::element == Element::Edges;
}
&&K::particles == facts_of(K::element).particles;
template <class K>
concept SaysWhetherItIsAnInequality = requires {
  bool(K::inequality);
};
template <class K>
concept SaysWhetherItMeasuresStrain = requires {
  bool(K::has_strain);
};
template <class K>
concept HasAParameter = requires {
  Parameter(K::parameter);
};
template <class K>
concept SaysHowStiffItCanBe = requires {
  Strength(K::strength);
};
template <class K>
concept TurnsItsModulusToACompliance = K::strength.free || requires {
  double(K::compliance(1.0, 1.0));
};
template <class K>
concept SaysWhatTheFilterSees = requires {
  Filtered(K::filtered);
}
&&(K::filtered == Filtered::After || !K::inequality) && (K::filtered != Filtered::Spring || K::particles == 2);
template <class K, class T, int n, int m = T::vectors, int numbers = T::numbers>
concept IsAStencil = (numbers > 0) &&
                     requires(const Vector3<double> (&X)[n], double (&c)[m][n], double (&own)[numbers],
                              const Vector3<float> (&f)[m], const float* from, Vector3<float> (&d)[m]) {
  T::weights(X, 1.0, c, own);
  T::target(f, from, d);
}
&&(!K::strength.free || requires(const Vector3<double> (&X)[n]) { double(T::lever(X)); });
template <class K>
concept HasAStencilIfItSaysSo = K::filtered != Filtered::Stencil || IsAStencil<K, typename K::Stencil, K::particles>;
template <class K>
concept SaysWhatDegenerateInputGives = requires {
  Degenerate(K::degenerate);
};
template <class K>
concept HasRestValues = K::numbers >
0 && requires(const Vector3<double> (&X)[K::particles], double (&rest)[K::numbers]) { K::rest(X, 1.0, rest); };
template <class K, class S, class RestOrNothing = decltype(S() == S())>
concept IsEvaluatedIn = requires(const Vector3<S> (&p)[K::particles], const S* rest, const RestOrNothing& held,
                                 Vector3<S> (&grad)[K::particles], S& scale) {
  requires std::is_same_v<decltype(K::evaluate(p, rest, held, grad, scale)), S>;
};

}  // namespace kind

template <class K>
concept ConstraintKind = kind::IsNamed<K> && kind::StandsOnAnElement<K> && kind::SaysWhetherItIsAnInequality<K> &&
    kind::SaysWhetherItMeasuresStrain<K> && kind::HasAParameter<K> && kind::SaysHowStiffItCanBe<K> &&
    kind::TurnsItsModulusToACompliance<K> && kind::SaysWhatTheFilterSees<K> && kind::HasAStencilIfItSaysSo<K> &&
    kind::SaysWhatDegenerateInputGives<K> && kind::HasRestValues<K> && kind::IsEvaluatedIn<K, float> &&
    kind::IsEvaluatedIn<K, double>;

}  // namespace malha
