// SPDX-License-Identifier: Apache-2.0
// Memory estimate of a model, and release of set-up data.
#pragma once
#include <cstddef>

#include "host/model/model.h"

namespace malha {

/// Of the model's arrays.
std::size_t bytes(const Model& model);

/// What setting up the shapes that the scene makes takes at the least, in bytes: measured with a million particles
/// each, and rounded down. Meshes from files are not counted.
double least_bytes(const Scene& scene);

/// Throws OutOfMemory where that is more than is free: how much it is, and how much there is.
void require_memory(const Scene& scene);

/// Gives back what only solvers read while they are made (masses, velocities), and what the arrays that stay have grown
/// beyond their elements. Patches stay, a byte a particle: looks (host/fields/fields.h) tell the layout from them.
void release_setup_memory(Model& model);

}  // namespace malha
