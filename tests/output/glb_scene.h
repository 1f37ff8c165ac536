// SPDX-License-Identifier: Apache-2.0
// A scene with everything that a glTF file may contain, and a reader of its frames in another format.
#pragma once
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "tests/constraints/mixed_sheet.h"
#include "tests/mesh/file_vertices.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {

inline constexpr int kGlbFrames = 25;
inline constexpr double kGlbStep = 1.0 / 48;         // s
inline constexpr double kHalfAFloat = 0x1p-24;       // the largest error of rounding to a float, relative to the number
inline constexpr double kBallTurns = 500;            // degrees a second
inline constexpr double kBallMoves[]{0.4, -0.1, 0};  // m/s

/// Triangles of many forms and quads, between vertices that nothing uses.
inline Interspersed patchwork() {
  Mesh sheet = mixed_sheet(5, true, 7);
  std::vector<Quad> faces;
  for (std::size_t f = 0; f < sheet.faces.size(); ++f) {
    const Quad &a = sheet.faces[f], b = f + 1 < sheet.faces.size() ? sheet.faces[f + 1] : Quad{};
    const bool pair = a[0] == b[0] && a[2] == b[1] && f % 4 != 0;
    faces.push_back(pair ? Quad{a[0], a[1], a[2], b[2]} : a);
    f += pair;
  }
  sheet.faces = faces;
  return interspersed(sheet, 11);
}

/// Two sheets, a rope and loose particles fall beside a ball that rolls; 25 frames as "glb" and "obj".
inline Json glb_scene(const TemporaryFolder& folder) {
  const std::string mesh = folder.write("patchwork.obj", obj_of(patchwork().mesh));
  Json scene = Json::parse(R"({
    "name": "all that there is",
    "solver": {"type": "pbd", "substeps": 4, "precision": "double"},
    "gravity": [0, -9.81, 0],
    "bodies": [
      {"name": "patchwork", "mass": 0.3, "spin": [1, 2, 0.5],
       "transform": {"translate": [-0.5, 1.4, -0.5], "rotate": {"axis": [1, 2, 0], "degrees": 20}}},
      {"name": "sheet of quads", "shape": {"grid": {"size": [1, 1], "cells": [6, 4]}}, "mass": 0.3,
       "transform": {"translate": [2, 1, 0]}, "pins": [{"row": "first"}]},
      {"name": "rope", "shape": {"chain": {"from": [0, 2, 2], "to": [1, 2, 2], "segments": 9}}, "mass": 0.1,
       "pins": [{"row": "first"}]},
      {"name": "dust", "shape": {"lattice": {"min": [-2, 3, 0], "max": [-1, 4, 1], "count": [3, 2, 2]}}, "mass": 1,
       "velocity": [0.3, 0, 0.1]}
    ],
    "environment": [
      {"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 2}}, "transform": {"translate": [-3, 0.3, 0]}},
      {"name": "ground", "shape": {"grid": {"size": [20, 20], "cells": [1, 1]}}, "sides": "one_sided",
       "transform": {"translate": [-10, -9, -10]}}
    ],
    "outputs": {"frames": {"every": 1, "formats": ["glb", "obj"]}}
  })");
  scene["solver"]["dt"] = kGlbStep, scene["duration"] = kGlbStep * (kGlbFrames - 1);
  scene["bodies"][0]["shape"] = {{"mesh", mesh}};
  for (const int body : {0, 1, 2})
    scene["bodies"][body]["constraints"] = {{{"type", "distance"}, {"elements", {"edges"}}, {"compliance", 1e-5}}};
  scene["environment"][0]["motion"] = {
      {{"time", 0}},
      {{"time", 1}, {"translate", kBallMoves}, {"rotate", {{"axis", {0, 0, 1}}, {"degrees", kBallTurns}}}}};
  return scene;
}

/// Runs the scene into a subfolder, and returns the path of its frames.
inline std::filesystem::path run_with_frames(const TemporaryFolder& folder, const Json& scene, const std::string& name,
                                             std::optional<std::int64_t> steps = {}) {
  run_quietly(scene, {.out = (folder / name).string(), .steps = steps});
  return folder / name / "frames";
}

/// A frame read from "obj", in double to the bit; corners are counted from 0.
struct ObjOfFrame {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> faces, lines, loose;

  ObjOfFrame(const std::filesystem::path& frames, int index) {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%06d.obj", index);
    std::istringstream text(bytes_of(frames / name));
    for (std::string line; std::getline(text, line);) {
      if (line[0] == 'o') continue;
      std::istringstream words(line.substr(1));
      std::vector<int> corners;
      Vec3 x{};
      std::string word;
      for (std::size_t k = 0; words >> word; ++k)
        line[0] == 'v' ? void(x.at(k) = std::strtod(word.c_str(), nullptr)) : corners.push_back(std::stoi(word) - 1);
      if (line[0] == 'v') points.push_back(x);
      for (const auto& [kind, all] : {std::pair{'f', &faces}, {'l', &lines}, {'p', &loose}})
        if (line[0] == kind) all->push_back(corners);
    }
  }
};

/// The position to which the ball moves a point that it has at the start: a rotation about the origin, then a
/// translation.
inline Vec3 on_the_ball(const Vec3& x, double time) {
  const double angle = kBallTurns * time * 3.14159265358979323846 / 180, c = std::cos(angle), s = std::sin(angle);
  return {c * x[0] - s * x[1] + kBallMoves[0] * time, s * x[0] + c * x[1] + kBallMoves[1] * time,
          x[2] + kBallMoves[2] * time};
}

}  // namespace malha
