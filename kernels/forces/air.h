// SPDX-License-Identifier: Apache-2.0
// Air on faces. A face of area A and normal n that the air meets with the relative velocity u feels
//   drag  1/2 rho C_D A (u . n)^2 u / |u|                    along the air,
//   lift  1/2 rho C_L A (u . n) (|u| n - (u . n) u / |u|)    across it,
// which go as sin^2 alpha and sin alpha cos alpha of the angle of attack: a flat plate's after its stall (Viterna and
// Corrigan 1982); the split into drag and lift of faces is that of Ling and Damodaran (2000) and Wilson et al.,
// "Simulating wind effects on cloth and hair in Disney's Frozen" (2014). With C_L = C_D both are a pressure along n.
// Every corner has its share of a face's area and its own velocity (all the same for a face in translation), so that
// the update of a particle depends on no other, and is bounded: drag is implicit in u, and lift rotates u without
// changing its length. Whatever the step, air only dissipates the energy of motion relative to it.
#pragma once
#include "kernels/simd/particles.h"

namespace malha {

/// Computes S / sqrt|S| for each face, with S = A n a corner's share of its area vector: (S . u) S / |S| is then a
/// product of such vectors. S of a quad is computed from its diagonals.
template <class R>
struct FacesInAir {
  Displaced<R> p;
  const int* corners;  // four per face; the last of a triangle is below 0
  Points<R> faces;
  KERNEL void operator()(int f) const {
    const int *at = corners + 4 * f, last = at[3];
    const Vector3<R> ac = p.start_difference(at[2], at[0]);
    const Vector3<R> S = last < 0 ? cross(p.start_difference(at[1], at[0]), ac) * (R(1) / R(6))
                                  : cross(ac, p.start_difference(last, at[1])) * (R(1) / R(8));
    const R area2 = dot(S, S);
    faces.set(f, area2 > tiny<R>() ? S * (R(1) / sqrt(sqrt(area2))) : Vector3<R>{R(0), R(0), R(0)});
  }
};

template <class R>
struct ApplyWindForces {
  Points<R> v;
  const R* w;
  const int* particle;        // of each item
  const int *begin, *around;  // faces of each item, one more at the end of begin
  Points<R> faces;
  Vector3<R> wind;   // m/s
  R dt, drag, lift;  // the substep h (s), 1/2 rho C_D and 1/2 rho C_L (kg/m^3)
  KERNEL void operator()(int item) const {
    const int i = particle[item];
    const R h = dt * w[i];
    const Vector3<R> u = wind - v[i];
    const R speed2 = dot(u, u), speed = sqrt(speed2);
    if (!(h > R(0)) || !(speed2 > tiny<R>())) return;
    Vector3<R> side{R(0), R(0), R(0)};  // sum of A (u . n) n
    for (int k = begin[item]; k < begin[item + 1]; ++k) {
      const Vector3<R> face = faces[around[k]];
      side = side + face * dot(u, face);
    }
    const R q = dot(u, side) / speed2;  // sum of A (u . n)^2 / |u|^2
    const Vector3<R> turned = u - (side - u * q) * (h * lift * speed);
    const R slower = R(1) + h * drag * q * speed;
    const R kept = sqrt(speed2 / (dot(turned, turned) * slower * slower));
    v.set(i, v[i] + (u - turned * kept));
  }
};

}  // namespace malha
