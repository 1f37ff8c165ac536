// SPDX-License-Identifier: Apache-2.0
// Staging of host queries: the particles of a device that the host queries with Embree in a substep are copied to the
// host with their contact caches in one block, and back. The host reads nothing else of them for that.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/base/array.h"
#include "host/environment/find_contact.h"
#include "kernels/environment/staging_buffer.h"
#include "kernels/parallel/compute.h"

namespace malha {

template <class Executor, class R>
class HostQueryStaging {
 public:
  explicit HostQueryStaging(const Executor& executor) : executor_(executor) {}

  /// Calls query(environment, masks), both in the host's memory, for the `active` particles of the masks. The caches of
  /// all meshes have the capacity for them.
  template <class Query>
  void run(const EnvironmentView<R>& all, const ActiveMask& masks, const ActiveCount& active, const Query& query) {
    const StagingBuffer<R> device_buffer = allocate(all, masks, active);
    pack(all, masks, device_buffer);
    StagingBuffer<R> host_buffer = device_buffer;
    host_buffer.base = aligned(host_memory_.data());
    Memory<Executor>::copy_out(device_buffer.base, device_buffer.bytes(), host_buffer.base);
    std::vector<ProximityCacheView<R>> caches;
    for (int k = 0; k < all.count; ++k) caches.push_back(host_buffer.cache(k));
    query(EnvironmentView<R>{all.meshes, all.count, host_buffer.particles(), caches.data()}, host_buffer.active());
    Memory<Executor>::copy_in(host_buffer.base, host_buffer.bytes(), device_buffer.base);
    unpack(all, device_buffer);
  }

  std::size_t bytes() const { return device_memory_.bytes(); }

 private:
  /// Allocates the buffer in the device's memory, and as much in the host's.
  StagingBuffer<R> allocate(const EnvironmentView<R>& all, const ActiveMask& masks, const ActiveCount& active) {
    StagingBuffer<R> buffer{nullptr, active.groups, all.count, masks.count, 2 * active.particles};
    const std::size_t bytes = buffer.bytes() + StagingBuffer<R>::kAligned;
    if (bytes > device_memory_.size()) {
      device_memory_ = {};
      device_memory_ = Array<Executor, char>(bytes + bytes / 4);
      host_memory_.resize(device_memory_.size());
    }
    buffer.base = aligned(device_memory_.data());
    return buffer;
  }
  void pack(const EnvironmentView<R>& all, const ActiveMask& masks, const StagingBuffer<R>& to) {
    Memory<Executor>::fill(to.group_count(), 1, 0);
    parallel_for(executor_, masks.groups, ListActiveGroups{masks, to.group_count(), to.group_index()});
    parallel_for(executor_, to.count(), PackParticles<R>{masks, all.particles, to});
    for (int k = 0; k < all.count; ++k) {
      Memory<Executor>::fill(to.cache(k).slot_count, 2, AllocationCount{});
      parallel_for(executor_, to.count(),
                   PackCache<R>{masks, all.particles, all.meshes[k].before, all.caches[k], to, k});
    }
  }
  void unpack(const EnvironmentView<R>& all, const StagingBuffer<R>& from) {
    parallel_for(executor_, from.count(), UnpackParticles<R>{all.particles, from});
    for (int k = 0; k < all.count; ++k) {
      parallel_for(executor_, from.groups,
                   AllocateUnpackedEntries<R>{all.particles, all.meshes[k].before, all.caches[k], from, k});
      parallel_for(executor_, from.count(), UnpackCache<R>{all.caches[k], from, k});
    }
  }
  static char* aligned(char* data) {
    constexpr std::uintptr_t line = StagingBuffer<R>::kAligned;
    return data + (line - reinterpret_cast<std::uintptr_t>(data) % line) % line;
  }

  Executor executor_;
  Array<Executor, char> device_memory_;
  std::vector<char> host_memory_;
};

}  // namespace malha
