// SPDX-License-Identifier: Apache-2.0
// What is remembered of particles near an environment mesh from substep to substep: a box for every 64 particles,
// where each was seen for those of which no box tells it, and a slot with the rest and its contact for those that are
// near.
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/environment/contact.h"
#include "kernels/simd/pack.h"

namespace malha {

/// Returns what the number was.
KERNEL int atomic_increment(int* number) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(number, 1);
#else
  return __atomic_fetch_add(number, 1, __ATOMIC_RELAXED);
#endif
}

inline constexpr int kGroupSize = 64;  // particles: a bit each

/// Where a particle was last seen (m, mesh's frame), and how near nothing is.
struct PlaceSeen {
  float x, y, z, distance;
};

/// The place of the box from low to high that is nearest to a.
template <class S>
KERNEL Vector3<S> nearest_in(const Vector3<float>& low, const Vector3<float>& high, const Vector3<S>& a) {
  return {max(S(low.x), min(a.x, S(high.x))), max(S(low.y), min(a.y, S(high.y))), max(S(low.z), min(a.z, S(high.z)))};
}

/// A box in which all particles of a word were when they were last seen (m, mesh's frame), for a first test of them
/// all. Unless each particle has a place of its own, it counts as seen at the place of the box that is nearest to it.
struct WordBox {
  Vector3<float> centre, half;
  /// To no place of the box anything is nearer. Below 0: the same of its size, but particles have left it by more than
  /// that tells. 0: no particle was ever seen. kOfEach: each particle has a place of its own.
  float distance;

  static constexpr float kOfEach = -INFINITY;
  /// Whether a test of the whole word may tell that nothing is near.
  KERNEL bool keeps_all() const { return distance > 0; }
  KERNEL bool is_of_each() const { return distance == kOfEach; }
  KERNEL float clearance() const { return distance == 0 ? -INFINITY : fabsf(distance); }
  KERNEL PlaceSeen place(const Vector3<float>& a) const {
    if (distance == 0 || is_of_each()) return {0, 0, 0, -INFINITY};
    const Vector3<float> nearest = nearest_in(centre - half, centre + half, a);
    return {nearest.x, nearest.y, nearest.z, clearance()};
  }
  /// The way from the box to a.
  template <class S>
  KERNEL Vector3<S> way_to(const Vector3<S>& a) const {
    const Vector3<S> d = a - Vector3<S>{S(centre.x), S(centre.y), S(centre.z)};
    return {max(abs(d.x) - S(half.x), S(0.0f)), max(abs(d.y) - S(half.y), S(0.0f)), max(abs(d.z) - S(half.z), S(0.0f))};
  }
  KERNEL void leave() { distance = distance < 1e38f ? -distance : -1e38f; }
  /// Each particle gets a place of its own; then the size tells whether any was seen since a box was last tried.
  KERNEL void leave_to_each() { distance = kOfEach, half.x = 1; }
  KERNEL bool is_to_try() const { return is_of_each() && half.x != 0; }
  KERNEL void note_try() { half.x = 0; }
};

/// Where each particle of a word was last seen, and its slot: of words that no box tells of.
struct WordPlaces {
  float x[kGroupSize], y[kGroupSize], z[kGroupSize], distance[kGroupSize];  // as in PlaceSeen
  int slot[kGroupSize];                                                     // none: -1
  int word;  // whose places these are; none: -1, and they are free

  KERNEL PlaceSeen of(int k) const { return {x[k], y[k], z[k], distance[k]}; }
  KERNEL void set(int k, const PlaceSeen& to) { x[k] = to.x, y[k] = to.y, z[k] = to.z, distance[k] = to.distance; }
  KERNEL bool has_slots(int n) const {
    bool any = false;
    for (int k = 0; k < n; ++k) any = any || slot[k] >= 0;
    return any;
  }
};

/// The middle of n places, for a word that is farther off than it is large: without it the distance is 0.
KERNEL WordBox middle_of(const WordPlaces& places, int n) {
  const auto middle = [&](const float* a) KERNEL_LAMBDA {
    float least = a[0], most = least;
    for (int k = 1; k < n; ++k) least = a[k] < least ? a[k] : least, most = a[k] > most ? a[k] : most;
    return (least + most) / 2;
  };
  const Vector3<float> c{middle(places.x), middle(places.y), middle(places.z)};
  float most = 0, nearest = places.distance[0];
  for (int k = 0; k < n; ++k) {
    const Vector3<float> d{places.x[k] - c.x, places.y[k] - c.y, places.z[k] - c.z};
    most = max(most, dot(d, d)), nearest = places.distance[k] < nearest ? places.distance[k] : nearest;
  }
  const float radius = 1.00001f * sqrt(most);
  return {c, {0, 0, 0}, nearest > 4 * radius ? 0.99999f * (nearest - radius) : 0};
}

/// Where a particle is in a mesh's frame, as places are kept.
template <class R>
KERNEL Vector3<float> place_in(const Pose& mesh, const Vector3<R>& x) {
  return rounded<float>(to_local(mesh, in_double(x)));
}

/// How many pieces of memory were handed out from the first on, and how many of them are free again.
struct Handed {
  int used = 0, freed = 0;
  KERNEL Handed& operator+=(const Handed& o) {
    used += o.used, freed += o.freed;
    return *this;
  }
};

/// Of one mesh. There is memory for the places and the slot of every particle that is looked at.
template <class R>
struct ContactCacheView {
  WordBox* boxes;
  int* which;             // of each word, the place of its entry in `places`; none: -1
  WordPlaces* places;     // of the words whose boxes are of each
  Contact<R>* contacts;   // of each slot
  ProximityRecord* near;  // the same
  Handed *slots, *words;  // of contacts and near, and of places

  KERNEL const WordPlaces* places_of(int word) const { return which[word] < 0 ? nullptr : places + which[word]; }
  KERNEL int slot(int i) const {
    const WordPlaces* const of = places_of(i / kGroupSize);
    return of ? of->slot[i % kGroupSize] : -1;
  }
  /// Of a particle that is at a, in the mesh's frame.
  KERNEL PlaceSeen place(int i, const Vector3<float>& a) const {
    const WordPlaces* const of = places_of(i / kGroupSize);
    return of ? of->of(i % kGroupSize) : boxes[i / kGroupSize].place(a);
  }
  KERNEL ClosestPointRecord seen(int i, const Vector3<double>& a) const {
    if (const int s = slot(i); s >= 0) return near[s].seen;
    const PlaceSeen last = place(i, rounded<float>(a));
    return {{double(last.x), double(last.y), double(last.z)}, double(last.distance), -1, {0, 0, 0}};
  }
  /// As in ClosestPointRecord.
  KERNEL double overlap(int i) const {
    const int s = slot(i);
    return s < 0 ? 0 : near[s].seen.overlap;
  }

  /// Gives each particle of a word a place of its own, as see() needs it. No other thread does the same.
  KERNEL void give_places(int word, const Particles<R>& particles, const Pose& mesh) const {
    if (which[word] >= 0) return;
    const int to = atomic_increment(&words->used), first = word * kGroupSize;
    WordPlaces& own = places[to];
    for (int k = 0; k < kGroupSize; ++k) {
      own.slot[k] = -1;
      own.set(k, first + k < particles.count ? boxes[word].place(place_in(mesh, particles.x[first + k]))
                                             : PlaceSeen{0, 0, 0, -INFINITY});
    }
    own.word = word, which[word] = to;
    boxes[word].leave_to_each();
  }
  /// A box tells of a word's particles from here on. None of them has a slot.
  KERNEL void take_places(int word) const {
    places[which[word]].word = -1, which[word] = -1;
    atomic_increment(&words->freed);
  }

  KERNEL void see(int i, const ClosestPointRecord& last) const {
    const Vector3<float> rounded = in_float(last.at);
    WordPlaces& own = places[which[i / kGroupSize]];
    const int k = i % kGroupSize;
    own.set(k, {rounded.x, rounded.y, rounded.z, certain_distance(last)});
    boxes[i / kGroupSize].leave_to_each();
    int s = own.slot[k];
    if (!needs_slot(last)) {
      if (s < 0) return;
      contacts[s].particle = -1, own.slot[k] = -1;
      atomic_increment(&slots->freed);
      return;
    }
    if (s < 0) {
      s = own.slot[k] = atomic_increment(&slots->used);
      contacts[s].particle = i;
      clear_slot(contacts[s], near[s]);
    }
    near[s].seen = last;
  }
  /// A slot without a contact, of which nothing else is known.
  KERNEL static void clear_slot(Contact<R>& contact, ProximityRecord& near) {
    invalidate(contact);
    near.cell = 0, near.feature.radius = -1;
  }

  /// Whether there is more to remember than a place and a distance in float tell.
  KERNEL static bool needs_slot(const ClosestPointRecord& last) {
    const Vector3<double>& tunnel_offset = last.tunnel_offset;
    return last.triangle >= 0 || tunnel_offset.x != 0 || tunnel_offset.y != 0 || tunnel_offset.z != 0 ||
           !(certain_distance(last) > 0 || last.distance == -INFINITY);
  }

  KERNEL Contact<R>* contact(int i) const {
    const int s = slot(i);
    return s < 0 ? nullptr : contacts + s;
  }

 private:
  KERNEL static Vector3<float> in_float(const Vector3<double>& a) { return {float(a.x), float(a.y), float(a.z)}; }
  /// From the rounded place.
  KERNEL static float certain_distance(const ClosestPointRecord& last) {
    const Vector3<float> rounded = in_float(last.at);
    const Vector3<double> off{last.at.x - rounded.x, last.at.y - rounded.y, last.at.z - rounded.z};
    const double certain = last.distance - sqrt(dot(off, off));
    const float nearest = float(certain);
    const float below = nearest - 1.2e-7f * fabsf(nearest);
    return double(nearest) > certain ? below : nearest;
  }
};

/// Free slots are taken out, here or on the way to other memory. One item: each has the place that those before leave.
/// One thread of a device would take longer than the way to the host.
template <class R>
struct CompactSlots {
  using RunsOnHost = void;
  ContactCacheView<R> nearby;
  ProximityRecord* near_to;
  Contact<R>* contacts_to;
  KERNEL void operator()(int) const {
    int kept = 0;
    for (int s = 0; s < nearby.slots->used; ++s) {
      const int i = nearby.contacts[s].particle;
      if (i < 0) continue;
      near_to[kept] = nearby.near[s], contacts_to[kept] = nearby.contacts[s];
      nearby.places[nearby.which[i / kGroupSize]].slot[i % kGroupSize] = kept;
      ++kept;
    }
    *nearby.slots = {kept, 0};
  }
};
/// The same of places.
template <class R>
struct TakeOutFreePlaces {
  using RunsOnHost = void;
  ContactCacheView<R> nearby;
  WordPlaces* to;
  KERNEL void operator()(int) const {
    int kept = 0;
    for (int k = 0; k < nearby.words->used; ++k) {
      if (nearby.places[k].word < 0) continue;
      to[kept] = nearby.places[k];
      nearby.which[to[kept].word] = kept;
      ++kept;
    }
    *nearby.words = {kept, 0};
  }
};

/// Of a slot: what was known of its cell.
struct ForgetCells {
  ProximityRecord* near;
  KERNEL void operator()(int s) const { near[s].cell = 0; }
};

/// Invalidates contacts before detection, except resting ones: the same position and a displacement below `way` (m;
/// below 0: the mesh moves) give the same contact.
template <class R>
struct InvalidateContacts {
  Contact<R>* contacts;
  Displaced<R> p;
  double way;
  KERNEL void operator()(int s) const {
    Contact<R>& contact = contacts[s];
    const int i = contact.particle;
    if (i < 0 || way < 0 || !same(p.x[i], contact.cached_position)) return invalidate(contact);
    const Vector3<double> path = in_double(p.d[i]);
    if (!(dot(path, path) <= way * way)) return invalidate(contact);
    contact.lambda = R(0);
    contact.friction_impulse = {R(0), R(0), R(0)};
    contact.surface.w = R(dot(in_double(contact.plane.xyz()), path));
  }
};

}  // namespace malha
