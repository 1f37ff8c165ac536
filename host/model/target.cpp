#include "host/model/target.h"

#include <algorithm>

#include "host/base/text.h"
#include "host/error.h"

namespace malha {

namespace {

constexpr int kBlocks = 3;  // of 128 threads with the registers of Visit: so many fit on a multiprocessor

/// Numbers of NVIDIA's data sheets. Patches go down to a lane a particle, and a fifth of the constraints may cross:
/// thinner strips, of which more are worked on at once.
Target device(const char* name, const char* what, int multiprocessors, std::size_t kibibytes, double bytes_per_second) {
  return {name, what, {128, 128, 3072, 20, kMostSlots}, kibibytes * 1024, kBlocks * multiprocessors, bytes_per_second};
}

}  // namespace

PatchBounds Target::patch_bounds(Precision precision) const {
  PatchBounds own = bounds;
  const std::size_t slot = 4 * (precision == Precision::Double ? sizeof(double) : sizeof(float));
  if (fast_bytes > 0) own.slots = std::min(own.slots, static_cast<int>(fast_bytes / kBlocks / slot));
  return own;
}

const std::vector<Target>& targets() {
  static const std::vector<Target> all{{"cpu", "the cores of a CPU, and their caches", {}},
                                       device("a100", "NVIDIA A100 of 80 GB", 108, 163, 2.04e12),
                                       device("h100", "NVIDIA H100 SXM", 132, 227, 3.35e12),
                                       device("h200", "NVIDIA H200", 132, 227, 4.8e12)};
  return all;
}

const Target& target_named(const std::string& name) {
  const auto found = std::find_if(targets().begin(), targets().end(), [&](const Target& t) { return t.name == name; });
  if (found != targets().end()) return *found;
  std::string names;
  for (const Target& target : targets()) names += (names.empty() ? "" : ", ") + target.name;
  refuse("target", "", quoted(name), names);
}

}  // namespace malha
