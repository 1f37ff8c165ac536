// SPDX-License-Identifier: Apache-2.0
// Map between the points of a mesh and the vertices of its file, for messages and frames.
#pragma once
#include "malha/mesh.h"

namespace malha {

/// The point of each vertex of a mesh with this number of points: the vertices of the file (-1: unused), then the
/// points that tearing added.
std::vector<int> points_of_vertices(const FileVertices& file, int points);

/// The vertex of a point; the lowest one if several were merged.
int vertex_of(const FileVertices& file, int point);

}  // namespace malha
