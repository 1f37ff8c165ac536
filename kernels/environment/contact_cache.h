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

/// A pose in float, for first tests.
struct FloatPose {
  float r[9], t[3];
  bool moves;
  FloatPose() = default;
  explicit FloatPose(const Pose& pose) : moves(pose.moves) {
    for (int k = 0; k < 9; ++k) r[k] = float(pose.r[k]);
    t[0] = float(pose.t.x), t[1] = float(pose.t.y), t[2] = float(pose.t.z);
  }
  KERNEL Vector3<float> to_world(const Vector3<float>& a) const {
    if (!moves) return a;
    return {r[0] * a.x + r[1] * a.y + r[2] * a.z + t[0], r[3] * a.x + r[4] * a.y + r[5] * a.z + t[1],
            r[6] * a.x + r[7] * a.y + r[8] * a.z + t[2]};
  }
  template <class S>
  KERNEL Vector3<S> to_local(const Vector3<S>& x) const {
    if (!moves) return x;
    const S a = x.x - S(t[0]), b = x.y - S(t[1]), c = x.z - S(t[2]);
    return {S(r[0]) * a + S(r[3]) * b + S(r[6]) * c, S(r[1]) * a + S(r[4]) * b + S(r[7]) * c,
            S(r[2]) * a + S(r[5]) * b + S(r[8]) * c};
  }
};

/// A number or a pack of them, rounded to float.
template <class S>
KERNEL void load_float(const float* from, S& to) {
  load(from, to);
}
template <class S>
KERNEL void load_float(const double* from, S& to) {
  constexpr int lanes = int(sizeof(S) / sizeof(float));
  float rounded[lanes];
  for (int l = 0; l < lanes; ++l) rounded[l] = float(from[l]);
  load(rounded, to);
}
template <class S, class Q>
KERNEL Vector3<S> load_floats(const Points<Q>& from, int i) {
  Vector3<S> a;
  load_float(from.x + i, a.x), load_float(from.y + i, a.y), load_float(from.z + i, a.z);
  return a;
}
template <class S, class Q>
KERNEL Vector3<S> load_floats(const Displaced<Q>& from, int i) {
  return load_floats<S>(from.x, i) + load_floats<S>(from.d, i);
}
template <class S>
KERNEL S sum_of_sizes(const Vector3<S>& a) {
  return abs(a.x) + abs(a.y) + abs(a.z);
}

/// The box around a mesh in its own frame, m, in float.
struct FloatBox {
  Vector3<float> centre, half;
};

/// A place, or one for each lane of a pack, and how near nothing is.
template <class S>
struct SeenLanes {
  Vector3<S> at;
  S distance;
};
/// Where the particles of a word that are at a were seen: each, or by their box.
struct EachPlace {
  const WordPlaces* places;
  template <class S>
  KERNEL SeenLanes<S> from(int k, const Vector3<S>&) const {
    SeenLanes<S> lanes;
    load(places->x + k, lanes.at.x), load(places->y + k, lanes.at.y), load(places->z + k, lanes.at.z);
    load(places->distance + k, lanes.distance);
    return lanes;
  }
};
struct BoxPlace {
  Vector3<float> low, high;
  float distance;
  KERNEL explicit BoxPlace(const WordBox& box)
      : low(box.centre - box.half), high(box.centre + box.half), distance(box.clearance()) {}
  template <class S>
  KERNEL SeenLanes<S> from(int, const Vector3<S>& a) const {
    return {nearest_in(low, high, a), S(distance)};
  }
};

/// Which particles may have come near enough to be looked at, a bit each: a stream in float, rounded so that none is
/// missed. `reach` < 0: those whose way from x to p may leave the ball around where they were last seen, in which there
/// is no surface; otherwise those whose way may reach the surface, or pass it by `reach` (m). Words that are far off as
/// a whole are told by their boxes, which from then on stand for where their particles were. What leaves its box or was
/// never seen, far from the mesh and without a pinned particle, gets a box around where it is now.
template <class R>
struct BroadPhaseTest {
  Particles<R> particles;
  ContactCacheView<R> nearby;
  FloatPose before, after;
  FloatBox mesh;
  float reach;
  bool add;  // to the bits that there are
  unsigned long long* bits;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<float, typename Group::Isa>;
    const int first = group.index * kGroupSize, left = particles.count - first,
              n = left < kGroupSize ? left : kGroupSize;
    const unsigned long long word = add ? bits[group.index] : 0;
    bits[group.index] = word;
    WordBox& seen = nearby.boxes[group.index];
    const WordPlaces* const places = nearby.places_of(group.index);
    if (seen.keeps_all()) {
      if (is_separated<S>(seen, first, n)) return;
      seen.leave();
      if (follows<S>(seen, first, n)) return;
    } else if (seen.distance == 0 && follows<S>(seen, first, n)) {
      return;
    }
    const unsigned long long touch =
        places ? touching<S>(EachPlace{places}, first, n) : touching<S>(BoxPlace(seen), first, n);
    if (touch == 0 && seen.is_to_try() && reach >= 0) {
      seen.note_try();
      if (!places->has_slots(n) && (follows<S>(seen, first, n) || stays(seen, *places, n)))
        nearby.take_places(group.index);
    }
    bits[group.index] = word | touch;
  }

 private:
  /// A bit for each number that is not below 0, or no number.
  KERNEL static unsigned long long not_below_zero(const float* a) {
    unsigned char flags[kGroupSize];
    for (int k = 0; k < kGroupSize; ++k) flags[k] = !(a[k] < 0);
    unsigned long long bits = 0;
    for (int k = 0; k < kGroupSize; k += 8) {
      unsigned long long eight;  // bytes, of which the product gathers the lowest bits in the highest byte
      __builtin_memcpy(&eight, flags + k, sizeof eight);
      bits |= (eight * 0x0102040810204080ull >> 56) << k;
    }
    return bits;
  }
  template <class S, class Places>
  KERNEL unsigned long long touching(const Places& places, int first, int n) const {
    constexpr int lanes = int(sizeof(S) / sizeof(float));
    float over[kGroupSize];
    int k = 0;
    for (; k + lanes <= n; k += lanes) store(excess<S>(places, first, k), over + k);
    for (; k < n; ++k) over[k] = excess<float>(places, first, k);
    for (; k < kGroupSize; ++k) over[k] = -1;
    return not_below_zero(over);
  }

  /// The box goes to where the word's particles are, if that is far enough from the mesh's.
  template <class S>
  KERNEL bool follows(WordBox& seen, int first, int n) const {
    for (int i = first; i < first + n; ++i)
      if (!(particles.w[i] > R(0))) return false;
    const auto place = [&](int i) KERNEL_LAMBDA { return before.to_local(load_floats<float>(particles.x, i)); };
    Vector3<float> low = place(first), high = low;
    for (int i = first + 1; i < first + n; ++i) {
      const Vector3<float> a = place(i);
      low = {min(low.x, a.x), min(low.y, a.y), min(low.z, a.z)};
      high = {max(high.x, a.x), max(high.y, a.y), max(high.z, a.z)};
    }
    const Vector3<float> c = (low + high) * 0.5f, half = high - c, to_mesh = c - mesh.centre;
    const Vector3<float> gap{max(0.0f, fabsf(to_mesh.x) - half.x - mesh.half.x),
                             max(0.0f, fabsf(to_mesh.y) - half.y - mesh.half.y),
                             max(0.0f, fabsf(to_mesh.z) - half.z - mesh.half.z)};
    const float sizes = sum_of_sizes(c) + sum_of_sizes(half) + sum_of_sizes(mesh.centre) + sum_of_sizes(mesh.half);
    const WordBox now{c, half, 0.99999f * sqrt(dot(gap, gap)) - 1e-5f * (sizes + shift())};
    if (!now.keeps_all() || !is_separated<S>(now, first, n)) return false;
    seen = now;
    return true;
  }
  /// The same of the middle of where they were seen.
  KERNEL bool stays(WordBox& seen, const WordPlaces& places, int n) const {
    const WordBox middle = middle_of(places, n);
    if (!middle.keeps_all()) return false;
    seen = middle;
    return true;
  }

  /// Whether no particle of the word can have come near: all are near a box to which nothing is near.
  template <class S>
  KERNEL bool is_separated(const WordBox& seen, int first, int n) const {
    constexpr int lanes = int(sizeof(S) / sizeof(float));
    Ways<S> of_lanes;
    Ways<float> all;
    int k = 0;
    for (; k + lanes <= n; k += lanes) add_way(of_lanes, seen, first + k);
    for (; k < n; ++k) add_way(all, seen, first + k);
    float off[lanes], way[lanes], sum[lanes];
    store(of_lanes.off, off), store(of_lanes.way, way), store(of_lanes.sum, sum);
    for (int l = 0; l < lanes; ++l) all.off = max(all.off, off[l]), all.way = max(all.way, way[l]), all.sum += sum[l];
    if (!(all.sum < INFINITY)) return false;
    const float beyond = sqrt(all.off), path = sqrt(all.way);
    const float slack = 1e-5f * (sum_of_sizes(seen.centre) + sum_of_sizes(seen.half) + beyond + path + shift());
    return (reach < 0 ? beyond : beyond + path + reach) + slack < seen.distance;
  }
  /// How far particles are off a box and how long their ways are at most, squared; the sum is not a number, or is not
  /// finite, where one of them is so.
  template <class S>
  struct Ways {
    S off = S(0.0f), way = S(0.0f), sum = S(0.0f);
  };
  template <class S>
  KERNEL void add_way(Ways<S>& ways, const WordBox& seen, int i) const {
    const Vector3<S> a = before.to_local(load_floats<S>(particles.x, i));
    const Vector3<S> b = after.to_local(load_floats<S>(particles.p, i)), way = b - a;
    const Vector3<S> start = seen.way_to(a), end = reach < 0 ? seen.way_to(b) : start;
    const S way2 = dot(way, way);
    ways.off = max(ways.off, max(dot(start, start), dot(end, end)));
    ways.way = max(ways.way, way2), ways.sum = ways.sum + way2;
  }

  /// How far off the mesh's frame is, before and after.
  KERNEL float shift() const {
    return fabsf(before.t[0]) + fabsf(before.t[1]) + fabsf(before.t[2]) + fabsf(after.t[0]) + fabsf(after.t[1]) +
           fabsf(after.t[2]);
  }

  /// By how much it may come too near; below 0: it cannot.
  template <class S, class Places>
  KERNEL S excess(const Places& places, int first, int k) const {
    const Vector3<S> start = load_floats<S>(particles.x, first + k), end = load_floats<S>(particles.p, first + k);
    const Vector3<S> a = before.to_local(start), b = after.to_local(end);
    const SeenLanes<S> seen = places.from(k, a);
    const Vector3<S> moved = a - seen.at, way = reach < 0 ? b - seen.at : b - a;
    const S m = sqrt(dot(moved, moved)), l = sqrt(dot(way, way));
    // Some ten roundings of each coordinate on its way.
    const S slack = (sum_of_sizes(start) + sum_of_sizes(end) + S(shift())) * S(4e-6f);
    return (reach < 0 ? max(m, l) : m + l + S(reach)) + slack - seen.distance;
  }
};

/// Bits of words, array after array.
struct ActiveMask {
  const unsigned long long* bits;
  int count, words;
  KERNEL unsigned long long of(int question, int word) const { return bits[size_t(question) * words + word]; }
  /// In any of them.
  KERNEL unsigned long long asked(int word) const {
    unsigned long long any = 0;
    for (int q = 0; q < count; ++q) any |= of(q, word);
    return any;
  }
};

/// How many the last of the questions names; of all of them how many words have one, how many particles no slot, and
/// how many words no places; and what of slots and places there is.
struct BroadPhaseCounts {
  int all = 0, words = 0, without_slot = 0, without_places = 0;
  Handed slots, places;
  KERNEL BroadPhaseCounts& operator+=(const BroadPhaseCounts& o) {
    all += o.all, words += o.words, without_slot += o.without_slot, without_places += o.without_places;
    slots += o.slots, places += o.places;
    return *this;
  }
};
template <class R>
struct CountTested {
  ActiveMask questions;
  ContactCacheView<R> nearby;
  KERNEL BroadPhaseCounts operator()(int word) const {
    BroadPhaseCounts sum;
    if (word == 0) sum.slots = *nearby.slots, sum.places = *nearby.words;
    const unsigned long long last = questions.of(questions.count - 1, word);
    unsigned long long rest = questions.asked(word);
    if (rest == 0) return sum;
    const WordPlaces* const places = nearby.places_of(word);
    sum.words = 1, sum.without_places = places == nullptr;
    for (; rest != 0; rest &= rest - 1) {
      const int bit = lowest_bit(rest);
      sum.all += int(last >> bit & 1);
      sum.without_slot += !places || places->slot[bit] < 0;
    }
    return sum;
  }
};

/// Free slots are taken out, here or on the way to other memory. One item: each has the place that those before leave.
/// One thread of a device would take longer than the way to the host.
template <class R>
struct CompactSlots {
  using AsksTheHost = void;
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
  using AsksTheHost = void;
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

/// Before contacts are laid: what there was is gone. But what comes again to where its contact was laid for, not
/// farther than `way` (m; below 0: to a mesh that moves), would find the same.
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
