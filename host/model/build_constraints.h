// SPDX-License-Identifier: Apache-2.0
// Building of the constraints of a model from its bodies, including pressure, long-range attachments and air.
#pragma once
#include <vector>

#include "host/model/body.h"
#include "host/model/model.h"
#include "host/model/seams.h"

namespace malha {

/// Adds the constraints of the scene's bodies, and the faces on which air acts, to the model, in the solver's
/// numbering. `solver_of` maps the user's particles to the solver's. The tetrahedra are moved from the bodies to the
/// model. With `torn` a constraint without elements is allowed. Throws InputError.
void build_constraints(Model& model, std::vector<Body>& bodies, const std::vector<Joints>& joints,
                       const std::vector<int>& solver_of, bool torn);

/// Adds the faces of a mesh whose point i is the particle solver_index[i].
void add_air_faces(const Mesh& mesh, const std::vector<int>& solver_index, AirFaces& all);

}  // namespace malha
