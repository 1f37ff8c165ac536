// SPDX-License-Identifier: Apache-2.0
#include "host/model/body.h"

#include "host/animation/animation.h"
#include "host/mesh/check_mesh.h"
#include "host/mesh/generate.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/topology.h"
#include "host/mesh/weld.h"
#include "host/model/body_rest.h"
#include "host/model/self_surface.h"
#include "host/model/vertex_map.h"
#include "kernels/constraints/constraint_registry.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

std::string origin(const Scene& scene, const Shape& shape) {
  const auto* file = std::get_if<MeshFile>(&shape);
  return file ? file->path : scene.file;
}

const std::vector<Vec3>* places_at_rest(const BodySpec& spec, const Body& body) {
  const bool in_space = body.rest && !std::holds_alternative<RestUv>(*spec.rest) && !body.shape().has_seams();
  return in_space ? &body.rest->points : nullptr;
}

std::string pointer(const char* list, std::size_t index, const char* key) {
  return "/" + std::string(list) + "/" + std::to_string(index) + "/" + key;
}

BodyMeshes load_body(const Scene& scene, std::size_t index, int& zero_area_faces, std::vector<std::string>& notes) {
  const BodySpec& spec = scene.bodies[index];
  Mesh mesh = make_mesh(spec.shape);
  const Mesh as_read = spec.rest ? mesh : Mesh{};
  const std::string body = "body '" + spec.name + "': ";
  const std::string numbers = std::string("; pins, messages and frames keep the ") +
                              (std::holds_alternative<MeshDataShape>(spec.shape) ? "list" : "file") + "'s numbers";
  if (const auto* file = std::get_if<MeshFile>(&spec.shape)) {
    if (file->weld || is_gltf_file(file->path)) {
      const auto [merged, removed] = weld(mesh, file->weld.value_or(0), file->path);
      if (merged > 0)
        notes.push_back(body + "welded " + counted(merged, "vertex", "vertices") + " to others" +
                        (removed > 0 ? ", which removed " + counted(removed, "face or line", "faces or lines") : "") +
                        numbers);
    }
  }
  const bool loose = is_loose(spec.shape);
  if (const bool given =
          std::holds_alternative<MeshFile>(spec.shape) || std::holds_alternative<MeshDataShape>(spec.shape);
      given && !loose)
    if (const int unused = drop_unused_points(mesh); unused > 0)
      notes.push_back(body + "left out " + counted(unused, "vertex", "vertices") + " of no face, line or tetrahedron" +
                      numbers);
  zero_area_faces += check_mesh(mesh, origin(scene, spec.shape), loose);
  std::optional<Mesh> rest = load_rest(scene, index, as_read, mesh);
  apply(spec.transform, mesh);
  return {std::move(mesh), std::move(rest)};
}

namespace {

ConstraintMaps maps_of(const Scene& scene, std::size_t body, const Mesh& mesh, const ConstraintSpec& spec,
                       const std::string& place) {
  ConstraintMaps maps;
  if (spec.map) maps.stiffness = factors_at_points(scene, body, mesh, *spec.map, place + "/map");
  if (spec.parameter_map)
    with_kind(spec.type, [&]<class Kind>(Kind) {
      maps.parameter = parameter_factors_at_points(scene, body, mesh, *spec.parameter_map, Kind::parameter,
                                                   spec.parameter, place + "/" + Kind::parameter.name + "_map");
    });
  return maps;
}

}  // namespace

Body make_body(const Scene& scene, std::size_t index, BodyMeshes meshes, const TearState* torn) {
  const BodySpec& spec = scene.bodies[index];
  Body body;
  body.mesh = std::move(meshes.mesh), body.rest = std::move(meshes.rest);
  body.boundary = find_boundary_conditions(scene, index, body.mesh);
  if (can_tear(scene) && !body.mesh.tetrahedra.empty())
    refuse(scene.file, pointer("bodies", index, "shape"), "tetrahedra in a scene with a body that tears",
           "bodies of faces and lines there");
  if (!spec.material.empty() && (!body.mesh.tetrahedra.empty() || body.mesh.faces.empty()))
    refuse(scene.file, pointer("bodies", index, "material"), "a fabric of a body without faces, or with tetrahedra",
           "a fabric of a surface");
  const auto factors = [&](const std::optional<VertexMap>& map, const char* key, const FactorRange& range = {}) {
    return map ? factors_at_points(scene, index, body.mesh, *map, pointer("bodies", index, key), range)
               : std::vector<double>{};
  };
  std::vector<double> density_map = factors(spec.density_map, "density_map");
  body.friction_map = factors(spec.friction_map, "friction_map", {.zero_allowed = true});
  if (spec.thickness_map && !self_collides(scene, spec.name))
    refuse(scene.file, pointer("bodies", index, "thickness_map"), "'thickness_map' of a body without self-collision",
           "one in a scene whose 'self_collision' has the body");
  body.thickness_map = factors(spec.thickness_map, "thickness_map", {.most = 1});
  for (std::size_t c = 0; c < spec.constraints.size(); ++c)
    body.maps.push_back(maps_of(scene, index, body.mesh, spec.constraints[c],
                                pointer("bodies", index, "constraints/") + std::to_string(c)));
  if (torn)
    for (const Split& split : *torn->splits)
      if (split.body == static_cast<int>(index)) {
        const auto vertex = static_cast<std::size_t>(split.vertex);
        const auto duplicate = [vertex](std::vector<double>& map) {
          if (!map.empty()) map.push_back(double{map[vertex]});
        };
        for (ConstraintMaps& maps : body.maps) duplicate(maps.stiffness), duplicate(maps.parameter);
        duplicate(density_map), duplicate(body.friction_map), duplicate(body.thickness_map);
        if (body.rest && !body.shape().has_seams()) apply(split, *body.rest);  // otherwise corners keep their places
        apply(split, body.mesh), split_boundary_conditions(split.vertex, body.boundary);
      }
  body.edges = edges(body.mesh);
  const Mesh& at_rest = body.rest ? *body.rest : body.mesh;
  body.mass = spec.mass ? masses_by_total(body.mesh, *spec.mass, at_rest)
                        : masses_by_density(body.mesh, *spec.density, at_rest);
  if (!density_map.empty()) {
    double total = 0, mapped = 0;
    for (std::size_t i = 0; i < density_map.size(); ++i)
      total += body.mass[i], body.mass[i] *= density_map[i], mapped += body.mass[i];
    for (double& mass : body.mass) mass *= spec.mass ? total / mapped : 1;  // whose sum stays
  }
  for (std::size_t i = 0; i < body.mass.size(); ++i)
    if (!(body.mass[i] > 0))
      refuse(scene.file, pointer("bodies", index, spec.mass ? "mass" : "density"),
             "no mass for particle " + std::to_string(vertex_of(body.mesh.vertices, static_cast<int>(i))),
             "a mass or density that leaves no particle massless");
  return body;
}

EnvironmentMesh load_environment(const Scene& scene, std::size_t e, int& zero_area_faces) {
  const EnvironmentSpec& spec = scene.environment[e];
  if (is_exact(spec.shape)) return {spec, {}, {}};
  const std::string file = origin(scene, spec.shape);
  EnvironmentMesh mesh{spec, make_mesh(spec.shape), {}};
  // The vertices of the environment are not particles: equal positions may be merged, and unused vertices may stay.
  if (const auto* of = std::get_if<MeshFile>(&spec.shape)) weld(mesh.mesh, of->weld.value_or(0), file);
  if (spec.animation && !spec.animation->from_code) mesh.animation = load_animation(scene, e, mesh.mesh);
  apply(spec.transform, mesh.mesh);
  if (mesh.animation) mesh.animation->sample(0, mesh.mesh.points);
  zero_area_faces += check_mesh(mesh.mesh, file, true);
  if (mesh.mesh.faces.empty())
    refuse(scene.file, pointer("environment", e, "shape"), "a shape without faces", "a shape with faces");
  if (spec.sides == Sides::Solid)
    require_closed(mesh.mesh, file,
                   "a solid needs a closed mesh (object '" + spec.name + "'; for a sheet: \"sides\": \"two_sided\")");
  if (!spec.animation || !spec.animation->from_code) mesh.mesh.vertices = {};  // no later message names them
  return mesh;
}

}  // namespace malha
