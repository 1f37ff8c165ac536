// SPDX-License-Identifier: Apache-2.0
// Contacts of particles with exact shapes of the environment, a pack of particles at a time: detection, projection with
// friction, and restitution, by the same rules as contacts with meshes (contact.h). Particles are taken in groups; a
// group has a block of contacts for every shape that it may touch in the substep, and one that is far from all shapes
// costs the bounds of its particles alone.
#pragma once
#include "kernels/environment/contact.h"
#include "kernels/environment/proximity_cache.h"
#include "kernels/environment/shapes.h"
#include "kernels/simd/for_each_pack.h"

namespace malha {

/// Contacts of the particles of a group with one shape, as in Contact, by lane. A lane without contact has c = minus
/// infinity and lambda = 0; the rest of it is undefined.
template <class R>
struct alignas(64) ShapeContacts {
  R nx[kGroupSize], ny[kGroupSize], nz[kGroupSize], c[kGroupSize];
  R lambda[kGroupSize], approach[kGroupSize];
  R lift[kGroupSize];  // m, part of the push that moves a particle out to its distance, without giving it velocity
  R fx[kGroupSize], fy[kGroupSize], fz[kGroupSize];  // displacement by friction, m
  R sx[kGroupSize], sy[kGroupSize], sz[kGroupSize];  // motion of the surface, m; undefined if the shape rests
  int shape;

  KERNEL Points<R> normals() { return {nx, ny, nz}; }
  KERNEL Points<R> friction() { return {fx, fy, fz}; }
  KERNEL Points<R> surface() { return {sx, sy, sz}; }
};

/// Overlaps of particles and shapes: the distances by which particles may stay nearer than the thickness, because they
/// were at the start. Only groups that have any have a block for a shape.
template <class R>
struct Overlaps {
  const int* block = nullptr;  // of group g and shape k at g * shapes + k; -1: none; null: no group has any
  R* of = nullptr;             // kGroupSize in each block, m
  KERNEL R* find(int group, int shapes, int shape) const {
    const int found = block == nullptr ? -1 : block[group * shapes + shape];
    return found < 0 ? nullptr : of + found * kGroupSize;
  }
};

/// The particles and shapes of a substep, and the contacts between them.
template <class R>
struct ShapeView {
  Particles<R> particles;
  const MovingShape* shapes;
  int count;  // of shapes
  Overlaps<R> kept;
  ShapeContacts<R>* pool;          // blocks of contacts
  int *first_block, *block_count;  // of each group
  int *used, capacity;             // number of blocks

  KERNEL int group_count(int group) const {
    const int left = particles.count - group * kGroupSize;
    return left < kGroupSize ? left : kGroupSize;
  }
  /// Calls work(shape, contacts, lane, i, T()) for packs of the particles i of a group, in each of its blocks.
  template <class Group, class Work>
  KERNEL void for_each_contact_pack(const Group& group, const Work& work) const {
    const int begin = group.index * kGroupSize, first = first_block[group.index];
    for (int b = 0; b < block_count[group.index]; ++b) {
      ShapeContacts<R>& contacts = pool[first + b];
      const MovingShape& shape = shapes[contacts.shape];
      for_each_pack_once<R>(group, group_count(group.index),
                            [&](int lane, auto t) KERNEL_LAMBDA { work(shape, contacts, lane, begin + lane, t); });
    }
  }
  /// Start and end of a particle's path, or of those of a pack, in double.
  template <class S>
  KERNEL Vector3<S> start(int i, S) const {
    const Vector3<S> x = load_points<S>(particles.x, i);
    if constexpr (kCompensated<R>)
      return x + load_points<S>(particles.p.low, i);
    else
      return x;
  }
  template <class S>
  KERNEL Vector3<S> displacement(int i, S) const {
    return load_points<S>(particles.p.d, i);
  }
  template <class S>
  KERNEL auto can_move(int i, S) const {
    S w;
    load(particles.w + i, w);
    return w > S(0.0);
  }
};

/// The bounds of a group, with one number beside them for each particle, `measure(i, T())`, of which it has the
/// largest.
template <class R, class Group, class Measure>
KERNEL GroupReach bounds_of(const Group& group, const ShapeView<R>& view, const Measure& measure) {
  using Isa = typename Group::Isa;
  constexpr int kNumbers = 8;  // x, y, z, -x, -y, -z, the measure, the low parts
  struct Most {
    double of[kNumbers];
  };
  const int first = group.index * kGroupSize, n = view.group_count(group.index);
  const auto numbers = [&](int i, auto t, auto* to) KERNEL_LAMBDA {
    using S = decltype(t);
    const Vector3<S> x = load_points<S>(view.particles.x, i);
    S w;
    load(view.particles.w + i, w);
    const auto moves = w > S(R(0));
    const S all[] = {x.x, x.y, x.z, -x.x, -x.y, -x.z, measure(i, t)};
    for (int k = 0; k + 1 < kNumbers; ++k) to[k] = select(moves, all[k], S(-R(INFINITY)));
  };
  Most most;
  if constexpr (kLanes<R, Isa> == 1) {
    Most none;
    for (double& of : none.of) of = -INFINITY;
    most = group.reduce(
        n, none,
        [&](int k) KERNEL_LAMBDA {
          R to[kNumbers];
          numbers(first + k, R(), to);
          Most one;
          for (int j = 0; j + 1 < kNumbers; ++j) one.of[j] = double(to[j]);
          return one;
        },
        [](Most& to, const Most& one) KERNEL_LAMBDA {
          for (int j = 0; j + 1 < kNumbers; ++j) to.of[j] = max(to.of[j], one.of[j]);
        });
  } else {
    using S = Lane<R, Isa>;
    constexpr int lanes = kLanes<R, Isa>;
    S packs[kNumbers - 1];
    R singles[kNumbers - 1];
    for (int k = 0; k + 1 < kNumbers; ++k) packs[k] = S(-R(INFINITY)), singles[k] = -R(INFINITY);
    int k = 0;
    for (; k + lanes <= n; k += lanes) {
      S to[kNumbers - 1];
      numbers(first + k, S(), to);
      for (int j = 0; j + 1 < kNumbers; ++j) packs[j] = max(packs[j], to[j]);
    }
    for (; k < n; ++k) {
      R to[kNumbers - 1];
      numbers(first + k, R(), to);
      for (int j = 0; j + 1 < kNumbers; ++j) singles[j] = max(singles[j], to[j]);
    }
    for (int j = 0; j + 1 < kNumbers; ++j) {
      for (int l = 0; l < lanes; ++l) singles[j] = max(singles[j], lane(packs[j], l));
      most.of[j] = double(singles[j]);
    }
  }
  const double* const of = most.of;
  if (!(of[6] > -INFINITY)) return {{0, 0, 0}, {0, 0, 0}, 0, true};
  // The low parts, at most half a unit in the last place, are not read.
  const double rounding = kCompensated<R> ? 1.2e-7 : 2.3e-16;
  GroupReach reach{{0.5 * (of[0] - of[3]), 0.5 * (of[1] - of[4]), 0.5 * (of[2] - of[5])},
                   {0.5 * (of[0] + of[3]), 0.5 * (of[1] + of[4]), 0.5 * (of[2] + of[5])},
                   of[6],
                   false};
  const auto pad = [&](int k) KERNEL_LAMBDA { return rounding * max(abs(of[k]), abs(of[3 + k])); };
  reach.half = reach.half + Vector3<double>{pad(0), pad(1), pad(2)};
  return reach;
}

/// The bounds of a group at the start of a substep, and of its paths. (A displacement as long as its largest coordinate
/// times 3 is not longer.)
template <class R, class Group>
KERNEL GroupReach reach_of(const Group& group, const ShapeView<R>& view) {
  GroupReach reach = bounds_of(group, view, [&](int i, auto t) KERNEL_LAMBDA {
    const auto d = load_points<decltype(t)>(view.particles.p.d, i);
    return dot(d, d);
  });
  reach.path = sqrt(reach.path) * (1 + 1e-6);
  return reach;
}

/// Detects the contacts of a group. What it needs beyond the capacity is only counted, and then the detection has to
/// run again. Overlaps become smaller where particles have moved away.
template <class R>
struct DetectShapeContacts : ShapeView<R> {
  using Shared = void;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int g = group.index;
    const GroupReach reach = reach_of(group, static_cast<const ShapeView<R>&>(*this));
    int near = 0;
    for (int k = 0; k < this->count; ++k) near += reach.may_come_near(this->shapes[k], contact_range(k));
    group.for_each(1, [&](int) KERNEL_LAMBDA {
      this->first_block[g] = near == 0 ? 0 : atomic_add(this->used, near);
      this->block_count[g] = near;
    });
    const int begin = this->first_block[g];
    if (begin + near > this->capacity || (near == 0 && this->kept.block == nullptr)) return;
    int block = begin;
    for (int k = 0; k < this->count; ++k) {
      R* const overlap = this->kept.find(g, this->count, k);
      if (near > 0 && reach.may_come_near(this->shapes[k], contact_range(k)))
        detect(group, k, this->pool[block++], overlap);
      else if (overlap != nullptr)
        group.for_each(kGroupSize, [&](int lane) KERNEL_LAMBDA { overlap[lane] = R(0); });
    }
  }

 private:
  KERNEL double contact_range(int k) const { return 2 * this->shapes[k].thickness; }

  template <class Group>
  KERNEL void detect(const Group& group, int k, ShapeContacts<R>& to, R* overlap) const {
    const int begin = group.index * kGroupSize;
    group.for_each(1, [&](int) KERNEL_LAMBDA { to.shape = k; });
    for_each_pack_once<double>(group, this->group_count(group.index), [&](int lane, auto t) KERNEL_LAMBDA {
      detect_lanes(this->shapes[k], to, lane, begin + lane, overlap, t);
    });
  }

  template <class S>
  KERNEL void detect_lanes(const MovingShape& moving, ShapeContacts<R>& to, int lane, int i, R* overlap, S t) const {
    const S zero(0.0);
    const Vector3<S> x = this->start(i, t), d = this->displacement(i, t);
    const Vector3<S> a = to_local(moving.before, x), way = to_local(moving.after, x + d) - a;
    const S thickness(moving.thickness), path = sqrt(dot(way, way));
    const SurfaceDistance<S> start = distance_to(moving.shape, a);
    const auto in_range = (start.distance <= path + thickness + thickness) & this->can_move(i, t);
    store(zero, to.lambda + lane);
    S required = thickness;
    if (overlap != nullptr) {
      S within;
      load(overlap + lane, within);
      within = min(within, max(thickness - start.distance, zero));
      store(within, overlap + lane);
      required = thickness - within;
    }
    if (movemask(in_range) == 0) return store(S(-INFINITY), to.c + lane);
    store_points(to.friction(), lane, Vector3<S>{zero, zero, zero});

    const PathPoint<S> end = advance_to(moving.shape, a, way, start, required, kArrives * moving.thickness);
    const Vector3<S> q = a + way * end.t - end.at.normal * end.at.distance,
                     normal = rotate(moving.after, end.at.normal);
    const Vector3<S> rounded_x = load_points<S>(this->particles.x, i);
    const S c = dot(normal, to_world(moving.after, q) - rounded_x) + required;
    S approach = dot(normal, d);
    if (!moving.rests) {
      // A particle that rests on q is this much above it, where a rotating shape moves faster than at q.
      const Vector3<S> rest = q + end.at.normal * required,
                       surface = to_world(moving.after, rest) - to_world(moving.before, rest);
      store_points(to.surface(), lane, or_zero(in_range, surface));
      approach = approach - dot(normal, surface);
    }
    const S lift = required - start.distance;
    store_points(to.normals(), lane, or_zero(in_range, normal));
    store(select(in_range, c, S(-INFINITY)), to.c + lane);
    store(select(in_range, approach, zero), to.approach + lane);
    store(select(in_range & (lift > S(kNoLift * moving.thickness)), lift, zero), to.lift + lane);
  }

  static constexpr double kArrives = 1e-9, kNoLift = 1e-6;  // of the thickness
};

/// Projects the contacts of a group, shape by shape, as ResolveContact does.
template <class R, bool mapped = false>
struct SolveShapeContacts : ShapeView<R> {
  using Shared = void;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    this->for_each_contact_pack(group, [this](const MovingShape& shape, ShapeContacts<R>& contacts, int lane, int i,
                                              auto t) KERNEL_LAMBDA { this->solve(shape, contacts, lane, i, t); });
  }

 private:
  template <class S>
  KERNEL void solve(const MovingShape& shape, ShapeContacts<R>& contacts, int lane, int i, S) const {
    const S zero(R(0)), one(R(1));
    S c, lambda;
    load(contacts.c + lane, c);
    const auto active = c > S(-R(INFINITY));
    if (movemask(active) == 0) return;
    load(contacts.lambda + lane, lambda);
    const Vector3<S> n = or_zero(active, load_points<S>(contacts.normals(), lane));
    Vector3<S> moved = load_points<S>(this->particles.p.d, i), offset = moved;
    if constexpr (kCompensated<R>) offset = offset + load_points<S>(this->particles.p.low, i);
    const S C = dot(n, offset) - c, push = max(-C, -lambda);
    const auto pushed = lambda > zero;
    lambda = lambda + push;
    store(lambda, contacts.lambda + lane);
    moved = moved + n * push;
    // A contact that pushes no longer takes its friction back.
    if (const auto rubs = pushed | (lambda > zero); shape.friction > 0 && movemask(rubs) != 0) {
      S lift;
      load(contacts.lift + lane, lift);
      Vector3<S> slide = moved;
      if (!shape.rests) slide = slide - or_zero(active, load_points<S>(contacts.surface(), lane));
      const Vector3<S> before = or_zero(active, load_points<S>(contacts.friction(), lane)),
                       tangent = slide - n * dot(n, slide);
      Vector3<S> friction = before + tangent;
      const S length = sqrt(dot(friction, friction)),
              most = friction_of<mapped, S>(this->particles.friction, i, R(shape.friction)) *
                     select(active, max(lambda - lift, zero), zero);
      const auto slips = length > most;
      friction = friction * select(slips, most / select(slips, length, one), one);
      store_points(contacts.friction(), lane, friction);
      moved = moved - or_zero(rubs, friction - before);
    }
    store_points(this->particles.p.d, i, moved);
  }
};

/// Restitution of a group, as ApplyRestitution does. And the lift of a contact, which moved its particle out to the
/// distance that it keeps, is taken from its velocity: it is no motion (the pre-stabilisation of Macklin et al. 2014,
/// section 4.4, where guards still act on it).
template <class R, bool mapped = false>
struct RestituteShapeContacts : ShapeView<R> {
  using Shared = void;
  R threshold, per_dt;  // m/s, 1/s

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    this->for_each_contact_pack(group, [this](const MovingShape& shape, ShapeContacts<R>& contacts, int lane, int i,
                                              auto t) KERNEL_LAMBDA { this->restitute(shape, contacts, lane, i, t); });
  }

 private:
  template <class S>
  KERNEL void restitute(const MovingShape& shape, ShapeContacts<R>& contacts, int lane, int i, S) const {
    const S zero(R(0)), one(R(1)), rate(per_dt), e(R(shape.restitution));
    S lambda, c;
    load(contacts.lambda + lane, lambda), load(contacts.c + lane, c);
    const auto pushes = (lambda > zero) & (c > S(-R(INFINITY)));
    if (movemask(pushes) == 0) return;
    S approach, lift;
    load(contacts.approach + lane, approach), load(contacts.lift + lane, lift);
    const auto hits = pushes & (approach * rate < S(-threshold)), lifted = pushes & (lift > zero);
    if (movemask(hits | lifted) == 0) return;
    const Vector3<S> n = or_zero(pushes, load_points<S>(contacts.normals(), lane)),
                     v = load_points<S>(this->particles.v, i);
    Vector3<S> relative = v;
    if (!shape.rests) relative = relative - or_zero(pushes, load_points<S>(contacts.surface(), lane)) * rate;
    const S speed = dot(n, relative), lift_speed = select(lifted, min(max(speed, zero), lift * rate), zero);
    const S leaves = speed - lift_speed, wanted = -e * approach * rate;
    const auto bounces = hits & (wanted > leaves);
    const S gained = select(bounces, wanted - leaves, zero);
    const Vector3<S> sliding = relative - n * speed;
    const S length = sqrt(dot(sliding, sliding)),
            most = friction_of<mapped, S>(this->particles.friction, i, R(shape.friction)) * gained;
    const S fraction = select(length > zero, min(length, most) / select(length > zero, length, one), zero);
    store_points(this->particles.v, i, v + n * (gained - lift_speed) - sliding * fraction);
    if (!(shape.restitution > 0)) return;
    const S path_left = select(bounces, max(min(lambda - lift, -approach), zero), zero);
    add_points(this->particles.p.d, i, n * (e * path_left));
  }
};

/// Counts the contacts of a group that pushed in the last substep.
template <class R>
struct CountShapeContacts {
  const ShapeContacts<R>* contacts;
  const int *first, *blocks;
  int particles;
  KERNEL Sum operator()(int g) const {
    Sum sum;
    const int left = particles - g * kGroupSize, n = left < kGroupSize ? left : kGroupSize;
    for (int b = 0; b < blocks[g]; ++b)
      for (int lane = 0; lane < n; ++lane) sum.value += contacts[first[g] + b].lambda[lane] > R(0) ? 1 : 0;
    return sum;
  }
};

/// Finds the overlaps of a group with every shape: a flag for each pair of them, or the values where they have blocks.
/// Up to `most` thicknesses are kept; where `throws_out_deep`, what is deeper inside is moved out instead.
template <class R>
struct FindOverlaps : ShapeView<R> {
  int* flags;  // null: the values are stored
  double most;
  bool throws_out_deep;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    const int g = group.index, begin = g * kGroupSize;
    for (int k = 0; k < this->count; ++k) {
      const MovingShape& moving = this->shapes[k];
      R* const to = flags != nullptr ? nullptr : this->kept.find(g, this->count, k);
      if (flags == nullptr && to == nullptr) continue;
      int any = 0;
      for (int lane = 0; lane < kGroupSize; ++lane) {
        const double overlap = lane < this->group_count(g) ? overlap_of(moving, begin + lane) : 0;
        any |= overlap > 0;
        if (to != nullptr) to[lane] = R(overlap);
      }
      if (flags != nullptr) flags[g * this->count + k] = any;
    }
  }

 private:
  KERNEL double overlap_of(const MovingShape& moving, int i) const {
    constexpr double kMinDistance = 0.02;  // as ContactQuery has
    const Vector3<double> a = to_local(moving.before, this->start(i, double()));
    const double overlap = moving.thickness - distance_to(moving.shape, a).distance;
    if (!(overlap > 0)) return 0;
    if (throws_out_deep && overlap > most * moving.thickness) return (1 - kMinDistance) * moving.thickness;
    return min(overlap, most * moving.thickness);
  }
};

}  // namespace malha
