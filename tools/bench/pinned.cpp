// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/pinned.h"

#if defined(__linux__)
#include <sched.h>
#endif

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "kernels/parallel/compute.h"

namespace malha::bench {

#if defined(__linux__)

namespace {

struct AvailableCores {
  cpu_set_t all;
  std::vector<int> cores;  // logical CPUs that the process may use, the first of each core before any second one
};

/// The affinity at the first call, which comes before any thread is bound.
const AvailableCores& available_cores() {
  static const AvailableCores now = [] {
    AvailableCores found;
    CPU_ZERO(&found.all);
    sched_getaffinity(0, sizeof found.all, &found.all);
    const auto is_second = [](int cpu) {
      std::ifstream file("/sys/devices/system/cpu/cpu" + std::to_string(cpu) + "/topology/thread_siblings_list");
      int first = cpu;
      file >> first;  // "0,64" or "0-1"
      return file && first != cpu;
    };
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
      if (CPU_ISSET(cpu, &found.all)) found.cores.push_back(cpu);
    std::stable_partition(found.cores.begin(), found.cores.end(), [&](int cpu) { return !is_second(cpu); });
    return found;
  }();
  return now;
}

/// Sets the affinity of the thread that runs a group.
struct SetAffinity {
  const cpu_set_t* sets;
  template <class Group>
  KERNEL void operator()(const Group& group) const {
    sched_setaffinity(0, sizeof(cpu_set_t), &sets[group.index]);
  }
};

void set_affinity(const std::vector<cpu_set_t>& sets) {
  const auto threads = static_cast<int>(sets.size());
  const OpenMP executor{threads};
  parallel_region(executor, threads,
                  [&](const auto& team) { parallel_groups(team, 0, threads, {}, SetAffinity{sets.data()}); });
}

}  // namespace

Pinned::Pinned(int threads) : threads_(0) {
  const AvailableCores& now = available_cores();
  if (threads < 2 || threads > static_cast<int>(now.cores.size())) return;
  threads_ = threads;
  std::vector<cpu_set_t> sets(threads);
  for (int t = 0; t < threads; ++t) {
    CPU_ZERO(&sets[t]);
    CPU_SET(now.cores[t], &sets[t]);
  }
  set_affinity(sets);
}

Pinned::~Pinned() {
  if (threads_ > 0) set_affinity(std::vector<cpu_set_t>(threads_, available_cores().all));
}

#else

Pinned::Pinned(int) : threads_(0) {}
Pinned::~Pinned() = default;

#endif

}  // namespace malha::bench
