// SPDX-License-Identifier: Apache-2.0
// Machines for which a model is laid out: the fast memory of their cores or multiprocessors bounds the size of patches.
// Runs for the same machine have the same bits on every backend.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/model/ordering/patches.h"
#include "malha/scene.h"

namespace malha {

/// Size of a coordinate in memory.
constexpr int bytes_of_number(Precision precision) {
  return precision == Precision::Double ? sizeof(double) : sizeof(float);
}

struct Machine {
  std::string name;
  std::string what;             // description for the user
  PatchBounds bounds;           // without the bound by fast memory
  std::size_t fast_bytes = 0;   // shared memory of a multiprocessor; 0: caches, which set no bound
  int multiprocessors = 0;      // 0: a CPU
  double bytes_per_second = 0;  // memory bandwidth; 0: unknown

  /// Number of patches that are solved at the same time; 0: as many as there are threads.
  int groups(Precision precision) const;
  /// Bounds of patches in this precision, including the bound by fast memory.
  PatchBounds patch_bounds(Precision precision) const;
};

/// All known machines. The first, "cpu", is the default.
const std::vector<Machine>& machines();
std::vector<std::string> machine_names();

/// The machine of this name. Throws InputError for an unknown name.
const Machine& machine_named(const std::string& name);

}  // namespace malha
