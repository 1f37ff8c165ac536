// SPDX-License-Identifier: Apache-2.0
// Thread affinity for measurements: each OpenMP thread stays on its core.
#pragma once

namespace malha::bench {

/// During its lifetime each thread of OpenMP regions of `threads` threads is bound to its own core. Two threads on one
/// core would wait for each other at every barrier, and a system under load leaves them there. OMP_PROC_BIND would
/// bind them as well, but keep all threads of OpenBLAS on one core. It does nothing for one thread, or for more threads
/// than there are cores.
class Pinned {
 public:
  explicit Pinned(int threads);
  ~Pinned();
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

 private:
  int threads_;  // 0: affinities were left alone
};

}  // namespace malha::bench
