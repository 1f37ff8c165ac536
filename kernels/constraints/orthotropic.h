// SPDX-License-Identifier: Apache-2.0
// Kinds of orthotropic material, such as woven fabric: `membrane` and `plate` with two moduli and one in shear or
// twist. A strain or curvature e of a triangle is given by its a = e11 + e22, b = e11 - e22, c = 2 e12 in the frame
// whose first axis is the triangle's first edge. With nu_21 = nu_12 E_2 / E_1 the energy over E_1 and area is
//   (c11 e11^2 + c22 e22^2 + 2 c12 e11 e22 + g c^2) / 2, in the axes of the material,
//     membrane: c11 = 1 / (1 - nu_12 nu_21), c22 = E_2 / E_1 c11, c12 = nu_12 c22, g = G_12 / E_1;
//     plate:    c11 = 1, c22 = D_2 / D_1, c12 = nu_12 c22, g = D_66 / D_1 (Timoshenko, Woinowsky-Krieger, "Theory of
//               plates and shells", 1959, chapter 11),
// that is |L (a, b, c)|^2 / 2 with an upper triangular L. The strain of the membrane is Biot's, which makes it St.
// Venant-Kirchhoff's material where strains are small, and leaves it the robustness of the isotropic one where they are
// not.
#pragma once
#include "kernels/constraints/membrane.h"
#include "kernels/constraints/plate.h"

namespace malha {

/// L of the energy of c11, c22, c12 and g, for a triangle with the sides e and f from its corner 0. The direction
/// `along` of the material, of any length, is projected into the triangle; where nothing of it is left it is e.
struct OrthotropicLaw {
  double L[6];  // L00, L01, L02, L11, L12, L22

  KERNEL OrthotropicLaw(const Vector3<double>& e, const Vector3<double>& f, const Vector3<double>& along, double c11,
                        double c22, double c12, double g) {
    // In the axes of the material the energy is K00 a^2 + 2 K01 a b + K11 b^2 + g c^2; b and c turn by twice the angle.
    const double K00 = (c11 + c22 + 2 * c12) / 4, K01 = (c11 - c22) / 4, K11 = (c11 + c22 - 2 * c12) / 4;
    const Vector3<double> n = cross(e, f);
    const double x = dot(along, e) * sqrt(dot(n, n)), y = dot(along, cross(n, e)), size2 = x * x + y * y;
    const double per_size2 = size2 > 0 ? 1 / size2 : 0;
    const double c2 = size2 > 0 ? (x * x - y * y) * per_size2 : 1, s2 = 2 * x * y * per_size2;
    L[0] = sqrt(K00), L[1] = K01 * c2 / L[0], L[2] = K01 * s2 / L[0];
    L[3] = sqrt(K11 * c2 * c2 + g * s2 * s2 - L[1] * L[1]);
    L[4] = ((K11 - g) * c2 * s2 - L[1] * L[2]) / L[3];
    L[5] = sqrt(K11 * s2 * s2 + g * c2 * c2 - L[2] * L[2] - L[4] * L[4]);
  }
};

/// The law of a triangle: C = L (a, b, c).
template <class S>
struct TriangularLaw {
  static constexpr int numbers = 6;
  S k[6];
  KERNEL void constraints(const S& a, const S& b, const S& c, S (&C)[3]) const {
    C[0] = k[0] * a + k[1] * b + k[2] * c, C[1] = k[3] * b + k[4] * c, C[2] = k[5] * c;
  }
  KERNEL void pull(const S (&part)[3], S& a, S& b, S& c) const {
    a = k[0] * part[0], b = k[1] * part[0] + k[3] * part[1], c = k[2] * part[0] + k[4] * part[1] + k[5] * part[2];
  }
  KERNEL void surround(S (&A)[3][3]) const {
    // Rows of L A, of which those below the diagonal of L A L^T are not needed.
    const S a0 = k[0] * A[0][0] + k[1] * A[1][0] + k[2] * A[2][0],
            a1 = k[0] * A[1][0] + k[1] * A[1][1] + k[2] * A[2][1];
    const S a2 = k[0] * A[2][0] + k[1] * A[2][1] + k[2] * A[2][2];
    const S b1 = k[3] * A[1][1] + k[4] * A[2][1], b2 = k[3] * A[2][1] + k[4] * A[2][2];
    A[0][0] = a0 * k[0] + a1 * k[1] + a2 * k[2], A[1][0] = a1 * k[3] + a2 * k[4], A[2][0] = a2 * k[5];
    A[1][1] = b1 * k[3] + b2 * k[4], A[2][1] = b2 * k[5];
    A[2][2] = k[5] * A[2][2] * k[5];
  }
};

struct OrthotropicMembrane : MembraneOf<TriangularLaw> {
  static constexpr const char* name = "orthotropic_membrane";
  static constexpr const char* shear = "shear_modulus";  // key in scenes
  using Isotropic = Membrane;
  using Material = Orthotropic;

  KERNEL static void rest(const Vector3<double> (&X)[3], const Orthotropic& of, double (&rest)[9]) {
    const double size = sqrt(2 * rest_edges(X, rest));
    const OrthotropicLaw law = law_of(X, of);
    for (int i = 0; i < 6; ++i) rest[3 + i] = size > 0 ? size * law.L[i] : 0;
  }

  /// As that of the isotropic membrane, with the largest stiffness of this material.
  struct Stencil {
    static constexpr int vectors = 2, coefficients = 7;
    /// own: sqrt(A w / Y), m, and L sqrt(Y / w).
    KERNEL static void weights(const Vector3<double> (&X)[3], const Orthotropic& of, double (&c)[2][3],
                               double (&own)[7]) {
      double q[3];
      const double area = 2 * rest_edges(X, q), stiffest = of.stiffest(), size = sqrt(area * stiffest);
      c[0][1] = q[0] * size, c[0][2] = 0;
      c[1][1] = q[1] * size, c[1][2] = q[2] * size;
      for (double(&f)[3] : c) f[0] = -(f[1] + f[2]);
      const OrthotropicLaw law = law_of(X, of);
      own[0] = size;
      for (int i = 0; i < 6; ++i) own[1 + i] = size > 0 ? law.L[i] / sqrt(stiffest) : 0;
    }
    template <class S>
    KERNEL static void target(const Vector3<S> (&f)[2], const S* own, Vector3<S> (&d)[2]) {
      const S one(1);
      const auto whole = own[0] > S(0);
      const S per_size = one / select(whole, own[0], one);
      const Strained<S> at({f[0] * per_size, f[1] * per_size}, whole);
      TriangularLaw<S> law;
      for (int i = 0; i < 6; ++i) law.k[i] = own[1 + i];
      S C[3], a, b, c;
      law.constraints(at.a, at.b, at.c, C), law.pull(C, a, b, c);
      Vector3<S> P[2];
      at.pull(a, b, c, P);
      for (int k = 0; k < 2; ++k) d[k] = f[k] - P[k] * own[0];
    }
  };

 private:
  KERNEL static OrthotropicLaw law_of(const Vector3<double> (&X)[3], const Orthotropic& of) {
    const double c11 = of.c11(), c22 = of.across * c11;
    return {X[1] - X[0], X[2] - X[0], of.along, c11, c22, of.nu * c22, of.shear};
  }
};

struct OrthotropicPlate : Plate {
  static constexpr const char* name = "orthotropic_plate";
  static constexpr const char* shear = "twisting_rigidity";
  using Isotropic = Plate;
  using Material = Orthotropic;
  using Projected = Plate;  // only the rest values differ

  KERNEL static void rest(const Vector3<double> (&X)[6], const Orthotropic& of, double (&rest)[rest_values]) {
    rest_by<Law>(X, of, rest);
  }

  struct Stencil : Plate::Stencil {
    KERNEL static void weights(const Vector3<double> (&X)[6], const Orthotropic& of, double (&c)[3][6],
                               double (&own)[21]) {
      double numbers[rest_values];
      rest(X, of, numbers);
      weights_of(X, numbers, c, own);
    }
  };

 private:
  struct Law : OrthotropicLaw {
    double size;  // m
    KERNEL Law(const Vector3<double> (&X)[6], double area, const Orthotropic& of)
        : OrthotropicLaw(X[1] - X[0], X[2] - X[0], of.along, 1, of.across, of.nu * of.across, of.shear),
          size(sqrt(area)) {}
    KERNEL void apply(const double (&z)[3], double (&y)[3]) const {
      apply_scaled(z, y);
      for (double& of : y) of *= size;
    }
    KERNEL void apply_scaled(const double (&z)[3], double (&y)[3]) const {
      y[0] = L[0] * z[0] + L[1] * z[1] + L[2] * z[2], y[1] = L[3] * z[1] + L[4] * z[2], y[2] = L[5] * z[2];
    }
    KERNEL void row_scaled(const double (&per_z)[3], double (&per_y)[3]) const {
      per_y[0] = per_z[0] / L[0], per_y[1] = (per_z[1] - per_y[0] * L[1]) / L[3];
      per_y[2] = (per_z[2] - per_y[0] * L[2] - per_y[1] * L[4]) / L[5];
    }
  };
};

}  // namespace malha
