// SPDX-License-Identifier: Apache-2.0
// Memory in which searches for pairs list the particles of a unit: on the host of each thread, on a device of each
// unit.
#pragma once
#include <type_traits>

#include "host/base/array.h"
#include "kernels/self_collision/broad_phase_cooperative.h"

namespace malha {

template <class Executor>
class SearchPlaces {
  static constexpr bool kOnHost = Memory<Executor>::kOnHost;

 public:
  using Places = std::conditional_t<kOnHost, DirectIndexMap, HashIndexMap>;
  template <class R>
  using Find = std::conditional_t<kOnHost, FindCandidates<R>, FindPairsTogether<R>>;

  /// For so many particles in all, and for `listed` in the lists of all units together.
  void make_room(int particles, int threads, std::size_t listed) {
    if constexpr (!kOnHost) {
      if (taken_.size() == listed) return;
      table_ = {}, taken_ = {};
      table_ = Array<Executor, int>(HashIndexMap::kEntries * listed), taken_ = Array<Executor, OpenBlocks>(listed);
    } else {
      particles_ = particles, bytes_ = DirectIndexMap::bytes(particles);
      if (memory_.size() >= bytes_ * threads) return;
      memory_ = {};
      memory_ = Array<Executor, char>(bytes_ * threads);
      for (int t = 0; t < threads; ++t) {
        int* const place = DirectIndexMap{particles}.of(memory_.data() + bytes_ * t).place;
        Memory<Executor>::fill(place, std::size_t(particles) + 1, -1);
      }
    }
  }

  Places places() const {
    if constexpr (kOnHost)
      return {particles_};
    else
      return {table_.data(), taken_.data()};
  }
  template <class R>
  ScratchMemory memory() const {
    if constexpr (kOnHost)
      return {memory_.data(), bytes_};
    else
      return {nullptr, FindPairsTogether<R>::kBytes};
  }

  /// What is touched: of the masks of open blocks only those of the few particles that a unit meets.
  std::size_t bytes() const {
    if (!kOnHost) return table_.bytes() + taken_.bytes();
    return bytes_ > 0 ? memory_.size() / bytes_ * 2 * sizeof(int) * particles_ : 0;
  }

 private:
  int particles_ = 0;
  std::size_t bytes_ = 0;
  Array<Executor, char> memory_;  // of each thread
  Array<Executor, int> table_;
  Array<Executor, OpenBlocks> taken_;
};

}  // namespace malha
