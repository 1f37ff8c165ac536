// SPDX-License-Identifier: Apache-2.0
// Proximity cache of one environment mesh (kernels/environment/proximity_cache.h): its storage, which grows and shrinks
// with the particles near the mesh, and its saved state.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/base/array.h"
#include "host/environment/proximity_memory.h"
#include "kernels/environment/proximity_cache.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// Plan of a pool of `size` elements before `more` elements are allocated; fewer free elements than `spare` are
/// not worth a copy.
struct CapacityPlan {
  bool compacts, reallocates;  // remove free elements; move the rest to new memory
  std::size_t capacity;        // elements of the new memory
  CapacityPlan(const AllocationCount& count, int more, std::size_t size, int spare) {
    const std::size_t used = static_cast<std::size_t>(count.used), added = static_cast<std::size_t>(more);
    const std::size_t needed = used - static_cast<std::size_t>(count.freed) + added;
    const bool wide = size > 4 * needed + 32 * static_cast<std::size_t>(spare);
    compacts = count.freed > count.used / 4 + spare || used + added > size || wide;
    reallocates = needed > size || wide;
    // A list that has grown before grows again, by so much that few steps do it.
    capacity =
        needed + needed / (needed > size && size > 0 ? 2 : 8) + (more > 0 ? static_cast<std::size_t>(spare / 2) : 0);
  }
};

template <class Executor, class R>
class ProximityCache {
 public:
  explicit ProximityCache(std::size_t particles)
      : particles_(particles),
        boxes_(groups_of(particles), GroupBox{}),
        entry_index_(groups_of(particles), -1),
        counts_(2, AllocationCount{}) {}

  ProximityCacheView<R> view() const {
    return {boxes_.data(), entry_index_.data(), entries_.data(),   contacts_.data(),
            near_.data(),  counts_.data(),      counts_.data() + 1};
  }

  /// Number of slots that are in use; on a device an upper bound, since the host does not wait for the number.
  int slots() const { return Memory<Executor>::kOnHost ? slot_count().used : slot_bound_; }

  /// Reserves this many more slots and entries of groups, and shrinks pools that are much larger than needed.
  void reserve_slots(const Executor& executor, int slots, const AllocationCount& slot_count, int entries,
                     const AllocationCount& entry_count) {
    ensure_slot_capacity(executor, slots, slot_count);
    ensure_entry_capacity(executor, entries, entry_count);
  }

  /// The state that later substeps depend on, as in ProximityMemory. A position beyond float is in the slot alone.
  std::vector<GroupBox> boxes() const { return boxes_.download(); }
  std::vector<CacheEntry> entries() const {
    const std::vector<int> entry_index = entry_index_.download();
    const auto own = first_of(entries_, static_cast<std::size_t>(entry_count().used));
    std::vector<CacheEntry> all;
    for (std::size_t group = 0; group < entry_index.size(); ++group)
      for (int k = 0; entry_index[group] >= 0 && k < particles_in_group(group, particles_); ++k) {
        const CacheEntry at = own[static_cast<std::size_t>(entry_index[group])].of(k);
        const bool finite = std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z);
        all.push_back(finite ? at : CacheEntry{0, 0, 0, -INFINITY});
      }
    return all;
  }
  /// `first`: the first pair of the mesh.
  std::vector<PairRecord> pair_records(long long first) const {
    const auto slots = static_cast<std::size_t>(slot_count().used);
    const std::vector<Contact<R>> contacts = first_of(contacts_, slots);
    const std::vector<ProximityRecord> near = first_of(near_, slots);
    std::vector<PairRecord> all;
    for (std::size_t s = 0; s < slots; ++s)
      if (contacts[s].particle >= 0) all.push_back({first + contacts[s].particle, near[s].record});
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.pair < b.pair; });
    return all;
  }
  /// Upper bound of the number of entries.
  std::size_t max_entries() const { return static_cast<std::size_t>(entry_count().used) * kGroupSize; }
  /// Restores the boxes, the entries and `count` records of this mesh.
  void restore_state(const Executor& executor, std::vector<GroupBox> boxes, const CacheEntry* entry,
                     const PairRecord* near, std::size_t count, long long first) {
    std::vector<int> entry_index(boxes.size(), -1);
    std::vector<GroupEntries> entries;
    std::vector<Contact<R>> contacts(count);
    std::vector<ProximityRecord> records(count);
    const auto entries_for = [&](std::size_t group) -> GroupEntries& {
      if (entry_index[group] < 0) {
        entry_index[group] = static_cast<int>(entries.size());
        GroupEntries& own = entries.emplace_back();
        own.group = static_cast<int>(group);
        for (int k = 0; k < kGroupSize; ++k) own.set(k, {0, 0, 0, -INFINITY}), own.slot[k] = -1;
      }
      return entries[static_cast<std::size_t>(entry_index[group])];
    };
    for (std::size_t group = 0; group < boxes.size(); ++group)
      for (int k = 0; boxes[group].has_entries() && k < particles_in_group(group, particles_); ++k)
        entries_for(group).set(k, *entry++);
    for (std::size_t s = 0; s < count; ++s) {
      contacts[s].particle = static_cast<int>(near[s].pair - first);
      ProximityCacheView<R>::clear_slot(contacts[s], records[s]);
      records[s].record = near[s].record;
      const auto group = static_cast<std::size_t>(contacts[s].particle / kGroupSize);
      entries_for(group).slot[contacts[s].particle % kGroupSize] = static_cast<int>(s);
      if (!boxes[group].has_entries()) boxes[group].use_entries();
    }
    counts_.upload({{}, {}});
    const int slots = static_cast<int>(count), groups = static_cast<int>(entries.size());
    reserve_slots(executor, slots, {}, groups, {});
    empty_from(0);
    fill_first(entries_, entries), fill_first(contacts_, contacts), fill_first(near_, records);
    counts_.upload({{slots, 0}, {groups, 0}}), entry_index_.upload(entry_index), boxes_.upload(boxes);
  }

  void clear(const Executor& executor) {
    restore_state(executor, std::vector<GroupBox>(boxes_.size(), GroupBox{}), nullptr, nullptr, 0, 0);
  }

  /// Number of slots in use.
  int near() const {
    const AllocationCount count = slot_count();
    return count.used - count.freed;
  }
  std::size_t near_bytes() const { return near_.bytes() + contacts_.bytes(); }
  std::size_t bytes() const {
    return boxes_.bytes() + entry_index_.bytes() + counts_.bytes() + entries_.bytes() + near_bytes();
  }

 private:
  AllocationCount slot_count() const { return counts_.get(0); }
  AllocationCount entry_count() const { return counts_.get(1); }

  void ensure_slot_capacity(const Executor& executor, int more, const AllocationCount& count) {
    slot_bound_ = count.used + more;
    const CapacityPlan plan(count, more, near_.size(), kSpareSlots);
    if (!plan.compacts) return;
    Array<Executor, ProximityRecord> near_to(plan.reallocates ? plan.capacity : 0);
    Array<Executor, Contact<R>> contacts_to(plan.reallocates ? plan.capacity : 0);
    if (count.used > 0)
      parallel_for(executor, 1,
                   CompactSlots<R>{view(), plan.reallocates ? near_to.data() : near_.data(),
                                   plan.reallocates ? contacts_to.data() : contacts_.data()});
    const int kept = count.used - count.freed;
    if (plan.reallocates) near_ = std::move(near_to), contacts_ = std::move(contacts_to);
    slot_bound_ = kept + more;
    empty_from(static_cast<std::size_t>(kept));
  }
  void ensure_entry_capacity(const Executor& executor, int more, const AllocationCount& count) {
    const CapacityPlan plan(count, more, entries_.size(), kSpareEntries);
    if (!plan.compacts) return;
    Array<Executor, GroupEntries> to(plan.reallocates ? plan.capacity : 0);
    if (count.used > 0)
      parallel_for(executor, 1, CompactEntries<R>{view(), plan.reallocates ? to.data() : entries_.data()});
    if (plan.reallocates) entries_ = std::move(to);
  }

  template <class T>
  static std::vector<T> first_of(const Array<Executor, T>& array, std::size_t count) {
    std::vector<T> values(count);
    if (count > 0) Memory<Executor>::copy_out(array.data(), count, values.data());
    return values;
  }
  template <class T>
  static void fill_first(const Array<Executor, T>& array, const std::vector<T>& values) {
    if (!values.empty()) Memory<Executor>::copy_in(values.data(), values.size(), array.data());
  }

  /// Empties the slots from `slot` on: a device visits all slots up to an upper bound.
  void empty_from([[maybe_unused]] std::size_t slot) {
    if constexpr (!Memory<Executor>::kOnHost) {
      Contact<R> none{};
      invalidate(none);
      Memory<Executor>::fill(contacts_.data() + slot, contacts_.size() - slot, none);
    }
  }

  static constexpr int kSpareSlots = 32, kSpareEntries = Memory<Executor>::kOnHost ? 4 : 32;
  std::size_t particles_;
  Array<Executor, GroupBox> boxes_;
  Array<Executor, int> entry_index_;         // of each group
  Array<Executor, AllocationCount> counts_;  // of slots, and of entries
  Array<Executor, GroupEntries> entries_;    // of groups
  Array<Executor, Contact<R>> contacts_;     // of each slot
  Array<Executor, ProximityRecord> near_;    // of each slot
  int slot_bound_ = 0;                       // upper bound of slots in use
};

}  // namespace malha
