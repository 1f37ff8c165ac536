// SPDX-License-Identifier: Apache-2.0
// Bodies before they become part of a model: the mesh, which is read or generated, boundary conditions, edges and
// masses; and the meshes of the environment.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/mesh/rest_shape.h"
#include "host/model/model.h"
#include "host/model/tear.h"

namespace malha {

/// Factors of a constraint's stiffness and of its parameter at each particle; empty: without a map.
struct ConstraintMaps {
  std::vector<double> stiffness, parameter;
};

/// A body in its own numbering of particles.
struct Body {
  Mesh mesh;
  std::optional<Mesh> rest;  // see RestShape; none: the body is at rest where it starts
  std::vector<Edge> edges;
  BoundaryConditions boundary;
  std::vector<double> mass;                         // kg, of each particle
  std::vector<double> friction_map, thickness_map;  // factors at each particle; empty: without a map
  std::vector<ConstraintMaps> maps;                 // of each constraint of the scene
  RestShape shape() const { return {mesh, rest ? &*rest : nullptr}; }
};

/// The place of each particle in the rest mesh of a body. Null if it has none, if a particle has several, and if it is
/// a pattern of texture coordinates, in which pieces may lie over each other: then the start stands for it where a
/// place of each is needed, as in volumes and in distances between parts of the body.
const std::vector<Vec3>* places_at_rest(const BodySpec& spec, const Body& body);

/// The file that defines a shape, for messages: the mesh file, or the scene.
std::string origin(const Scene& scene, const Shape& shape);

/// The JSON pointer of a key of an item of a list of the scene, such as "/bodies/2/shape".
std::string pointer(const char* list, std::size_t index, const char* key);

struct BodyMeshes {
  Mesh mesh;
  std::optional<Mesh> rest;
};

/// Reads or generates the mesh of scene.bodies[index], welds and checks it, and applies the transform; and its rest
/// mesh. Adds the number of faces without area to `zero_area_faces`, and lines for the user to `notes`. Throws
/// InputError.
BodyMeshes load_body(const Scene& scene, std::size_t index, int& zero_area_faces, std::vector<std::string>& notes);

/// Builds scene.bodies[index] from its meshes: boundary conditions, edges and masses, after the splits of `torn`, which
/// may be null. Throws InputError.
Body make_body(const Scene& scene, std::size_t index, BodyMeshes meshes, const TearState* torn);

/// Reads or generates, welds, checks and transforms the mesh of scene.environment[index]; that of an exact shape stays
/// empty. Throws InputError.
EnvironmentMesh load_environment(const Scene& scene, std::size_t index, int& zero_area_faces);

}  // namespace malha
