// SPDX-License-Identifier: Apache-2.0
#include "host/model/machine.h"

#include <algorithm>

#include "host/base/spelling_suggestion.h"
#include "kernels/projection/patch_memory.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

// Blocks of 128 threads that fit into the registers of a multiprocessor: SolvePatch needs 168 registers per thread in
// float and 255 in double.
constexpr int blocks_at_once(Precision precision) { return precision == Precision::Double ? 2 : 3; }
constexpr std::size_t kOfBlock = 1024;     // bytes of shared memory that CUDA reserves for each block
constexpr std::size_t kBesideSlots = 192;  // bytes of a patch's memory that are not slots

/// Figures from NVIDIA's data sheets. Patches may be as small as one particle per lane, and a fifth of the constraints
/// may cross patches: more and thinner strips are solved at the same time.
Machine device(const char* name, const char* what, int multiprocessors, std::size_t kibibytes,
               double bytes_per_second) {
  return {name, what, {128, 128, 3072, 20}, kibibytes * 1024, multiprocessors, bytes_per_second};
}

}  // namespace

int Machine::groups(Precision precision) const { return multiprocessors * blocks_at_once(precision); }

PatchBounds Machine::patch_bounds(Precision precision) const {
  PatchBounds result = bounds;
  if (fast_bytes == 0) return result;
  const auto slot = static_cast<std::size_t>(kNumbersPerParticle * bytes_of_number(precision));
  result.slots =
      static_cast<int>(((fast_bytes + kOfBlock) / blocks_at_once(precision) - kOfBlock - kBesideSlots) / slot);
  return result;
}

const std::vector<Machine>& machines() {
  static const std::vector<Machine> all{{"cpu", "the cores of a CPU, and their caches", {}},
                                        device("a100", "NVIDIA A100 of 80 GB", 108, 163, 2.04e12),
                                        device("h100", "NVIDIA H100 SXM", 132, 227, 3.35e12),
                                        device("h200", "NVIDIA H200", 132, 227, 4.8e12)};
  return all;
}

std::vector<std::string> machine_names() {
  std::vector<std::string> names;
  for (const Machine& machine : machines()) names.push_back(machine.name);
  return names;
}

const Machine& machine_named(const std::string& name) {
  const auto found = std::ranges::find(machines(), name, &Machine::name);
  if (found == machines().end()) refuse("machine", "", quoted(name), join(machine_names()));
  return *found;
}

}  // namespace malha
