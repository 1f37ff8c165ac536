#include "host/base/memory_size.h"

#include <cstdio>
#include <fstream>
#include <limits>

namespace malha {

std::size_t available_memory() {
  std::ifstream info("/proc/meminfo");
  std::string key, unit;
  for (std::size_t kib = 0; info >> key >> kib; std::getline(info, unit))
    if (key == "MemAvailable:") return kib * 1024;
  return std::numeric_limits<std::size_t>::max();
}

std::string in_gib(double bytes) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g GiB", bytes / (1024.0 * 1024 * 1024));
  return text;
}

}  // namespace malha
