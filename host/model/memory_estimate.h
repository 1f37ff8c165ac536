// SPDX-License-Identifier: Apache-2.0
// Memory estimate of a model, and release of set-up data.
#pragma once
#include <cstddef>

#include "host/model/model.h"

namespace malha {

/// Memory of the model's arrays, in bytes.
std::size_t bytes(const Model& model);

/// Throws OutOfMemory if a lower bound of the memory that the generated shapes of a scene take is more than the free
/// memory. The message says how much of either. Meshes from files are not counted.
void require_memory(const Scene& scene);

/// Releases data that are read only while a solver is built (masses, velocities), and the unused capacity of the other
/// arrays. Patches stay, a byte per particle: structure() (host/fields/fields.h) reads them.
void release_setup_memory(Model& model);

}  // namespace malha
