// SPDX-License-Identifier: Apache-2.0
// Broad phase of contacts with an environment mesh: the particles that may have come near enough for a query. It
// streams over the contact cache in float, group by group of particles.
#pragma once
#include "kernels/environment/proximity_cache.h"

namespace malha {

/// A pose in float, for the broad phase.
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

/// Loads a number or a pack, rounded to float.
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

/// Cache entries of the lanes of a pack (or of one particle).
template <class S>
struct CacheEntryLanes {
  Vector3<S> at;
  S distance;
};
/// Loads cache entries from the entries of a group.
struct ParticleEntries {
  const GroupEntries* entries;
  template <class S>
  KERNEL CacheEntryLanes<S> from(int k, const Vector3<S>&) const {
    CacheEntryLanes<S> lanes;
    load(entries->x + k, lanes.at.x), load(entries->y + k, lanes.at.y), load(entries->z + k, lanes.at.z);
    load(entries->distance + k, lanes.distance);
    return lanes;
  }
};
/// Derives cache entries of particles at a from the box of their group.
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

/// Sets the bits of the particles that need a query; conservative, in float. `contact_range` < 0: particles whose path
/// from x to p may leave the empty ball around their last query; otherwise particles whose path may come nearer to the
/// surface than `contact_range` (m). Groups that are far away as a whole are ruled out by their boxes. A group that has
/// left its box or was never queried, is far from the mesh and has no pinned particle, gets a box around its present
/// positions.
template <class R>
struct BroadPhaseTest {
  Particles<R> particles;
  ProximityCacheView<R> cache;
  FloatPose before, after;
  FloatBox mesh;
  float contact_range;
  bool add;  // to the bits that are set
  unsigned long long* bits;

  template <class Group>
  KERNEL void operator()(const Group& group) const {
    using S = Lane<float, typename Group::Isa>;
    const int first = group.index * kGroupSize, left = particles.count - first,
              n = left < kGroupSize ? left : kGroupSize;
    const unsigned long long previous = add ? bits[group.index] : 0;
    bits[group.index] = previous;
    GroupBox& box = cache.boxes[group.index];
    const GroupEntries* const entries = cache.entries_of(group.index);
    if (box.can_test_group()) {
      if (is_separated<S>(box, first, n)) return;
      box.disable_group_test();
      if (refit_box<S>(box, first, n)) return;
    } else if (box.distance == 0 && refit_box<S>(box, first, n)) {
      return;
    }
    const unsigned long long in_range = entries ? particles_in_range<S>(ParticleEntries{entries}, first, n)
                                                : particles_in_range<S>(BoxEntry(box), first, n);
    if (in_range == 0 && box.should_refit() && contact_range >= 0) {
      box.note_refit();
      if (!entries->has_slots(n) && refit_box<S>(box, first, n)) cache.free_entries(group.index);
    }
    bits[group.index] = previous | in_range;
  }

 private:
  /// Mask of the numbers that are not below 0; NaN counts too.
  KERNEL static unsigned long long mask_of_non_negative(const float* a) {
    unsigned char flags[kGroupSize];
    for (int k = 0; k < kGroupSize; ++k) flags[k] = !(a[k] < 0);
    unsigned long long bits = 0;
    for (int k = 0; k < kGroupSize; k += 8) {
      unsigned long long eight;  // bytes, whose lowest bits the product gathers in its highest byte
      __builtin_memcpy(&eight, flags + k, sizeof eight);
      bits |= (eight * 0x0102040810204080ull >> 56) << k;
    }
    return bits;
  }
  template <class S, class Entries>
  KERNEL unsigned long long particles_in_range(const Entries& entries, int first, int n) const {
    constexpr int lanes = int(sizeof(S) / sizeof(float));
    float over[kGroupSize];
    int k = 0;
    for (; k + lanes <= n; k += lanes) store(excess<S>(entries, first, k), over + k);
    for (; k < n; ++k) over[k] = excess<float>(entries, first, k);
    for (; k < kGroupSize; ++k) over[k] = -1;
    return mask_of_non_negative(over);
  }

  /// Refits the box to the present positions, if that is far enough from the mesh's box. Returns true on success.
  template <class S>
  KERNEL bool refit_box(GroupBox& box, int first, int n) const {
    for (int i = first; i < first + n; ++i)
      if (!(particles.w[i] > R(0))) return false;
    const auto local = [&](int i) KERNEL_LAMBDA { return before.to_local(load_floats<float>(particles.x, i)); };
    Vector3<float> low = local(first), high = low;
    for (int i = first + 1; i < first + n; ++i) {
      const Vector3<float> a = local(i);
      low = {min(low.x, a.x), min(low.y, a.y), min(low.z, a.z)};
      high = {max(high.x, a.x), max(high.y, a.y), max(high.z, a.z)};
    }
    const Vector3<float> c = (low + high) * 0.5f, half = high - c, to_mesh = c - mesh.centre;
    const Vector3<float> gap{max(0.0f, fabsf(to_mesh.x) - half.x - mesh.half.x),
                             max(0.0f, fabsf(to_mesh.y) - half.y - mesh.half.y),
                             max(0.0f, fabsf(to_mesh.z) - half.z - mesh.half.z)};
    const float sizes = l1_norm(c) + l1_norm(half) + l1_norm(mesh.centre) + l1_norm(mesh.half);
    const GroupBox now{c, half, 0.99999f * sqrt(dot(gap, gap)) - 1e-5f * (sizes + frame_offset())};
    if (!now.can_test_group() || !is_separated<S>(now, first, n)) return false;
    box = now;
    return true;
  }
  /// Returns true if no particle of the group can have come near the surface: all are near a box that is far from it.
  template <class S>
  KERNEL bool is_separated(const GroupBox& box, int first, int n) const {
    constexpr int lanes = int(sizeof(S) / sizeof(float));
    PathBounds<S> of_lanes;
    PathBounds<float> total;
    int k = 0;
    for (; k + lanes <= n; k += lanes) add_path(of_lanes, box, first + k);
    for (; k < n; ++k) add_path(total, box, first + k);
    float offset2[lanes], way[lanes], sum[lanes];
    store(of_lanes.offset2, offset2), store(of_lanes.way, way), store(of_lanes.sum, sum);
    for (int l = 0; l < lanes; ++l)
      total.offset2 = max(total.offset2, offset2[l]), total.way = max(total.way, way[l]), total.sum += sum[l];
    if (!(total.sum < INFINITY)) return false;
    const float offset = sqrt(total.offset2), path = sqrt(total.way);
    const float slack = 1e-5f * (l1_norm(box.centre) + l1_norm(box.half) + offset + path + frame_offset());
    return (contact_range < 0 ? offset : offset + path + contact_range) + slack < box.distance;
  }
  /// Largest squared distance of particles from a box, and largest squared length of their paths. The sum is not finite
  /// if one of the paths is not.
  template <class S>
  struct PathBounds {
    S offset2 = S(0.0f), way = S(0.0f), sum = S(0.0f);
  };
  template <class S>
  KERNEL void add_path(PathBounds<S>& bounds, const GroupBox& box, int i) const {
    const Vector3<S> a = before.to_local(load_floats<S>(particles.x, i));
    const Vector3<S> b = after.to_local(load_floats<S>(particles.p, i)), way = b - a;
    const Vector3<S> start = box.offset_from_box(a), end = contact_range < 0 ? box.offset_from_box(b) : start;
    const S length2 = dot(way, way);
    bounds.offset2 = max(bounds.offset2, max(dot(start, start), dot(end, end)));
    bounds.way = max(bounds.way, length2), bounds.sum = bounds.sum + length2;
  }

  /// Size of the translations of the mesh's frame, for rounding bounds, m.
  KERNEL float frame_offset() const {
    return fabsf(before.t[0]) + fabsf(before.t[1]) + fabsf(before.t[2]) + fabsf(after.t[0]) + fabsf(after.t[1]) +
           fabsf(after.t[2]);
  }

  /// By how much a particle may come too near, m; below 0: it cannot.
  template <class S, class Entries>
  KERNEL S excess(const Entries& entries, int first, int k) const {
    const Vector3<S> start = load_floats<S>(particles.x, first + k), end = load_floats<S>(particles.p, first + k);
    const Vector3<S> a = before.to_local(start), b = after.to_local(end);
    const CacheEntryLanes<S> entry = entries.from(k, a);
    const Vector3<S> moved = a - entry.at, way = contact_range < 0 ? b - entry.at : b - a;
    const S m = sqrt(dot(moved, moved)), l = sqrt(dot(way, way));
    // Covers some ten roundings of each coordinate.
    const S slack = (l1_norm(start) + l1_norm(end) + S(frame_offset())) * S(4e-6f);
    return (contact_range < 0 ? max(m, l) : m + l + S(contact_range)) + slack - entry.distance;
  }
};

/// Masks of particles, one bit each: `count` arrays of a word for each group.
struct ActiveMask {
  unsigned long long* bits;
  int count, groups;
  KERNEL unsigned long long* mask(int q) const { return bits + size_t(q) * groups; }
  KERNEL unsigned long long of(int q, int g) const { return mask(q)[g]; }
  /// Particles of a group that are in any mask.
  KERNEL unsigned long long any(int g) const {
    unsigned long long any = 0;
    for (int q = 0; q < count; ++q) any |= of(q, g);
    return any;
  }
};

/// Counts after the broad phase: particles in the last mask; groups with a particle in any mask, particles of these
/// without a slot, and groups without entries; and the state of the pools.
struct BroadPhaseCounts {
  int particles = 0, groups = 0, without_slot = 0, without_entries = 0;
  AllocationCount slots, entries;
  KERNEL BroadPhaseCounts& operator+=(const BroadPhaseCounts& o) {
    particles += o.particles, groups += o.groups, without_slot += o.without_slot, without_entries += o.without_entries;
    slots += o.slots, entries += o.entries;
    return *this;
  }
};
template <class R>
struct CountBroadPhase {
  ActiveMask masks;
  ProximityCacheView<R> cache;
  KERNEL BroadPhaseCounts operator()(int g) const {
    BroadPhaseCounts sum;
    if (g == 0) sum.slots = *cache.slot_count, sum.entries = *cache.entry_count;
    const unsigned long long last = masks.of(masks.count - 1, g);
    unsigned long long rest = masks.any(g);
    if (rest == 0) return sum;
    const GroupEntries* const entries = cache.entries_of(g);
    sum.groups = 1, sum.without_entries = entries == nullptr;
    for (; rest != 0; rest &= rest - 1) {
      const int bit = lowest_bit(rest);
      sum.particles += int(last >> bit & 1);
      sum.without_slot += !entries || entries->slot[bit] < 0;
    }
    return sum;
  }
};

}  // namespace malha
