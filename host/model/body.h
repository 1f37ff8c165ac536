// SPDX-License-Identifier: Apache-2.0
// Bodies before they become part of a model: the mesh, which is read or generated, boundary conditions, edges and
// masses; and the meshes of the environment.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "host/model/tear.h"

namespace malha {

/// A body in its own numbering of particles.
struct Body {
  Mesh mesh;
  std::vector<Edge> edges;
  BoundaryConditions boundary;
  std::vector<double> mass;  // kg, of each particle
};

/// The file that defines a shape, for messages: the mesh file, or the scene.
std::string origin(const Scene& scene, const Shape& shape);

/// The JSON pointer of a key of an item of a list of the scene, such as "/bodies/2/shape".
std::string pointer(const char* list, std::size_t index, const char* key);

/// Reads or generates the mesh of scene.bodies[index], welds and checks it, and applies the transform. Adds the number
/// of faces without area to `zero_area_faces`, and lines for the user to `notes`. Throws InputError.
Mesh load_body(const Scene& scene, std::size_t index, int& zero_area_faces, std::vector<std::string>& notes);

/// Builds scene.bodies[index] from its mesh: boundary conditions, edges and masses, after the splits of `torn`, which
/// may be null. Throws InputError.
Body make_body(const Scene& scene, std::size_t index, Mesh mesh, const TearState* torn);

/// Reads or generates, welds, checks and transforms the mesh of scene.environment[index]; that of an exact shape stays
/// empty. Throws InputError.
EnvironmentMesh load_environment(const Scene& scene, std::size_t index, int& zero_area_faces);

}  // namespace malha
