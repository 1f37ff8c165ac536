// SPDX-License-Identifier: Apache-2.0
// Views of the particles: one array a coordinate, so that neighbours are read and written many at a time.
#pragma once
#include "kernels/simd/vec.h"

namespace malha {

/// Points or vectors, as three arrays.
template <class R>
struct Points {
  R *x = nullptr, *y = nullptr, *z = nullptr;
  KERNEL Vector3<R> operator[](int i) const { return {x[i], y[i], z[i]}; }
  KERNEL void set(int i, const Vector3<R>& a) const { x[i] = a.x, y[i] = a.y, z[i] = a.z; }
  /// From j to i.
  KERNEL Vector3<R> between(int i, int j) const { return (*this)[i] - (*this)[j]; }
};

/// The same, four numbers a point: for those that are read here and there. Setting one leaves its w.
template <class R>
struct ScatteredPoints {
  Vec4<R>* of = nullptr;
  KERNEL Vector3<R> operator[](int i) const { return of[i].xyz(); }
  KERNEL void set(int i, const Vector3<R>& a) const { of[i].set(a); }
};

/// Whether positions carry what rounding them to R has lost (Kahan's summation).
template <class R>
inline constexpr bool kCarries = sizeof(R) < sizeof(double);

/// Where particles go in a substep: x + d, m. What is stored is how far, d, so that a short way keeps its digits
/// however far from the origin it is gone.
template <class R>
struct Displaced {
  Points<R> x, d, low;  // low: what x lacks of the position, of a type that carries it
  KERNEL Vector3<R> operator[](int i) const { return x[i] + whole(i, d[i]); }
  KERNEL void set(int i, const Vector3<R>& p) const {
    if constexpr (kCarries<R>)
      d.set(i, (p - x[i]) - low[i]);
    else
      d.set(i, p - x[i]);
  }
  /// To where it goes from what is stored as its x.
  KERNEL Vector3<R> way_from_x(int i) const { return whole(i, d[i]); }
  /// Where it goes, told from an origin near x: rounded to the spacing of numbers as large as that is far.
  KERNEL Vector3<R> near(int i, const Vector3<R>& origin) const {
    if constexpr (kCarries<R>)
      return (x[i] - origin) + whole(i, d[i]);
    else
      return (*this)[i];
  }
  /// Where the substep began, from a place near it that is told from an origin: exactly nothing, if near() has told it
  /// there. A type that carries nothing has no origin but 0.
  KERNEL Vector3<R> start_from(int i, const Vector3<R>& place, const Vector3<R>& origin) const {
    if constexpr (kCarries<R>)
      return ((x[i] - origin) + low[i]) - place;
    else
      return x[i] - place;
  }
  /// How far from there, and to so far from there: no way is rounded to the spacing of positions.
  KERNEL Vector3<R> from(int i, const Vector3<R>& place, const Vector3<R>& origin) const {
    return start_from(i, place, origin) + d[i];
  }
  KERNEL void set_from(int i, const Vector3<R>& place, const Vector3<R>& origin, const Vector3<R>& way) const {
    d.set(i, way - start_from(i, place, origin));
  }
  /// From j to i where the substep began; and now. Nothing is rounded to the spacing of positions.
  KERNEL Vector3<R> between_at_start(int i, int j) const {
    const Vector3<R> apart = x.between(i, j);
    if constexpr (kCarries<R>)
      return apart + low.between(i, j);
    else
      return apart;
  }
  KERNEL Vector3<R> between(int i, int j) const { return between_at_start(i, j) + d.between(i, j); }
  /// But for what x lacks, which what is remembered of places does not know.
  KERNEL Vector3<double> went(int i) const { return in_double(x[i]) + in_double(d[i]); }
  /// Where the substep began, and where it goes, as exactly as they are known.
  KERNEL Vector3<double> start(int i) const {
    if constexpr (kCarries<R>)
      return in_double(x[i]) + in_double(low[i]);
    else
      return in_double(x[i]);
  }
  KERNEL Vector3<double> exact(int i) const { return start(i) + in_double(d[i]); }
  KERNEL void add(int i, const Vector3<R>& way) const { d.set(i, d[i] + way); }
  /// The particle is there.
  KERNEL void put(int i, const Vector3<double>& place) const {
    const Vector3<R> near = rounded<R>(place);
    x.set(i, near), stay(i);
    if constexpr (kCarries<R>) low.set(i, rounded<R>(place - in_double(near)));
  }
  KERNEL void stay(int i) const { d.set(i, {R(0), R(0), R(0)}); }
  /// The particle is at p, and x with it.
  KERNEL void arrive(int i) const {
    const Vector3<R> before = x[i], way = whole(i, d[i]), p = before + way;
    x.set(i, p);
    if constexpr (kCarries<R>) low.set(i, lost_of(before, way, p));
  }

 private:
  KERNEL Vector3<R> whole(int i, const Vector3<R>& way) const {
    if constexpr (kCarries<R>)
      return way + low[i];
    else
      return way;
  }
};

/// Where particles go, from an origin.
template <class R>
struct FromOrigin {
  Displaced<R> p;
  Vector3<R> origin;  // m
  KERNEL Vector3<R> operator[](int i) const { return p.near(i, origin); }
};

/// Where the substep began, as something that `between` tells apart.
template <class R>
struct Started {
  Displaced<R> p;
  KERNEL Vector3<R> between(int i, int j) const { return p.between_at_start(i, j); }
};

template <class R>
struct Particles {
  int count;
  Points<R> x;     // position at the start of the substep, m
  Points<R> v;     // velocity, m/s
  Displaced<R> p;  // where it goes
  const R* w;      // 1 / m, 1/kg, 0 where pinned
};

}  // namespace malha
