// SPDX-License-Identifier: Apache-2.0
// The constraints of a model, and what else acts on the particles of a body together.
#pragma once
#include <vector>

#include "host/model/body.h"
#include "host/model/model.h"

namespace malha {

/// Lists what the scene's bodies name, and the air on their faces, in the solver's numbering: `solver_of` is the
/// solver's particle of each of the user's. Takes the tetrahedra out of the bodies' meshes. A torn body may have
/// nothing left for a constraint to act on. Throws InputError.
void connect(Model& model, std::vector<Body>& bodies, const std::vector<int>& solver_of, bool torn);

}  // namespace malha
