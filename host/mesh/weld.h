// SPDX-License-Identifier: Apache-2.0
// What real files hold and a simulation does not want: several vertices in one place, and vertices that nothing uses.
#pragma once
#include <string>

#include "malha/mesh.h"

namespace malha {

struct Welded {
  int merged = 0;  // vertices that became another one
  int gone = 0;    // faces and lines that had less than three, or two, corners left
};

/// Vertices that hang together, each within `distance` (m, >= 0; 0: in exactly its place) of the next, become the
/// lowest of them, so that kept vertices lie farther apart than that. Which do does not depend on their order. Corners
/// that fall together go, and with them faces and lines that are none any more. Near-linear time. Refuses tetrahedra
/// that would lose a corner, by `file`. mesh.vertices keeps the file's own numbers.
Welded weld(Mesh& mesh, double distance, const std::string& file);

/// Leaves out vertices of no face, line or tetrahedron, unless that are all. The others keep their order, mesh.vertices
/// the file's own numbers. Returns how many points went.
int drop_unused_points(Mesh& mesh);

}  // namespace malha
