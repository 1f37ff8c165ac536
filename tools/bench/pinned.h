// SPDX-License-Identifier: Apache-2.0
// Threads that stay where they are.
#pragma once

namespace malha::bench {

/// As long as it lives, each thread of OpenMP's regions of so many threads stays on a core of its own. Two that share
/// one wait for each other's turns at every barrier, and systems under load leave them there. OMP_PROC_BIND would do
/// the same, but keep all of OpenBLAS's threads on one core. Does nothing for one thread, or more than there are cores.
class Pinned {
 public:
  explicit Pinned(int threads);
  ~Pinned();
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

 private:
  int threads_;  // 0: nothing was done
};

}  // namespace malha::bench
