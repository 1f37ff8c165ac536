// SPDX-License-Identifier: Apache-2.0
// Whether particles can move for a whole step without a look at an environment mesh: how far they are from it, at
// least, and how fast. What then turns out to be faster is held back afterwards.
#pragma once
#include "kernels/environment/broad_phase.h"
#include "kernels/simd/for_each_pack.h"

namespace malha {

/// Of a word of particles.
struct Clearance {
  float distance;  // m, that none of them is nearer to any mesh than its contacts reach
  float speed2;    // the highest, squared, m^2/s^2
};

/// Of all of them.
struct MinClearance {
  float distance = INFINITY, speed2 = 0;
  KERNEL MinClearance& operator+=(const MinClearance& other) {
    distance = other.distance < distance ? other.distance : distance;
    speed2 = speed2 < other.speed2 ? other.speed2 : speed2;
    return *this;
  }
};
struct SumRooms {
  const Clearance* rooms;
  KERNEL MinClearance operator()(int word) const { return {rooms[word].distance, rooms[word].speed2}; }
};

/// Room to one mesh, which does not move; with what there is of others. Pinned particles need none.
template <class R>
struct MeasureRoom {
  Points<R> x, v;
  const R* w;
  int count;
  ContactCacheView<R> nearby;
  float reach;     // of contacts, m
  float rounding;  // of sizes: what places may be off by
  bool first;      // of the meshes
  Clearance* rooms;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using Isa = typename Group::Isa;
    constexpr int lanes = kLanes<float, Isa>;
    Clearance& room = rooms[group.index];
    PackMax<float, Isa> missing(first ? -INFINITY : -room.distance), speed2(first ? 0 : room.speed2);
    const auto add_all = [&](const auto& places) KERNEL_LAMBDA {
      const int begin = group.index * kGroupSize, n = count - begin < kGroupSize ? count - begin : kGroupSize;
      int k = 0;
      for (; k + lanes <= n; k += lanes) add<Lane<float, Isa>>(places, begin, k, missing, speed2);
      for (; k < n; ++k) add<float>(places, begin, k, missing, speed2);
    };
    const WordPlaces* const places = nearby.places_of(group.index);
    places ? add_all(EachPlace{places}) : add_all(BoxPlace(nearby.boxes[group.index]));
    room = {-missing.value(), speed2.value()};
  }

 private:
  template <class S, class Places, class Most>
  KERNEL void add(const Places& places, int begin, int k, Most& missing, Most& speed2) const {
    const int i = begin + k;
    const Vector3<S> place = load_floats<S>(x, i), speed = load_floats<S>(v, i);
    const SeenLanes<S> seen = places.from(k, place);
    const Vector3<S> moved = place - seen.at;
    S mass;
    load_float(w + i, mass);
    const S slack = (sum_of_sizes(place) + abs(seen.distance)) * S(rounding);
    const S room = seen.distance - sqrt(dot(moved, moved)) - S(reach) - slack;
    const auto moves = mass > S(0.0f);
    const S less = select(room < S(INFINITY), S(0.0f) - room, S(INFINITY));  // not a number: no room
    missing.add(select(moves, less, S(-INFINITY)));
    speed2.add(select(moves, dot(speed, speed), S(0.0f)));
  }
};

/// Where particles were a substep ago (to the rounding of x), and p where they are.
template <class R>
struct ReconstructPrevious {
  Particles<R> particles;
  Points<R> before;
  R dt;
  KERNEL void operator()(int i) const {
    const Vector3<R> x = particles.x[i];
    particles.p.clear_displacement(i);
    before.set(i, x - particles.v[i] * dt);
  }
};

/// The state of those that were held back after their substep: x = p, and v for it.
template <class R>
struct KeepHeld {
  Particles<R> particles;
  R per_dt;
  KERNEL void operator()(int i) const {
    const Vector3<R> held = particles.p.d[i];
    if (held.x == R(0) && held.y == R(0) && held.z == R(0)) return;
    particles.v.set(i, particles.v[i] + held * per_dt);
    particles.p.advance_x(i), particles.p.clear_displacement(i);
  }
};

}  // namespace malha
