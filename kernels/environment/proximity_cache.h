// SPDX-License-Identifier: Apache-2.0
// Proximity cache: what the last queries at one environment mesh found, kept from substep to substep. One rule says how
// long any of it is used: an entry holds while the particle has moved less than the entry's radius from where it was
// made (holds()). In the mesh's frame, from the coarse to the fine:
//
//   entry               made at                          says                             radius
//   GroupBox            the nearest point of the box     no surface is nearer             its distance
//   CacheEntry          the particle, in float           no surface is nearer             its distance
//   ClosestPointRecord  the particle                     the closest triangle, the side   its distance
//   ClosestFeature      the particle                     the closest feature is the same  where no other is nearer
//   Contact             the particle, at rest            the plane is the same            0: the particle has not moved
//
// A reader that needs the surface to be some way off subtracts that from the radius: the length of a path and the range
// of contacts (broad_phase.h, contact_query.h), or what a whole step may need (clearance.h). Boxes serve groups of 64
// particles that are far away together, entries all particles of the other groups, and slots, which hold the rest, the
// particles near the mesh. The grid of the octree follows the rule for all particles: its entries are made at the
// centres of its cells (distance_lower_bound()).
#pragma once
#include "kernels/attachments/pose.h"
#include "kernels/environment/contact.h"
#include "kernels/environment/feature_cache.h"
#include "kernels/simd/pack.h"
#include "kernels/simd/particles.h"

namespace malha {

/// Returns the number before the addition.
KERNEL int atomic_add(int* number, int by) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(number, by);
#else
  return __atomic_fetch_add(number, by, __ATOMIC_RELAXED);
#endif
}
KERNEL int atomic_increment(int* number) { return atomic_add(number, 1); }

inline constexpr int kGroupSize = 64;  // particles, a bit each in a mask

/// Cache entry of a particle: its position at the last query (m, mesh's frame), and a lower bound of the signed
/// distance of the surface from there (m).
struct CacheEntry {
  float x, y, z, distance;
};

/// The point of the box from low to high that is nearest to a.
template <class S>
KERNEL Vector3<S> nearest_in(const Vector3<float>& low, const Vector3<float>& high, const Vector3<S>& a) {
  return {max(S(low.x), min(a.x, S(high.x))), max(S(low.y), min(a.y, S(high.y))), max(S(low.z), min(a.z, S(high.z)))};
}

/// Result of the last query of a particle: its position (mesh's frame), the distance of the surface (m; negative
/// inside; a lower bound where no triangle is near), and the closest triangle. A particle is queried again only when it
/// may have come near, which does not change which contacts are found.
struct ClosestPointRecord {
  Vector3<double> at{};
  double distance = -INFINITY;  // never queried: it may be as deep as the mesh is large
  long long triangle = -1;
  Vector3<double> tunnel_offset{};  // m, offset through the surface of a particle that was forced through it
  double overlap = 0;  // m, by which it may stay nearer than the thickness, because it was at its first query

  /// Returns true if no surface lies between a and b: both are within the distance of the surface.
  KERNEL bool is_path_clear(const Vector3<double>& a, const Vector3<double>& b) const {
    return holds(a, at, distance) && holds(b, at, distance);
  }
};

/// Record of a mesh-particle pair, for checkpoints; pair = mesh * particles + particle.
struct PairRecord {
  long long pair = 0;
  ClosestPointRecord record;
};

/// What a slot has beside its contact.
struct ProximityRecord {
  ClosestPointRecord record;
  ClosestFeature feature;
};

/// Lets particles keep their overlap, up to max_overlap, as at a first query within the thickness on either side.
struct KeepOverlap {
  ProximityRecord* near;
  double max_overlap;  // m
  KERNEL void operator()(int slot) const { near[slot].record.overlap = max_overlap; }
};

/// Bounding box of a group of particles at their last query (m, mesh's frame), for a test of the whole group. A
/// particle without an entry of its own counts as queried at the point of the box that is nearest to it.
struct GroupBox {
  Vector3<float> centre, half;
  /// Lower bound of the distance of the surface from any point of the box. Below 0: the same with its magnitude, but
  /// particles have left the box too far for the group test. 0: no particle was ever queried. kPerParticle: every
  /// particle has an entry of its own.
  float distance;

  static constexpr float kPerParticle = -INFINITY;
  /// Returns true if a test of the whole group can rule out contact.
  KERNEL bool can_test_group() const { return distance > 0; }
  KERNEL bool has_entries() const { return distance == kPerParticle; }
  KERNEL float clearance() const { return distance == 0 ? -INFINITY : fabsf(distance); }
  KERNEL CacheEntry entry(const Vector3<float>& a) const {
    if (distance == 0 || has_entries()) return {0, 0, 0, -INFINITY};
    const Vector3<float> nearest = nearest_in(centre - half, centre + half, a);
    return {nearest.x, nearest.y, nearest.z, clearance()};
  }
  /// Offset of a from the box, per axis; 0 inside.
  template <class S>
  KERNEL Vector3<S> offset_from_box(const Vector3<S>& a) const {
    const Vector3<S> d = a - Vector3<S>{S(centre.x), S(centre.y), S(centre.z)};
    return {max(abs(d.x) - S(half.x), S(0.0f)), max(abs(d.y) - S(half.y), S(0.0f)), max(abs(d.z) - S(half.z), S(0.0f))};
  }
  KERNEL void disable_group_test() { distance = distance < 1e38f ? -distance : -1e38f; }
  /// Switches to entries; half.x then says whether any particle was queried since a box was last tried.
  KERNEL void use_entries() { distance = kPerParticle, half.x = 1; }
  KERNEL bool should_refit() const { return has_entries() && half.x != 0; }
  KERNEL void note_refit() { half.x = 0; }
};

/// Entries and slots of the particles of a group.
struct GroupEntries {
  float x[kGroupSize], y[kGroupSize], z[kGroupSize], distance[kGroupSize];  // as in CacheEntry
  int slot[kGroupSize];                                                     // none: -1
  int group;                                                                // that these belong to; -1: free

  KERNEL CacheEntry of(int k) const { return {x[k], y[k], z[k], distance[k]}; }
  KERNEL void set(int k, const CacheEntry& to) { x[k] = to.x, y[k] = to.y, z[k] = to.z, distance[k] = to.distance; }
  KERNEL bool has_slots(int n) const {
    bool any = false;
    for (int k = 0; k < n; ++k) any = any || slot[k] >= 0;
    return any;
  }
};

/// Position of a particle in a mesh's frame, in float as entries store it.
template <class R>
KERNEL Vector3<float> to_local_float(const Pose& mesh, const Vector3<R>& x) {
  return rounded<float>(to_local(mesh, in_double(x)));
}

/// Elements of a pool that were allocated, from the first on, and how many of them are free again.
struct AllocationCount {
  int used = 0, freed = 0;
  KERNEL AllocationCount& operator+=(const AllocationCount& o) {
    used += o.used, freed += o.freed;
    return *this;
  }
};

/// The cache of one mesh. Its pools have capacity for the entries and the slots of all particles that are queried.
template <class R>
struct ProximityCacheView {
  GroupBox* boxes;
  int* entry_index;                           // of each group: index into `entries`; none: -1
  GroupEntries* entries;                      // of the groups with entries
  Contact<R>* contacts;                       // of each slot
  ProximityRecord* near;                      // of each slot
  AllocationCount *slot_count, *entry_count;  // of contacts and near, and of entries

  KERNEL const GroupEntries* entries_of(int group) const {
    return entry_index[group] < 0 ? nullptr : entries + entry_index[group];
  }
  KERNEL int slot(int i) const {
    const GroupEntries* const of = entries_of(i / kGroupSize);
    return of ? of->slot[i % kGroupSize] : -1;
  }
  /// The entry of a particle at a (mesh's frame): its own, or that of its group's box.
  KERNEL CacheEntry entry(int i, const Vector3<float>& a) const {
    const GroupEntries* const of = entries_of(i / kGroupSize);
    return of ? of->of(i % kGroupSize) : boxes[i / kGroupSize].entry(a);
  }
  /// The record of a particle at a (mesh's frame), or what its entry says.
  KERNEL ClosestPointRecord record(int i, const Vector3<double>& a) const {
    if (const int s = slot(i); s >= 0) return near[s].record;
    const CacheEntry last = entry(i, rounded<float>(a));
    return {{double(last.x), double(last.y), double(last.z)}, double(last.distance), -1, {0, 0, 0}};
  }
  /// See ClosestPointRecord::overlap.
  KERNEL double overlap(int i) const {
    const int s = slot(i);
    return s < 0 ? 0 : near[s].record.overlap;
  }

  /// Allocates entries for a group, as store() needs them. Only one thread may do so for a group at a time.
  KERNEL void allocate_entries(int group, const Particles<R>& particles, const Pose& mesh) const {
    if (entry_index[group] >= 0) return;
    const int to = atomic_increment(&entry_count->used), first = group * kGroupSize;
    GroupEntries& own = entries[to];
    for (int k = 0; k < kGroupSize; ++k) {
      own.slot[k] = -1;
      own.set(k, first + k < particles.count ? boxes[group].entry(to_local_float(mesh, particles.x[first + k]))
                                             : CacheEntry{0, 0, 0, -INFINITY});
    }
    own.group = group, entry_index[group] = to;
    boxes[group].use_entries();
  }
  /// Frees the entries of a group whose box suffices from now on. None of its particles has a slot.
  KERNEL void free_entries(int group) const {
    entries[entry_index[group]].group = -1, entry_index[group] = -1;
    atomic_increment(&entry_count->freed);
  }

  /// Stores a record: as an entry, and in a slot where an entry is not enough.
  KERNEL void store(int i, const ClosestPointRecord& last) const {
    const Vector3<float> rounded = in_float(last.at);
    GroupEntries& own = entries[entry_index[i / kGroupSize]];
    const int k = i % kGroupSize;
    own.set(k, {rounded.x, rounded.y, rounded.z, distance_lower_bound(last)});
    boxes[i / kGroupSize].use_entries();
    int s = own.slot[k];
    if (!needs_slot(last)) {
      if (s < 0) return;
      contacts[s].particle = -1, own.slot[k] = -1;
      atomic_increment(&slot_count->freed);
      return;
    }
    if (s < 0) {
      s = own.slot[k] = atomic_increment(&slot_count->used);
      contacts[s].particle = i;
      clear_slot(contacts[s], near[s]);
    }
    near[s].record = last;
  }
  /// Clears a slot: no contact, no feature.
  KERNEL static void clear_slot(Contact<R>& contact, ProximityRecord& near) {
    invalidate(contact);
    near.feature.radius = -1;
  }

  /// Returns true if a record holds more than an entry can.
  KERNEL static bool needs_slot(const ClosestPointRecord& last) {
    const Vector3<double>& tunnel_offset = last.tunnel_offset;
    return last.triangle >= 0 || tunnel_offset.x != 0 || tunnel_offset.y != 0 || tunnel_offset.z != 0 ||
           !(distance_lower_bound(last) > 0 || last.distance == -INFINITY);
  }

  KERNEL Contact<R>* contact(int i) const {
    const int s = slot(i);
    return s < 0 ? nullptr : contacts + s;
  }

 private:
  KERNEL static Vector3<float> in_float(const Vector3<double>& a) { return {float(a.x), float(a.y), float(a.z)}; }
  /// Lower bound of the distance from the position as an entry rounds it.
  KERNEL static float distance_lower_bound(const ClosestPointRecord& last) {
    const Vector3<float> rounded = in_float(last.at);
    const Vector3<double> off{last.at.x - rounded.x, last.at.y - rounded.y, last.at.z - rounded.z};
    const double bound = last.distance - sqrt(dot(off, off));
    const float nearest = float(bound);
    const float below = nearest - 1.2e-7f * fabsf(nearest);
    return double(nearest) > bound ? below : nearest;
  }
};

/// Compacts the slots, in place or into other memory. One item, because every slot moves to the next free index; it
/// runs on the host because one thread of a device would take longer than the transfers.
template <class R>
struct CompactSlots {
  using RunsOnHost = void;
  ProximityCacheView<R> cache;
  ProximityRecord* near_to;
  Contact<R>* contacts_to;
  KERNEL void operator()(int) const {
    int kept = 0;
    for (int s = 0; s < cache.slot_count->used; ++s) {
      const int i = cache.contacts[s].particle;
      if (i < 0) continue;
      near_to[kept] = cache.near[s], contacts_to[kept] = cache.contacts[s];
      cache.entries[cache.entry_index[i / kGroupSize]].slot[i % kGroupSize] = kept;
      ++kept;
    }
    *cache.slot_count = {kept, 0};
  }
};
/// Compacts the entries likewise.
template <class R>
struct CompactEntries {
  using RunsOnHost = void;
  ProximityCacheView<R> cache;
  GroupEntries* to;
  KERNEL void operator()(int) const {
    int kept = 0;
    for (int k = 0; k < cache.entry_count->used; ++k) {
      if (cache.entries[k].group < 0) continue;
      to[kept] = cache.entries[k];
      cache.entry_index[to[kept].group] = kept;
      ++kept;
    }
    *cache.entry_count = {kept, 0};
  }
};

}  // namespace malha
