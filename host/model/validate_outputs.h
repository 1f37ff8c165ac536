// SPDX-License-Identifier: Apache-2.0
// Checks that expectations and outputs fit the scene.
#pragma once
#include "malha/scene.h"

namespace malha {

/// Whether an object of the environment names "edges".
bool names_edges(const Scene& scene);

/// An expectation about something that the scene does not have would always be met. `tetrahedra`: its meshes have any.
/// Throws InputError.
void check_expectations(const Scene& scene, bool tetrahedra);

/// A mesh that changes has no place in a format that writes it once. Throws InputError.
void check_outputs(const Scene& scene);

}  // namespace malha
