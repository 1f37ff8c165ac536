// SPDX-License-Identifier: Apache-2.0
#include "tools/study/resident.h"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <fstream>
#include <string>

namespace malha::study {

namespace {

bool peak_is_reset = false;

/// A memory size from /proc/self/status, in bytes.
std::optional<double> status(const std::string& key) {
  std::ifstream file("/proc/self/status");
  std::string word, rest;
  for (double kib = 0; file >> word; std::getline(file, rest))
    if (word == key + ":" && file >> kib) return kib * 1024;
  return std::nullopt;
}

}  // namespace

std::optional<double> resident_bytes() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
  return status("VmRSS");
}

void reset_peak() {
  std::ofstream file("/proc/self/clear_refs");
  peak_is_reset = static_cast<bool>(file << "5" << std::flush);
}

std::optional<double> peak_bytes() { return peak_is_reset ? status("VmHWM") : std::nullopt; }

}  // namespace malha::study
