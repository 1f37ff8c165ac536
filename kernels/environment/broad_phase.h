// SPDX-License-Identifier: Apache-2.0
// The broad phase of contacts with an environment mesh: which particles may have come near enough to be looked at. A
// stream in float over the contact cache, group by group of particles.
#pragma once
#include "kernels/environment/contact_cache.h"

namespace malha {

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
KERNEL S l1_norm(const Vector3<S>& a) {
  return abs(a.x) + abs(a.y) + abs(a.z);
}

/// The box around a mesh in its own frame, m, in float.
struct FloatBox {
  Vector3<float> centre, half;
};

/// A place, or one for each lane of a pack, and how near nothing is.
template <class S>
struct CacheEntryLanes {
  Vector3<S> at;
  S distance;
};
/// Where the particles of a word that are at a were seen: each, or by their box.
struct ParticleEntries {
  const GroupEntries* places;
  template <class S>
  KERNEL CacheEntryLanes<S> from(int k, const Vector3<S>&) const {
    CacheEntryLanes<S> lanes;
    load(places->x + k, lanes.at.x), load(places->y + k, lanes.at.y), load(places->z + k, lanes.at.z);
    load(places->distance + k, lanes.distance);
    return lanes;
  }
};
struct BoxEntry {
  Vector3<float> low, high;
  float distance;
  KERNEL explicit BoxEntry(const GroupBox& box)
      : low(box.centre - box.half), high(box.centre + box.half), distance(box.clearance()) {}
  template <class S>
  KERNEL CacheEntryLanes<S> from(int, const Vector3<S>& a) const {
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
    GroupBox& seen = nearby.boxes[group.index];
    const GroupEntries* const places = nearby.places_of(group.index);
    if (seen.can_test_group()) {
      if (is_separated<S>(seen, first, n)) return;
      seen.leave();
      if (follows<S>(seen, first, n)) return;
    } else if (seen.distance == 0 && follows<S>(seen, first, n)) {
      return;
    }
    const unsigned long long touch =
        places ? touching<S>(ParticleEntries{places}, first, n) : touching<S>(BoxEntry(seen), first, n);
    if (touch == 0 && seen.should_refit() && reach >= 0) {
      seen.note_refit();
      if (!places->has_slots(n) && (follows<S>(seen, first, n) || stays(seen, *places, n)))
        nearby.free_entries(group.index);
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
  KERNEL bool follows(GroupBox& seen, int first, int n) const {
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
    const float sizes = l1_norm(c) + l1_norm(half) + l1_norm(mesh.centre) + l1_norm(mesh.half);
    const GroupBox now{c, half, 0.99999f * sqrt(dot(gap, gap)) - 1e-5f * (sizes + shift())};
    if (!now.can_test_group() || !is_separated<S>(now, first, n)) return false;
    seen = now;
    return true;
  }
  /// The same of the middle of where they were seen.
  KERNEL bool stays(GroupBox& seen, const GroupEntries& places, int n) const {
    const GroupBox middle = middle_of(places, n);
    if (!middle.can_test_group()) return false;
    seen = middle;
    return true;
  }

  /// Whether no particle of the word can have come near: all are near a box to which nothing is near.
  template <class S>
  KERNEL bool is_separated(const GroupBox& seen, int first, int n) const {
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
    const float slack = 1e-5f * (l1_norm(seen.centre) + l1_norm(seen.half) + beyond + path + shift());
    return (reach < 0 ? beyond : beyond + path + reach) + slack < seen.distance;
  }
  /// How far particles are off a box and how long their ways are at most, squared; the sum is not a number, or is not
  /// finite, where one of them is so.
  template <class S>
  struct Ways {
    S off = S(0.0f), way = S(0.0f), sum = S(0.0f);
  };
  template <class S>
  KERNEL void add_way(Ways<S>& ways, const GroupBox& seen, int i) const {
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
    const CacheEntryLanes<S> seen = places.from(k, a);
    const Vector3<S> moved = a - seen.at, way = reach < 0 ? b - seen.at : b - a;
    const S m = sqrt(dot(moved, moved)), l = sqrt(dot(way, way));
    // Some ten roundings of each coordinate on its way.
    const S slack = (l1_norm(start) + l1_norm(end) + S(shift())) * S(4e-6f);
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
  AllocationCount slots, places;
  KERNEL BroadPhaseCounts& operator+=(const BroadPhaseCounts& o) {
    all += o.all, words += o.words, without_slot += o.without_slot, without_places += o.without_places;
    slots += o.slots, places += o.places;
    return *this;
  }
};
template <class R>
struct CountBroadPhase {
  ActiveMask questions;
  ContactCacheView<R> nearby;
  KERNEL BroadPhaseCounts operator()(int word) const {
    BroadPhaseCounts sum;
    if (word == 0) sum.slots = *nearby.slots, sum.places = *nearby.words;
    const unsigned long long last = questions.of(questions.count - 1, word);
    unsigned long long rest = questions.asked(word);
    if (rest == 0) return sum;
    const GroupEntries* const places = nearby.places_of(word);
    sum.words = 1, sum.without_places = places == nullptr;
    for (; rest != 0; rest &= rest - 1) {
      const int bit = lowest_bit(rest);
      sum.all += int(last >> bit & 1);
      sum.without_slot += !places || places->slot[bit] < 0;
    }
    return sum;
  }
};

}  // namespace malha
