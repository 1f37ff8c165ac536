// SPDX-License-Identifier: Apache-2.0
// Views of particle arrays: one array per coordinate, so that packs of neighbouring particles are loaded and stored,
// which load_points() and store_points() do.
#pragma once
#include "kernels/simd/pack.h"

namespace malha {

/// Points or vectors, as three arrays.
template <class R>
struct Points {
  R *x = nullptr, *y = nullptr, *z = nullptr;
  KERNEL Vector3<R> operator[](int i) const { return {x[i], y[i], z[i]}; }
  KERNEL void set(int i, const Vector3<R>& a) const { x[i] = a.x, y[i] = a.y, z[i] = a.z; }
  /// The vector from j to i.
  KERNEL Vector3<R> difference(int i, int j) const { return (*this)[i] - (*this)[j]; }
};

/// Points as rows of four numbers, for points that are read in no particular order. Setting a point leaves its w.
template <class R>
struct ScatteredPoints {
  Vec4<R>* of = nullptr;
  KERNEL Vector3<R> operator[](int i) const { return of[i].xyz(); }
  KERNEL void set(int i, const Vector3<R>& a) const { of[i].set(a); }
};

/// Tells whether positions of type R carry the rounding error of their last sum along (Kahan's compensated summation).
template <class R>
inline constexpr bool kCompensated = sizeof(R) < sizeof(double);

/// Positions of particles in a substep, x + d, m. The displacement d is stored instead of the position, so that a short
/// one keeps its digits however far from the origin the particle is.
template <class R>
struct Displaced {
  Points<R> x, d, low;  // low: the start of the substep less x, its rounding error; of compensated types only
  KERNEL Vector3<R> operator[](int i) const { return x[i] + with_low(i, d[i]); }
  KERNEL void set(int i, const Vector3<R>& p) const {
    if constexpr (kCompensated<R>)
      d.set(i, (p - x[i]) - low[i]);
    else
      d.set(i, p - x[i]);
  }
  /// The position less x.
  KERNEL Vector3<R> offset_from_x(int i) const { return with_low(i, d[i]); }
  /// The position less an origin near x: its rounding error is relative to the distance from that origin.
  KERNEL Vector3<R> relative_to(int i, const Vector3<R>& origin) const { return (x[i] - origin) + with_low(i, d[i]); }
  /// The start of the substep less a reference point near it, which is given relative to `origin`: exactly 0 where
  /// relative_to() gave that point and d was 0. Types that are not compensated have origin 0.
  KERNEL Vector3<R> start_relative_to(int i, const Vector3<R>& reference, const Vector3<R>& origin) const {
    return with_low(i, x[i] - origin) - reference;
  }
  /// The position less such a reference point, read and set: neither is rounded to the spacing of positions.
  KERNEL Vector3<R> displacement_from(int i, const Vector3<R>& reference, const Vector3<R>& origin) const {
    return start_relative_to(i, reference, origin) + d[i];
  }
  KERNEL void set_displacement_from(int i, const Vector3<R>& reference, const Vector3<R>& origin,
                                    const Vector3<R>& displacement) const {
    d.set(i, displacement - start_relative_to(i, reference, origin));
  }
  /// The vector from j to i at the start of the substep, and now. Neither is rounded to the spacing of positions.
  KERNEL Vector3<R> start_difference(int i, int j) const {
    const Vector3<R> apart = x.difference(i, j);
    if constexpr (kCompensated<R>)
      return apart + low.difference(i, j);
    else
      return apart;
  }
  KERNEL Vector3<R> difference(int i, int j) const { return start_difference(i, j) + d.difference(i, j); }
  /// x + d without `low`, which cached contacts do not have either.
  KERNEL Vector3<double> position_without_low(int i) const { return in_double(x[i]) + in_double(d[i]); }
  /// The start of the substep, and the position, with all digits that are stored.
  KERNEL Vector3<double> exact_start(int i) const {
    if constexpr (kCompensated<R>)
      return in_double(x[i]) + in_double(low[i]);
    else
      return in_double(x[i]);
  }
  KERNEL Vector3<double> exact_position(int i) const { return exact_start(i) + in_double(d[i]); }
  KERNEL void add_displacement(int i, const Vector3<R>& more) const { d.set(i, d[i] + more); }
  /// Starts the substep at `position`, without displacement.
  KERNEL void set_start(int i, const Vector3<double>& position) const {
    const Vector3<R> near = rounded<R>(position);
    x.set(i, near), clear_displacement(i);
    if constexpr (kCompensated<R>) low.set(i, rounded<R>(position - in_double(near)));
  }
  KERNEL void clear_displacement(int i) const { d.set(i, {R(0), R(0), R(0)}); }
  /// Moves x to the position. d stays as it is.
  KERNEL void advance_x(int i) const {
    const Vector3<R> before = x[i], offset = with_low(i, d[i]), p = before + offset;
    x.set(i, p);
    if constexpr (kCompensated<R>) low.set(i, rounding_error(before, offset, p));
  }

 private:
  KERNEL Vector3<R> with_low(int i, const Vector3<R>& displacement) const {
    if constexpr (kCompensated<R>)
      return displacement + low[i];
    else
      return displacement;
  }
};

/// Positions relative to an origin.
template <class R>
struct FromOrigin {
  Displaced<R> p;
  Vector3<R> origin;  // m
  KERNEL Vector3<R> operator[](int i) const { return p.relative_to(i, origin); }
};

/// Positions at the start of the substep, of which only differences are needed.
template <class R>
struct StartPositions {
  Displaced<R> p;
  KERNEL Vector3<R> difference(int i, int j) const { return p.start_difference(i, j); }
};

template <class R>
struct Particles {
  int count;
  Points<R> x;                  // position at the start of the substep, m
  Points<R> v;                  // velocity, m/s
  Displaced<R> p;               // current position, m
  const R* w;                   // 1 / m, 1/kg, 0 where pinned
  const R* friction = nullptr;  // factor of Coulomb's mu; null: 1 for all

  /// Calls f.operator()<mapped>(), which launches kernels for particles with or without such factors.
  template <class F>
  void by_friction(const F& f) const {
    friction != nullptr ? f.template operator()<true>() : f.template operator()<false>();
  }
};

/// Loads and stores the points i, i + 1, ... of a pack, or the point i of a scalar.
template <class T, class R>
KERNEL Vector3<T> load_points(const Points<R>& points, int i) {
  Vector3<T> a;
  load(points.x + i, a.x), load(points.y + i, a.y), load(points.z + i, a.z);
  return a;
}
/// Coulomb's mu of particle i, or of a pack from it on: that of the other surface times the factors of mapped
/// particles.
template <bool mapped, class T, class R>
KERNEL T friction_of(const R* factor, int i, R mu) {
  if constexpr (!mapped) {
    return T(mu);
  } else {
    T own;
    load(factor + i, own);
    return T(mu) * own;
  }
}
/// Positions at the start of the substep, relative to an origin near them.
template <class T, class R>
KERNEL Vector3<T> load_start(const Displaced<R>& points, int i, const Vector3<R>& origin, T) {
  const Vector3<T> x = load_points<T>(points.x, i) - Vector3<T>{T(origin.x), T(origin.y), T(origin.z)};
  if constexpr (kCompensated<R>)
    return x + load_points<T>(points.low, i);
  else
    return x;
}
/// Current positions.
template <class T, class R>
KERNEL Vector3<T> load_points(const Displaced<R>& points, int i) {
  Vector3<T> offset = load_points<T>(points.d, i);
  if constexpr (kCompensated<R>) offset = offset + load_points<T>(points.low, i);
  return load_points<T>(points.x, i) + offset;
}
template <class T, class R>
KERNEL void store_points(const Points<R>& points, int i, const Vector3<T>& a) {
  store(a.x, points.x + i), store(a.y, points.y + i), store(a.z, points.z + i);
}
template <class T, class R>
KERNEL void add_points(const Points<R>& points, int i, const Vector3<T>& more) {
  store_points(points, i, load_points<T>(points, i) + more);
}
template <class R>
KERNEL void add_points(const Points<R>& points, int i, const Vec4<R>& more) {
  add_points(points, i, more.xyz());
}

}  // namespace malha
