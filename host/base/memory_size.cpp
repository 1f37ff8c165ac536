// SPDX-License-Identifier: Apache-2.0
#include "host/base/memory_size.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>

namespace malha {

namespace {

/// Bytes that a control group of Linux (version 2) still allows.
std::size_t left_in_group() {
  std::size_t most = 0, used = 0;
  std::ifstream limit("/sys/fs/cgroup/memory.max"), now("/sys/fs/cgroup/memory.current");
  // The first file says "max" where there is no limit.
  if (!(limit >> most) || !(now >> used)) return std::numeric_limits<std::size_t>::max();
  return most > used ? most - used : 0;
}

/// Bytes that `ulimit -v` still allows.
std::size_t left_of_addresses() {
  rlimit limit{};
  std::size_t pages = 0;
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ||
      !(std::ifstream("/proc/self/statm") >> pages))
    return std::numeric_limits<std::size_t>::max();
  const std::size_t used = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur > used ? limit.rlim_cur - used : 0;
}

}  // namespace

std::size_t available_memory() {
  const std::size_t allowed = std::min(left_in_group(), left_of_addresses());
  std::ifstream info("/proc/meminfo");
  std::string key, unit;
  for (std::size_t kib = 0; info >> key >> kib; std::getline(info, unit))
    if (key == "MemAvailable:") return std::min(kib * 1024, allowed);
  return allowed;
}

std::string in_gib(double bytes) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g GiB", bytes / (1024.0 * 1024 * 1024));
  return text;
}

}  // namespace malha
