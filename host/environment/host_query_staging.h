// SPDX-License-Identifier: Apache-2.0
// The particles of a device that the host asks Embree about in a substep: they come in one piece, words of them with
// all that is known of them, and go back so. The host touches nothing else of theirs for that.
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

  /// Calls look(surroundings, cargo), both in the host's memory, of what is asked about: so much. There is room at
  /// every mesh for all of it. What go_on(questions) launches before that must leave those particles, and the meshes,
  /// as they are.
  template <class Query, class GoOn>
  void ask(const EnvironmentView<R>& all, const ActiveMask& questions, const ActiveCount& asked, const Query& look,
           const GoOn& go_on) {
    const StagingBuffer<R> there = hold(all, questions, asked);
    load(all, questions, there);
    StagingBuffer<R> here = there;
    here.base = aligned(here_.data());
    Memory<Executor>::copy_out(there.base, there.bytes(), here.base);
    go_on(questions);
    std::vector<ContactCacheView<R>> nearby;
    for (int k = 0; k < all.count; ++k) nearby.push_back(here.nearby(k));
    look(EnvironmentView<R>{all.meshes, all.count, here.particles(), nearby.data()}, here);
    Memory<Executor>::copy_in(here.base, here.bytes(), there.base);
    unload(all, there);
  }

  std::size_t bytes() const { return there_.bytes(); }

 private:
  /// In the device's memory, with as much of the host's.
  StagingBuffer<R> hold(const EnvironmentView<R>& all, const ActiveMask& questions, const ActiveCount& asked) {
    StagingBuffer<R> cargo{nullptr, asked.words, all.count, questions.count, 2 * asked.particles};
    const std::size_t bytes = cargo.bytes() + StagingBuffer<R>::kAligned;
    if (bytes > there_.size()) {
      there_ = {};
      there_ = Array<Executor, char>(bytes + bytes / 4);
      here_.resize(there_.size());
    }
    cargo.base = aligned(there_.data());
    return cargo;
  }
  void load(const EnvironmentView<R>& all, const ActiveMask& questions, const StagingBuffer<R>& to) {
    Memory<Executor>::fill(to.chosen(), 1, 0);
    parallel_for(executor_, questions.words, ListActiveGroups{questions, to.chosen(), to.which()});
    parallel_for(executor_, to.count(), PackParticles<R>{questions, all.particles, to});
    for (int k = 0; k < all.count; ++k) {
      Memory<Executor>::fill(to.nearby(k).slots, 2, AllocationCount{});
      parallel_for(executor_, to.count(),
                   PackCache<R>{questions, all.particles, all.meshes[k].before, all.nearby[k], to, k});
    }
  }
  void unload(const EnvironmentView<R>& all, const StagingBuffer<R>& from) {
    parallel_for(executor_, from.count(), UnpackParticles<R>{all.particles, from});
    for (int k = 0; k < all.count; ++k) {
      parallel_for(executor_, from.words, AllocateUnpackedEntries<R>{all.particles, all.meshes[k].before, all.nearby[k], from, k});
      parallel_for(executor_, from.count(), UnpackCache<R>{all.nearby[k], from, k});
    }
  }
  static char* aligned(char* data) {
    constexpr std::uintptr_t line = StagingBuffer<R>::kAligned;
    return data + (line - reinterpret_cast<std::uintptr_t>(data) % line) % line;
  }

  Executor executor_;
  Array<Executor, char> there_;
  std::vector<char> here_;
};

}  // namespace malha
