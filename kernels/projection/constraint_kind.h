// SPDX-License-Identifier: Apache-2.0
// The concept of a constraint kind, which every file of kernels/constraints/ satisfies. A kind that lacks a part does
// not compile, and the compiler names the concept below that it breaks.
//
// The compiler cannot check the following, so that tests/projection/constraints*_test.cpp check it for every kind of
// the registry:
//   evaluate() returns s C and s grad C, where s > 0 depends on the positions p alone, never on the rest values.
//     (Weights of particles, as those of an attachment, are no quantity that C is compared with: s may depend on them.)
//     grad is the derivative of C and invariant to rigid motion: its sum and its sum of torques are zero.
//     Where there is no direction (coincident points, no area) every gradient is exactly zero, and C is finite.
//     Where `valid` is false (padding) every gradient is zero, whatever p and the rest values are, NaN included.
//   rest() is finite on any mesh; its first value is the one that C is compared with.
//
// A kind may also have `multipliers` and step(), which solves several constraints at once
// (kernels/projection/block_solve.h), with energy(), the elastic energy times the compliance; and a Remainder, a kind
// for the part of a mesh that has no element of its own kind. A kind of orthotropic material has a Material other than
// its parameter, and is the variant of an `Isotropic` kind, by whose name scenes name it.
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

/// Constants of an orthotropic material (kernels/constraints/orthotropic.h). The moduli are over that along.
struct Orthotropic {
  double nu = 0;                   // Poisson's ratio, contraction across over stretch along
  double across = 1;               // modulus across
  double shear = 0.5;              // in shear, or in twist
  Vector3<double> along{1, 0, 0};  // in the space of the rest positions, of any length

  KERNEL bool operator==(const Orthotropic& o) const {
    return nu == o.nu && across == o.across && shear == o.shear && along.x == o.along.x && along.y == o.along.y &&
           along.z == o.along.z;
  }

  /// 1 / (1 - nu_12 nu_21): the modulus along where nothing can contract across.
  KERNEL double c11() const { return 1 / (1 - nu * nu * across); }
  /// The largest modulus of a sheet in any strain.
  KERNEL double stiffest() const {
    const double mean = (1 + across) / 2 * c11(), difference = (1 - across) / 2 * c11(), c12 = nu * across * c11();
    const double most = mean + sqrt(difference * difference + c12 * c12);
    return most > 2 * shear ? most : 2 * shear;
  }
  /// The modulus of a strip of a sheet, and the rigidity of a plate that is bent to a cylinder, in a direction whose
  /// angle with `along` has this squared cosine.
  KERNEL double modulus(double c2) const {
    const double s2 = 1 - c2;
    return 1 / (c2 * c2 + (1 / shear - 2 * nu) * c2 * s2 + s2 * s2 / across);
  }
  KERNEL double rigidity(double c2) const {
    const double s2 = 1 - c2;
    return c2 * c2 + 2 * (nu * across + 2 * shear) * c2 * s2 + across * s2 * s2;
  }
  /// The squared cosine of the angle between `along`, projected into the plane of normal n, and a direction d in it.
  KERNEL double cosine2(const Vector3<double>& n, const Vector3<double>& d) const {
    const double n2 = dot(n, n);
    const Vector3<double> in_plane = along - n * (n2 > 0 ? dot(along, n) / n2 : 0);
    const double size2 = dot(in_plane, in_plane) * dot(d, d), both = dot(in_plane, d);
    return size2 > 0 ? both * both / size2 : 1;
  }
};

/// The constants from which a kind computes its rest values: a type `Material` of the kind, or its parameter.
template <class Kind>
struct MaterialOf {
  using type = double;
};
template <class Kind>
requires requires { typename Kind::Material; }
struct MaterialOf<Kind> {
  using type = typename Kind::Material;
};
template <class Kind>
using Material = typename MaterialOf<Kind>::type;

/// The kind by which a kind is projected: another one, its `Projected`, if only its rest values differ from that.
template <class Kind>
struct ProjectedAs {
  using type = Kind;
};
template <class Kind>
requires requires { typename Kind::Projected; }
struct ProjectedAs<Kind> {
  using type = typename Kind::Projected;
};
template <class Kind>
using Projected = typename ProjectedAs<Kind>::type;

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
                               const Material<K>& material, const Vector3<float> (&f)[m], const float* from,
                               Vector3<float> (&d)[m]) {
  T::weights(X, material, c, own);
  T::target(f, from, d);
}
&&(!K::strength.accepts_stiffness || requires(const Vector3<double> (&X)[n]) { double(T::lever(X)); });
template <class K>
concept HasStencilIfFiltered = K::filtered != Filtered::Stencil || StencilType<K, typename K::Stencil, K::particles>;
template <class K>
concept HasRestValues = K::rest_values >
0 && requires(const Vector3<double> (&X)[K::particles], const Material<K>& material, double (&rest)[K::rest_values]) {
  K::rest(X, material, rest);
};
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
