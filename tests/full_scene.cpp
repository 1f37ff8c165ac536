// SPDX-License-Identifier: Apache-2.0
#include "tests/full_scene.h"

#include <nlohmann/json.hpp>

#include "malha/scene.h"
#include "tests/refusal.h"

namespace malha {

std::string full_scene() {
  return R"({
  "$schema": "schema.json",
  "name": "everything",
  "solver": {"type": "desbrun", "dt": 0.01, "substeps": 4, "iterations": 3, "precision": "double", "spring_constant": 500,
             "filter": "dense", "storage": "int16", "filter_external_forces": false, "corrector": "paper", "refinement_iterations": 2,
             "tolerance": 0.01, "time_budget": 0.5},
  "gravity": [0, -9.81, 0],
  "wind": {"velocity": [1, 0, 0.5], "drag": 0.01, "density": 1.2, "drag_coefficient": 1.1, "lift_coefficient": 0.9},
  "sleep": {"speed": 0.02, "after": 0.25},
  "bodies": [
    {"name": "from a file", "shape": {"mesh": "meshes/x.obj", "object": "cape", "group": "back", "weld": 1e-6}, "density": 0.2,
     "density_map": {"values": [1, 2.5]}, "friction_map": {"values": [0, 3]}, "rest": {"uv": 0.5},
     "transform": {"translate": [1, 2, 3], "rotate": {"axis": [0, 0, 2], "degrees": 90}, "scale": [1, 2, 3]},
     "velocity": [1, 2, 3], "spin": [4, 5, 6], "damping": 0.5,
     "constraints": [
       {"type": "distance", "elements": ["edges", "shear"], "stiffness": 0.5, "rest_scale": 1.1,
        "rest_scale_map": {"values": [1, 0.5]}},
       {"type": "distance_limit", "elements": ["shear"], "compliance": 1e-7, "limit": 0.2,
        "limit_map": {"values": [0, 2]}},
       {"type": "bending", "stiffness": 0.25, "rest_scale": 0},
       {"type": "pressure", "compliance": 0, "volume_ratio": 1.2, "with": ["ball"]}]},
    {"name": "sheet", "shape": {"grid": {"size": [1, 2], "cells": [16, 8]}}, "mass": 0.3,
     "thickness_map": {"values": [1, 0.5]},
     "transform": {"scale": 2},
     "pins": [
       {"row": "last"},
       {"box": {"min": [0, 0, 0], "max": [1, 0, 2]}},
       {"sphere": {"center": [1, 1, 1], "radius": 0.1}},
       {"nearest": [0, 0, 7]},
       {"rim": "all"},
       {"map": {"picture": "meshes/y.png", "channel": "green", "range": [-1, 1], "above": 0.25}},
       {"particles": [0, 16], "release_time": 1.5,
        "motion": [{"time": 0.5}, {"time": 1, "translate": [0, 1, 0], "rotate": {"axis": [0, 1, 0], "degrees": 90}}]}],
     "attachments": [
       {"at": {"row": "first"}, "to": {"environment": "planet"}, "compliance": 0.001, "release_time": 2},
       {"at": {"sphere": {"center": [1, 0, 1], "radius": 0.2}}, "to": {"point": [0, 2, 0]}, "stiffness": 0.5},
       {"at": {"rim": "all"}, "stiffness": 0.25},
       {"at": {"map": {"values": [1, 2], "above": 1}}, "stiffness": 0.25},
       {"at": {"map": {"colours": "red"}}, "stiffness": 0.25},
       {"at": {"nearest": [0, 0, 1]}, "motion": [{"time": 0}, {"time": 1, "translate": [0, 1, 0]}]}],
     "tear": {"strain": 0.4}},
    {"name": "ball", "shape": {"sphere": {"radius": 0.5, "subdivisions": 3}}, "mass": 1,
     "constraints": [
       {"type": "distance", "rigidity": 500},
       {"type": "isometric_bending", "rigidity": 1e-4, "rest_scale": 0.5},
       {"type": "membrane", "young_modulus": 40, "poisson_ratio": 0.2,
        "map": {"values": [1, 2]}, "poisson_ratio_map": {"values": [1, 2]}},
       {"type": "plate", "rigidity": 1e-3, "poisson_ratio": 0.3,
        "map": {"picture": "meshes/x.png", "channel": "blue", "range": [0.5, 2]}}]},
    {"name": "crate", "shape": {"box": {"size": [1, 2, 3], "cells": [1, 2, 3]}}, "material": "gray interlock",
     "rest": {"mesh": "meshes/z.obj"},
     "constraints": [
       {"type": "membrane", "young_modulus": [900, 300], "shear_modulus": 20, "along": [1, 1, 1]},
       {"type": "plate", "rigidity": [1e-4, 2e-5], "twisting_rigidity": 1e-5, "along": [1, 1, 1],
        "map": {"colours": "alpha"}}]},
    {"name": "beam", "shape": {"bar": {"length": 2, "width": 0.2, "cells": 4}}, "mass": 1,
     "rest": {"points": [[0, 0, 0], [1, 0, 0]]}},
    {"name": "rope", "shape": {"chain": {"from": [0, 0, 0], "to": [0, -1, 0], "segments": 9}}, "density": 0.1,
     "pins": [{"row": "first"}], "constraints": [{"type": "long_range", "limit": 0.05}]},
    {"name": "shot", "shape": {"lattice": {"min": [0, 0, 0], "max": [1, 1, 0], "count": [2, 3, 1]}}, "mass": 1},
    {"name": "jelly", "shape": {"tet_box": {"size": [1, 2, 3], "cells": [1, 2, 3]}}, "density": 1000,
     "constraints": [
       {"type": "volume", "compliance": 0.5, "rest_scale": 1.5, "rest_scale_map": {"values": [1, 0]}},
       {"type": "neo_hookean", "young_modulus": 2e5, "poisson_ratio": 0.4,
        "poisson_ratio_map": {"values": [1, 0.5]}}]},
    {"name": "in place", "mass": 1, "shape": {"mesh_data": {
      "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [5, 0, 0]], "faces": [[0, 1, 2]], "lines": [[3, 4]],
      "tetrahedra": [[0, 1, 2, 3]]}}}
  ],
  "seams": [
    {"from": {"body": "sheet", "row": "last"}, "to": {"body": "crate", "rim": "all"}, "within": 0.02, "closing": 0.5,
     "compliance": 1e-6},
    {"from": {"body": "sheet", "rim": "all"}, "to": {"body": "ball", "sphere": {"center": [0, 1, 0], "radius": 0.1}},
     "within": 0.5},
    {"from": {"body": "rope", "row": "last"}, "to": {"body": "sheet", "row": "first"}, "within": 1},
    {"from": {"body": "ball", "box": {"min": [0, 0, 0], "max": [1, 1, 1]}}, "to": {"body": "sheet", "nearest": [0, 1, 0]},
     "within": 2},
    {"from": {"body": "ball", "particles": [3]}, "to": {"body": "crate", "particles": [0, 2]}, "within": 2},
    {"from": {"body": "ball", "nearest": [0, 1, 0]}, "to": {"body": "crate", "surface": true}, "within": 0.1},
    {"from": {"body": "ball"}, "to": {"body": "crate"}, "pairs": [[0, 1], [2, 3]]}],
  "environment": [
    {"name": "statue", "shape": {"mesh": "meshes/y.off"}, "sides": "solid", "start_inside": "push_out"},
    {"name": "ground", "shape": {"grid": {"size": [9, 9], "cells": [1, 1]}}, "sides": "one_sided",
     "transform": {"translate": [-4, 0, -4]}, "thickness": 0.01, "friction": 1.5, "restitution": 0.25},
    {"name": "curtain", "shape": {"grid": {"size": [1, 1], "cells": [1, 1]}}, "sides": "two_sided"},
    {"name": "planet", "shape": {"sphere": {"radius": 1, "subdivisions": 2}},
     "motion": [
       {"time": 0},
       {"time": 0.5, "translate": [0, 1, 0]},
       {"time": 2, "translate": [0, 1, 0], "rotate": {"axis": [0, 1, 0], "degrees": 720}}]},
    {"name": "block", "shape": {"box": {"size": [1, 1, 1], "cells": [1, 1, 1]}}},
    {"name": "rail", "shape": {"bar": {"length": 2, "width": 0.2, "cells": 1}}},
    {"name": "walker", "shape": {"mesh": "meshes/z.glb"},
     "animation": {"file": "meshes/walk.glb", "clip": "walk", "speed": 2, "offset": -0.5, "loop": true}},
    {"name": "swimmer", "shape": {"mesh": "meshes/z.glb"},
     "animation": {"frames": "meshes/swim_*.ply", "frames_per_second": 24}},
    {"name": "puppet", "shape": {"mesh": "meshes/z.glb"}, "animation": {"from_code": true}},
    {"name": "tile", "sides": "two_sided", "shape": {"mesh_data": {
      "points": [[0, 0, 0], [0, 0, 1], [1, 0, 0]], "faces": [[0, 1, 2]]}}},
    {"name": "floor", "shape": {"plane": {}}, "transform": {"translate": [0, -9, 0]}},
    {"name": "arm", "shape": {"capsule": {"from": [3, 0, 0], "to": [4, 0, 0], "radius": 0.1}}},
    {"name": "pillar", "shape": {"cylinder": {"from": [5, 0, 0], "to": [5, 2, 0], "radius": 0.2}}}
  ],
  "self_collision": {"thickness": 0.004, "friction": 0.5, "bodies": ["sheet", "ball"],
                     "crossing_at_start": "ignore"},
  "duration": 2.5,
  "outputs": {
    "frames": {"every": 2, "formats": ["vtp", "pc2", "ply", "obj", "glb"]},
    "page": {"max_megabytes": 30}, "pictures": {"every": 5, "size": [640, 360],
                 "camera": {"eye": [1, 2, 3], "target": [0, 0.5, 0], "fov_degrees": 35}},
    "checkpoint_every": 10
  },
  "expect": {
    "max_strain": 0.1, "rms_strain": {"at_least": 0.001, "at_most": 0.01}, "max_penetration": 0.001, "max_crossings": 2,
    "energy_not_above": -5, "energy_not_below": -50, "max_speed": {"at_least": 3},
    "bounds": {"min": [-1, -2, -3], "max": [1, 2, 3]}, "volume_ratio": [0.9, 1.1],
    "bodies": [{"name": "ball", "bounds": {"min": [-0.5, -1, -1.5], "max": [0.5, 1, 1.5]}}],
    "max_seam_gap": 0.001,
    "inverted_tetrahedra": {"at_least": 1, "at_most": 3}
  }
})";
}

std::string changed_scene(const std::string& pointer, const std::string& value) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(full_scene());
  const nlohmann::ordered_json::json_pointer at(pointer);
  if (value == "remove") {
    json[at.parent_pointer()].erase(at.back());
  } else {
    json[at] = nlohmann::ordered_json::parse(value);
  }
  return json.dump();
}

std::string scene_refusal(const std::string& text) {
  return refusal([&] { parse_scene(text, "s.json", ""); });
}

}  // namespace malha
