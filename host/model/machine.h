// SPDX-License-Identifier: Apache-2.0
// Which machine a model is laid out for. Patches are what it works on at once, so their size belongs to it. Runs for
// one machine have the same bits on every backend.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/model/ordering/patches.h"
#include "malha/scene.h"

namespace malha {

/// Of a coordinate.
constexpr int bytes_of_number(Precision precision) {
  return precision == Precision::Double ? sizeof(double) : sizeof(float);
}

struct Machine {
  std::string name;
  std::string what;             // for people
  PatchBounds bounds;           // but for what fast memory holds
  std::size_t fast_bytes = 0;   // that the lanes of a group share; 0: caches, which have no bound
  int multiprocessors = 0;      // of a device
  double bytes_per_second = 0;  // of its memory; 0: not known

  /// Worked on at once; 0: as many as there are threads.
  int groups(Precision precision) const;
  /// Of patches in this precision.
  PatchBounds patch_bounds(Precision precision) const;
};

/// The first, "cpu", is what a model is laid out for if nothing else is said.
const std::vector<Machine>& machines();
const std::vector<std::string>& machine_names();

/// Throws InputError for a name that is not among them.
const Machine& machine_named(const std::string& name);

}  // namespace malha
