// SPDX-License-Identifier: Apache-2.0
// The surface of bodies as it is where seams join them: what seams hold at one place is one point.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "host/mesh/rest_shape.h"
#include "host/model/body.h"

namespace malha {

struct JoinedMesh {
  Mesh mesh;                                // faces alone; each point at the start of the lowest particle at its place
  Mesh rest;                                // the rest meshes side by side, in the form of RestShape
  std::vector<std::vector<int>> particles;  // of each point, in the user's numbering, ascending
  RestShape shape() const { return {mesh, &rest}; }
};

/// Joins the faces of bodies. `place`: see places_of_particles(); `body_begin`: the first particle of each body. Faces
/// that a seam closes to a line are left out.
JoinedMesh join(const std::vector<Body>& bodies, const std::vector<std::size_t>& which, const std::vector<int>& place,
                const std::vector<int>& body_begin);

/// Throws InputError, which names the JSON pointer `here`, for a mesh that is not a closed surface oriented outwards.
/// `name`: of a particle (the user's numbering), in messages.
void require_closed(const JoinedMesh& joined, const std::string& file, const std::string& here,
                    const std::function<std::string(int)>& name);

}  // namespace malha
