// Which particles of a body do not move.
#pragma once
#include <vector>

#include "host/scene.h"

namespace malha {

/// One flag a particle of `mesh`, the placed mesh of scene.bodies[body]. Throws InputError for a pin that finds no
/// particle, does not fit the shape, or leaves nothing to move.
std::vector<bool> pinned_particles(const Scene& scene, std::size_t body, const Mesh& mesh);

}  // namespace malha
