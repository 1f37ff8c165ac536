#include "host/base/memory_size.h"

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
  if (!(limit >> most) || !(now >> used)) return std::numeric_limits<std::size_t>::max();  // "max": none
  return most > used ? most - used : 0;
}

}  // namespace

std::size_t available_memory() {
  std::ifstream info("/proc/meminfo");
  std::string key, unit;
  for (std::size_t kib = 0; info >> key >> kib; std::getline(info, unit))
    if (key == "MemAvailable:") return std::min(kib * 1024, left_in_group());
  return left_in_group();
}

std::string in_gib(double bytes) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g GiB", bytes / (1024.0 * 1024 * 1024));
  return text;
}

}  // namespace malha
