// SPDX-License-Identifier: Apache-2.0
// Scenes as JSON for the tests of whole runs.
#pragma once
#include <atomic>
#include <nlohmann/json.hpp>
#include <string>

#include "host/run/run.h"

namespace malha {

using Json = nlohmann::ordered_json;

/// A sheet, pinned at one corner, that swings; with an environment it falls onto a moving ball and the ground. 40
/// steps.
inline Json swinging_sheet(bool environment, const std::string& precision = "float") {
  Json scene = Json::parse(R"({
    "name": "swinging sheet",
    "solver": {"type": "pbd", "dt": 0.02, "substeps": 3, "iterations": 2},
    "gravity": [0, -9.81, 0],
    "wind": {"velocity": [0.3, 0, 1], "drag": 0.001},
    "bodies": [{
      "name": "sheet",
      "shape": {"grid": {"size": [1, 1], "cells": [6, 6]}},
      "transform": {"translate": [-0.5, 0.4, -0.5]},
      "mass": 0.5,
      "damping": 0.05,
      "pins": [{"particles": [0]}],
      "constraints": [
        {"type": "distance", "elements": ["edges", "shear"], "compliance": 0.0001},
        {"type": "bending", "stiffness": 0.2}
      ]
    }],
    "duration": 0.8
  })");
  scene["solver"]["precision"] = precision;
  if (environment)
    scene["environment"] = Json::parse(R"([
      {"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 3}}, "friction": 0.5, "thickness": 0.01,
       "motion": [{"time": 0}, {"time": 0.8, "translate": [0.1, 0, 0], "rotate": {"axis": [0, 1, 0], "degrees": 90}}]},
      {"name": "ground", "shape": {"grid": {"size": [4, 4], "cells": [1, 1]}}, "sides": "one_sided", "restitution": 0.5,
       "transform": {"translate": [-2, -0.3, -2]}}
    ])");
  return scene;
}

inline Scene parsed(const Json& scene) { return parse_scene(scene.dump(), "test.json", "."); }

/// Runs on one thread, without anything that watches or stops.
inline RunResult run_quietly(const Json& scene, const RunOptions& options) {
  return run(
      parsed(scene), {.threads = 1}, options, [](const Progress&) {}, std::atomic<bool>{false});
}

}  // namespace malha
