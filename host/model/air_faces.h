// SPDX-License-Identifier: Apache-2.0
// The faces that the air acts on, and those round each particle.
#pragma once
#include <vector>

#include "malha/mesh.h"

namespace malha {

struct AirFaces {
  std::vector<Quad> faces;
  std::vector<int> particle;       // with a face; pinned ones too, that may be let go
  std::vector<int> begin, around;  // the faces of item k are around[begin[k]] .. around[begin[k + 1] - 1]
};

/// Adds those of a mesh. Particle i of it becomes name[i].
void add_air_faces(const Mesh& mesh, const std::vector<int>& name, AirFaces& all);

}  // namespace malha
