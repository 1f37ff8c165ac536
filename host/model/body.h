// SPDX-License-Identifier: Apache-2.0
// A body before it is part of a model: its mesh, read or made, with what hangs on it. And the shapes of the
// environment.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/model/tear.h"

namespace malha {

/// A body's mesh with what hangs on it, in the body's own numbering.
struct Body {
  Mesh mesh;
  std::vector<Edge> edges;
  Holds holds;
  std::vector<double> mass;
};

/// Where a body's or environment's shape is written, for messages: the mesh file, or the scene.
std::string origin(const Scene& scene, const Shape& shape);

/// The place of `key` of the index-th thing in one of the scene's lists: "/bodies/2/shape".
std::string pointer(const char* list, std::size_t index, const char* key);

/// The scene's body `index`: its mesh loaded or made, welded, checked and placed. Adds to the faces without area and to
/// what a person should know of it. Throws InputError.
Mesh load_body(const Scene& scene, std::size_t index, int& zero_area_faces, std::vector<std::string>& notes);

/// The mesh with its pins, masses (kg) and edges, split as far as it is torn. Throws InputError.
Body make_body(const Scene& scene, std::size_t index, Mesh mesh, const Torn* torn);

/// The scene's environment object `index`, likewise. Throws InputError.
EnvironmentMesh load_environment(const Scene& scene, std::size_t index, int& zero_area_faces);

}  // namespace malha
