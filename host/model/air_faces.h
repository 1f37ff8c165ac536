// SPDX-License-Identifier: Apache-2.0
// Faces on which the air acts, and the incident faces of each particle.
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha {

struct AirFaces {
  std::vector<Quad> faces;
  std::vector<int> particle;  // particles with a face, including pinned ones, which may be released
  // The faces of particle[k] are incident[begin[k]] .. incident[begin[k + 1] - 1].
  std::vector<int> begin, incident;
};

/// Adds the faces of a mesh whose point i is the particle solver_index[i].
void add_air_faces(const Mesh& mesh, const std::vector<int>& solver_index, AirFaces& all);

}  // namespace malha
