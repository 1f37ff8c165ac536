// SPDX-License-Identifier: Apache-2.0
// The rest mesh of a body whose rest shape is not that of its start.
#pragma once
#include <optional>

#include "malha/scene.h"

namespace malha {

/// Reads the rest shape of scene.bodies[index] and fits it to its mesh, in the form of RestShape
/// (host/mesh/rest_shape.h); none if the scene names none. `as_read` is the mesh before welding and checks. Throws
/// InputError, also for faces, lines and tetrahedra without size at rest.
std::optional<Mesh> load_rest(const Scene& scene, std::size_t index, const Mesh& as_read, const Mesh& mesh);

}  // namespace malha
