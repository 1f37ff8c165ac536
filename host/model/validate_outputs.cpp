// SPDX-License-Identifier: Apache-2.0
#include "host/model/validate_outputs.h"

#include <algorithm>

#include "host/base/build_info.h"
#include "host/model/tear.h"
#include "kernels/constraints/constraint_registry.h"
#include "malha/error.h"

namespace malha {

bool names_edges(const Scene& scene) {
  return std::any_of(scene.environment.begin(), scene.environment.end(),
                     [](const EnvironmentSpec& object) { return object.edges; });
}

void check_expectations(const Scene& scene, bool tetrahedra) {
  const auto needs = [&scene](bool expected, bool present, const std::string& key, const std::string& what) {
    if (expected && !present)
      refuse(scene.file, "/expect/" + key, "an expectation about " + what, "one where there is any");
  };
  bool distance = false, pressure = false, inside = false;
  for (const BodySpec& body : scene.bodies)
    for (const ConstraintSpec& constraint : body.constraints) {
      distance = distance || constraint.type == Distance::name;
      pressure = pressure || constraint.type == "pressure";
    }
  for (const EnvironmentSpec& environment : scene.environment) inside = inside || environment.sides != Sides::TwoSided;
  const Expect& expect = scene.expect;
  needs(bool(expect.max_strain), distance, "max_strain", "strain in a scene without distance constraints");
  needs(bool(expect.rms_strain), distance, "rms_strain", "strain in a scene without distance constraints");
  needs(expect.volume_ratio.has_value(), pressure || tetrahedra, "volume_ratio",
        "volume in a scene without pressure and without tetrahedra");
  needs(bool(expect.inverted_tetrahedra), tetrahedra, "inverted_tetrahedra", "tetrahedra in a scene without any");
  needs(bool(expect.max_crossings), scene.self_collision.has_value() || names_edges(scene), "max_crossings",
        "crossings in a scene without self_collision and without objects that name \"edges\"");
  needs(bool(expect.max_penetration), inside, "max_penetration",
        "penetration in a scene without solids or one-sided sheets");
}

void check_outputs(const Scene& scene) {
  const std::string key = "/outputs/frames/formats";
  for (const std::string& format : scene.outputs.formats) {
    if (can_tear(scene) && (format == "pc2" || format == "glb"))
      refuse(scene.file, key, format + ", which holds one mesh for all frames, of a scene that tears", "vtp, ply, obj");
    if (format == "glb" && !has_gltf())
      refuse(scene.file, key, "glb, and this malha was built without tinygltf (Debian: libtinygltf-dev)",
             "vtp, pc2, ply, obj");
  }
}

}  // namespace malha
