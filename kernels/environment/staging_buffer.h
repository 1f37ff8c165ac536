// SPDX-License-Identifier: Apache-2.0
// Staging buffer of the particles that the host queries for a device: groups of particles with their contact caches at
// every mesh, in one block of memory that is copied to the host and back. Both sides read it by the same views.
#pragma once
#include "kernels/environment/broad_phase.h"

namespace malha {

/// Layout of the buffer from `base` on, which is aligned to kAligned bytes. Particles are renumbered: group by group,
/// in the order in which the groups were listed. Each mesh has `slot_capacity` slots for the active particles, twice
/// their number: for the slots that they have and for those that they get.
template <class R>
struct StagingBuffer {
  static constexpr size_t kAligned = 128;
  char* base;
  int groups, meshes, masks, slot_capacity;  // masks: arrays of bits

  KERNEL int count() const { return groups * kGroupSize; }
  /// Number of particle j outside the buffer.
  KERNEL int particle(int j) const { return group_index()[j / kGroupSize] * kGroupSize + j % kGroupSize; }
  /// Returns true if particle j is in any mask.
  KERNEL bool is_active(int j) const { return active().any(j / kGroupSize) >> j % kGroupSize & 1; }
  KERNEL ActiveMask active() const { return {at<unsigned long long>(kBits), masks, groups}; }
  KERNEL int* group_index() const { return at<int>(kWhich); }
  KERNEL int* group_count() const { return group_index() + groups; }  // number of groups that are listed
  /// The particles, without v.
  KERNEL Particles<R> particles() const {
    R* const x = at<R>(kParticles);
    const size_t n = size_t(count());
    const Points<R> from{x, x + n, x + 2 * n}, way{x + 3 * n, x + 4 * n, x + 5 * n};
    return {count(), from, {}, {from, way, {x + 6 * n, x + 7 * n, x + 8 * n}}, w()};
  }
  KERNEL R* w() const { return at<R>(kParticles) + size_t(9) * count(); }
  KERNEL ProximityCacheView<R> cache(int mesh) const {
    char* const own = base + begin(kMeshes) + size_t(mesh) * mesh_bytes();
    const size_t n = size_t(groups),
                 slot_bytes = size_t(slot_capacity) * (sizeof(Contact<R>) + sizeof(ProximityRecord));
    GroupEntries* const entries = reinterpret_cast<GroupEntries*>(own + slot_bytes);
    GroupBox* const boxes = reinterpret_cast<GroupBox*>(entries + n);
    int* const entry_index = reinterpret_cast<int*>(boxes + n);
    AllocationCount* const counts = reinterpret_cast<AllocationCount*>(entry_index + n);
    return {boxes,
            entry_index,
            entries,
            reinterpret_cast<Contact<R>*>(own),
            reinterpret_cast<ProximityRecord*>(own + size_t(slot_capacity) * sizeof(Contact<R>)),
            counts,
            counts + 1};
  }
  KERNEL size_t bytes() const { return begin(kMeshes) + size_t(meshes) * mesh_bytes(); }

 private:
  enum Section { kBits, kWhich, kParticles, kMeshes };
  KERNEL static size_t aligned(size_t bytes) { return (bytes + kAligned - 1) / kAligned * kAligned; }
  KERNEL size_t begin(Section section) const {
    const size_t n = size_t(groups);
    size_t at = 0;
    if (section > kBits) at += aligned(size_t(masks) * n * sizeof(unsigned long long));
    if (section > kWhich) at += aligned((n + 1) * sizeof(int));
    if (section > kParticles) at += aligned(10 * n * kGroupSize * sizeof(R));
    return at;
  }
  template <class T>
  KERNEL T* at(Section section) const {
    return reinterpret_cast<T*>(base + begin(section));
  }
  KERNEL size_t mesh_bytes() const {
    const size_t n = size_t(groups);
    return aligned(size_t(slot_capacity) * (sizeof(Contact<R>) + sizeof(ProximityRecord)) +
                   n * (sizeof(GroupEntries) + sizeof(GroupBox) + sizeof(int)) + 2 * sizeof(AllocationCount));
  }
};

/// Number of active groups, and of active particles.
struct ActiveCount {
  int groups = 0, particles = 0;
  KERNEL ActiveCount& operator+=(const ActiveCount& o) {
    groups += o.groups, particles += o.particles;
    return *this;
  }
};
struct CountActive {
  ActiveMask masks;
  KERNEL ActiveCount operator()(int g) const {
    ActiveCount sum;
    for (unsigned long long rest = masks.any(g); rest != 0; rest &= rest - 1) ++sum.particles;
    sum.groups = sum.particles > 0;
    return sum;
  }
};

/// Lists the active groups, in any order.
struct ListActiveGroups {
  ActiveMask masks;
  int *group_count, *group_index;
  KERNEL void operator()(int g) const {
    if (masks.any(g) != 0) group_index[atomic_increment(group_count)] = g;
  }
};

/// Packs the masks and the positions of the active particles into the buffer.
template <class R>
struct PackParticles {
  ActiveMask masks;
  Particles<R> particles;
  StagingBuffer<R> to;
  KERNEL void operator()(int j) const {
    const int w = j / kGroupSize, g = to.group_index()[w], bit = j % kGroupSize, i = to.particle(j);
    for (int q = 0; bit == 0 && q < masks.count; ++q) to.active().mask(q)[w] = masks.of(q, g);
    if (!(masks.any(g) >> bit & 1)) return;
    const Particles<R> own = to.particles();
    own.x.set(j, particles.x[i]), own.p.d.set(j, particles.p.d[i]);
    if constexpr (kCompensated<R>) own.p.low.set(j, particles.p.low[i]);
    to.w()[j] = particles.w[i];
  }
};

/// Packs the contact cache of a mesh. Its allocation counts are 0 before. In the buffer every group has entries.
template <class R>
struct PackCache {
  ActiveMask masks;
  Particles<R> particles;
  Pose pose;  // of the mesh, before the substep
  ProximityCacheView<R> from;
  StagingBuffer<R> buffer;
  int mesh;
  KERNEL void operator()(int j) const {
    const int w = j / kGroupSize, g = buffer.group_index()[w], bit = j % kGroupSize, i = buffer.particle(j);
    const ProximityCacheView<R> to = buffer.cache(mesh);
    if (bit == 0) to.boxes[w] = from.boxes[g], to.entry_index[w] = w;
    if (!(masks.any(g) >> bit & 1)) return;
    GroupEntries& entries = to.entries[w];
    const int own = from.slot(i);
    entries.set(bit, from.entry(i, to_local_float(pose, particles.x[i]))), entries.slot[bit] = -1;
    if (own < 0) return;
    const int s = entries.slot[bit] = atomic_increment(&to.slot_count->used);
    to.contacts[s] = from.contacts[own], to.near[s] = from.near[own];
    to.contacts[s].particle = j;
  }
};

/// Unpacks the positions of the active particles.
template <class R>
struct UnpackParticles {
  Particles<R> particles;
  StagingBuffer<R> from;
  KERNEL void operator()(int j) const {
    if (!from.is_active(j)) return;
    const Particles<R> own = from.particles();
    particles.x.set(from.particle(j), own.x[j]), particles.p.d.set(from.particle(j), own.p.d[j]);
  }
};

/// Allocates entries for groups that got them in the buffer.
template <class R>
struct AllocateUnpackedEntries {
  Particles<R> particles;
  Pose pose;  // of the mesh, before the substep
  ProximityCacheView<R> to;
  StagingBuffer<R> buffer;
  int mesh;
  KERNEL void operator()(int w) const {
    if (buffer.cache(mesh).boxes[w].has_entries()) to.allocate_entries(buffer.group_index()[w], particles, pose);
  }
};

/// Unpacks the contact cache of a mesh: frees and fills slots as a query on the device would.
template <class R>
struct UnpackCache {
  ProximityCacheView<R> to;
  StagingBuffer<R> buffer;
  int mesh;
  KERNEL void operator()(int j) const {
    const ProximityCacheView<R> from = buffer.cache(mesh);
    const int w = j / kGroupSize, g = buffer.group_index()[w], bit = j % kGroupSize;
    if (bit == 0) to.boxes[g] = from.boxes[w];
    if (!buffer.is_active(j) || to.entry_index[g] < 0) return;
    const int i = buffer.particle(j), own = from.entries[w].slot[bit];
    GroupEntries& entries = to.entries[to.entry_index[g]];
    entries.set(bit, from.entries[w].of(bit));
    int& s = entries.slot[bit];
    if (own < 0) {
      if (s >= 0) to.contacts[s].particle = -1, s = -1, atomic_increment(&to.slot_count->freed);
      return;
    }
    if (s < 0) s = atomic_increment(&to.slot_count->used);
    to.contacts[s] = from.contacts[own], to.near[s] = from.near[own];
    to.contacts[s].particle = i;
  }
};

}  // namespace malha
