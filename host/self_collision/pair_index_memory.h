// SPDX-License-Identifier: Apache-2.0
// Memory for the index maps of the broad phase (kernels/self_collision/contact_packing.h): one for each thread on the
// host, one for each cluster on a device.
#pragma once
#include <type_traits>

#include "host/base/array.h"
#include "kernels/self_collision/broad_phase_cooperative.h"

namespace malha {

template <class Executor>
class PairIndexMemory {
  static constexpr bool kOnHost = Memory<Executor>::kOnHost;

 public:
  using IndexMap = std::conditional_t<kOnHost, DirectIndexMap, HashIndexMap>;
  template <class R>
  using Find = std::conditional_t<kOnHost, FindCandidates<R>, FindCandidatesCooperatively<R>>;

  /// Allocates for this many particles in all, and `listed` in the lists of all clusters together.
  void reserve(int particles, int threads, std::size_t listed) {
    if constexpr (!kOnHost) {
      if (open_blocks_.size() == listed) return;
      table_ = {}, open_blocks_ = {};
      table_ = Array<Executor, int>(HashIndexMap::kEntries * listed),
      open_blocks_ = Array<Executor, OpenBlocks>(listed);
    } else {
      particles_ = particles, bytes_ = DirectIndexMap::bytes(particles);
      if (memory_.size() >= bytes_ * threads) return;
      memory_ = {};
      memory_ = Array<Executor, char>(bytes_ * threads);
      for (int t = 0; t < threads; ++t) {
        int* const index = DirectIndexMap{particles}.of(memory_.data() + bytes_ * t).index;
        Memory<Executor>::fill(index, std::size_t(particles) + 1, -1);
      }
    }
  }

  IndexMap index_map() const {
    if constexpr (kOnHost)
      return {particles_};
    else
      return {table_.data(), open_blocks_.data()};
  }
  template <class R>
  ScratchMemory memory() const {
    if constexpr (kOnHost)
      return {memory_.data(), bytes_};
    else
      return {nullptr, FindCandidatesCooperatively<R>::kBytes};
  }

  /// Bytes that are written to: of the masks of open blocks only those of the few particles with pairs.
  std::size_t bytes() const {
    if (!kOnHost) return table_.bytes() + open_blocks_.bytes();
    return bytes_ > 0 ? memory_.size() / bytes_ * 2 * sizeof(int) * particles_ : 0;
  }

 private:
  int particles_ = 0;
  std::size_t bytes_ = 0;
  Array<Executor, char> memory_;  // of each thread
  Array<Executor, int> table_;
  Array<Executor, OpenBlocks> open_blocks_;
};

}  // namespace malha
