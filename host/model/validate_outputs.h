// SPDX-License-Identifier: Apache-2.0
// Checks that expectations and outputs fit the scene.
#pragma once
#include "malha/scene.h"

namespace malha {

/// True if an object of the environment has "edges".
bool names_edges(const Scene& scene);

/// Throws InputError for an expectation about something that the scene does not have, since it would always be met.
/// `tetrahedra`: whether its meshes have any.
void check_expectations(const Scene& scene, bool tetrahedra);

/// Throws InputError for a scene that may tear with a format that stores a single mesh for all frames, and for a format
/// that this build does not support.
void check_outputs(const Scene& scene);

}  // namespace malha
