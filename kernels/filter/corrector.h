// SPDX-License-Identifier: Apache-2.0
// Momentum correction of filtered accelerations: removes from those of a free body the rigid part, which internal
// forces cannot cause.
#pragma once
#include "kernels/forces/angular_velocity.h"
#include "kernels/simd/particles.h"

namespace malha {

/// A free body under the filter, none of whose particles is pinned.
template <class R>
struct FilteredBody {
  Points<R> x, a;  // at the start of the substep, m; m/s^2
  const R* w;
  const int* members;  // particles
};

/// Mass, and the mass-weighted sums of position and acceleration.
struct MassSum {
  double m = 0, x[3] = {}, a[3] = {};
  KERNEL MassSum& operator+=(const MassSum& o) {
    m += o.m;
    for (int k = 0; k < 3; ++k) x[k] += o.x[k], a[k] += o.a[k];
    return *this;
  }
};

template <class R>
struct SumMass {
  FilteredBody<R> body;
  KERNEL MassSum operator()(int item) const {
    const int i = body.members[item];
    const double m = 1.0 / body.w[i];
    const Vector3<R> x = body.x[i], a = body.a[i];
    return {m, {m * x.x, m * x.y, m * x.z}, {m * a.x, m * a.y, m * a.z}};
  }
};

/// State between the launches of a correction.
struct NetMotion {
  MassSum mass;
  SpinSum spin;                        // of the torque, about the centre
  Vector3<double> centre, mean, turn;  // m; m/s^2; angular acceleration to remove, 1/s^2, or as published torque, N m
};

/// Computes the mean acceleration. Launched with one item.
struct ComputeMeanMotion {
  NetMotion* net;
  KERNEL void operator()(int) const {
    const MassSum& sum = net->mass;
    const double per = 1 / sum.m;
    net->centre = {sum.x[0] * per, sum.x[1] * per, sum.x[2] * per};
    net->mean = {sum.a[0] * per, sum.a[1] * per, sum.a[2] * per};
    net->turn = {0, 0, 0};
  }
};

template <class R>
struct SumTorque {
  FilteredBody<R> body;
  const NetMotion* net;
  KERNEL SpinSum operator()(int item) const {
    const int i = body.members[item];
    const double m = 1.0 / body.w[i];
    const Vector3<R> x = body.x[i], a = body.a[i];
    const Vector3<double> r{x.x - net->centre.x, x.y - net->centre.y, x.z - net->centre.z};
    const Vector3<double> L = cross(r, Vector3<double>{a.x * m, a.y * m, a.z * m});
    SpinSum sum{{L.x, L.y, L.z}};
    add_inertia(sum.I, m, r);
    return sum;
  }
};

/// Computes the angular acceleration. Launched with one item.
struct ComputeAngularAcceleration {
  NetMotion* net;
  bool as_published;
  KERNEL void operator()(int) const {
    const double* L = net->spin.L;
    net->turn = as_published ? Vector3<double>{L[0], L[1], L[2]} : angular_velocity(net->spin);
  }
};

/// Stores the rotations of measured motions. One item per motion.
template <class R>
struct StoreRotation {
  const NetMotion* motions;
  Vec4<R>* rotations;
  KERNEL void operator()(int k) const { rotations[k].set(rounded<R>(motions[k].turn)); }
};

/// a -= mean + alpha x r, r from the centre of mass: no net force, and no torque where I alpha is the torque. The
/// published correction (Desbrun, Schröder, Barr 1999, section 3.3) is a += (x_G - x) x T / m instead. Its dimension is
/// not that of an acceleration, and it over-corrects; it is for comparison.
template <class R>
struct RemoveRigid {
  FilteredBody<R> body;
  const NetMotion* net;
  bool as_published;
  KERNEL void operator()(int item) const {
    const int i = body.members[item];
    const Vector3<R> r = body.x[i] - rounded<R>(net->centre), turn = rounded<R>(net->turn);
    const Vector3<R> turned = as_published ? cross(r, turn) * body.w[i] : cross(turn, r);
    body.a.set(i, body.a[i] - rounded<R>(net->mean) - turned);
  }
};

}  // namespace malha
