// SPDX-License-Identifier: Apache-2.0
// The numbers that vertices have in their file, for what speaks to a person.
#pragma once
#include "malha/mesh.h"

namespace malha {

/// The point that each vertex of a mesh of so many points became: those of the file first (-1: nothing uses it), then
/// the points that tearing added.
std::vector<int> points_of_vertices(const FileVertices& file, int points);

/// The vertex that became this point; of those that were merged the lowest.
int vertex_of(const FileVertices& file, int point);

}  // namespace malha
