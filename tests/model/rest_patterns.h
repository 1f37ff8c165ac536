// SPDX-License-Identifier: Apache-2.0
// Sheets whose rest shape is a flat pattern while they start on a cylinder, in the forms in which scenes say it.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/numbers.h"
#include "tests/small_scenes.h"

namespace malha {

/// A pattern of width x height (m) in the plane z = 0 that starts rolled up about the z axis of a cylinder. Closed, its
/// first and last column are the same vertices, where the pattern has a seam.
struct RolledPattern {
  double width, height, radius;
  int across, along;  // cells
  bool closed;
  std::vector<Vec3> start;                // m, of each vertex
  std::vector<Vec3> flat;                 // m, of each texture coordinate
  std::vector<std::vector<int>> faces;    // by vertices
  std::vector<std::vector<int>> corners;  // the same by texture coordinates

  double area() const { return width * height; }
  MeshDataShape shape() const {
    MeshDataShape of{start, {}, {}, {}};
    for (const auto& face : faces) of.faces.push_back({face[0], face[1], face[2], face.size() > 3 ? face[3] : -1});
    return of;
  }
  /// An OBJ file of the start, with the pattern over `metres` as texture coordinates.
  std::string obj(double metres = 1) const {
    std::string text;
    char line[100];
    for (const Vec3& x : start)
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", x[0], x[1], x[2]), text += line;
    for (const Vec3& x : flat)
      std::snprintf(line, sizeof line, "vt %.17g %.17g\n", x[0] / metres, x[1] / metres), text += line;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      text += "f";
      for (std::size_t k = 0; k < faces[f].size(); ++k)
        text += " " + std::to_string(faces[f][k] + 1) + "/" + std::to_string(corners[f][k] + 1);
      text += "\n";
    }
    return text;
  }

  /// The start of each place of the pattern: a glTF file has a vertex for each, also at a seam.
  std::vector<Vec3> start_of_places() const {
    std::vector<Vec3> of(flat.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (std::size_t k = 0; k < faces[f].size(); ++k) of[corners[f][k]] = start[faces[f][k]];
    return of;
  }

  /// A .glb file of triangles, with the pattern as texture coordinates unless they are left out.
  std::string glb(bool with_texture = true) const {
    std::string bytes;
    const auto add = [&bytes](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (const Vec3& x : start_of_places())
      for (const double k : x) add(static_cast<float>(k));
    const std::size_t positions = bytes.size();
    for (const Vec3& x : flat) add(static_cast<float>(x[0])), add(static_cast<float>(x[1]));
    const std::size_t texture = bytes.size() - positions;
    for (const auto& face : corners)
      for (const int corner : face) add(static_cast<std::uint32_t>(corner));
    const std::size_t indices = bytes.size() - positions - texture;
    const auto number = [](std::size_t n) { return std::to_string(n); };
    const auto view = [&](std::size_t at, std::size_t length) {
      return R"({"buffer":0,"byteOffset":)" + number(at) + R"(,"byteLength":)" + number(length) + "}";
    };
    const auto accessor = [&](int of, std::size_t count, const char* type, const char* component) {
      return R"({"bufferView":)" + std::to_string(of) + R"(,"count":)" + number(count) + R"(,"type":")" + type +
             R"(","componentType":)" + component + "}";
    };
    std::string json =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0)" +
        std::string(with_texture ? R"(,"TEXCOORD_0":1)" : "") + R"(},"indices":2}]}],"buffers":[{"byteLength":)" +
        number(bytes.size()) + R"(}],"bufferViews":[)" + view(0, positions) + "," + view(positions, texture) + "," +
        view(positions + texture, indices) + R"(],"accessors":[)" + accessor(0, flat.size(), "VEC3", "5126") + "," +
        accessor(1, flat.size(), "VEC2", "5126") + "," + accessor(2, indices / 4, "SCALAR", "5125") + "]}";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::string binary = std::move(bytes);
    bytes = "glTF";
    const auto word = [&add](std::size_t n) { add(static_cast<std::uint32_t>(n)); };
    word(2), word(12 + 8 + json.size() + 8 + binary.size());
    word(json.size()), bytes += "JSON" + json;
    word(binary.size()), bytes += std::string("BIN\0", 4) + binary;
    return bytes;
  }
};

enum class Cells { Quads, Triangles, Irregular };

inline RolledPattern rolled_pattern(double width, double height, double radius, int across, int along, bool closed,
                                    Cells cells) {
  RolledPattern of{width, height, radius, across, along, closed, {}, {}, {}, {}};
  Random random(1);
  const int columns = across + 1, vertices = closed ? across : columns;
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i <= across; ++i) {
      const bool inside = i > 0 && i < across && j > 0 && j < along && cells == Cells::Irregular;
      const double di = inside ? 0.2 * random() : 0, dj = inside ? 0.2 * random() : 0;
      const double s = width * (i + di) / across, t = height * (j + dj) / along;
      of.flat.push_back({s, t, 0});
      if (i < vertices) of.start.push_back({radius * std::cos(s / radius), radius * std::sin(s / radius), t});
    }
  const auto add = [&](const std::vector<std::array<int, 2>>& cell_corners) {
    of.faces.emplace_back(), of.corners.emplace_back();
    for (const auto& [i, j] : cell_corners)
      of.faces.back().push_back(j * vertices + i % vertices), of.corners.back().push_back(j * columns + i);
  };
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < across; ++i) {
      const std::array<int, 2> p{i, j}, q{i + 1, j}, r{i + 1, j + 1}, s{i, j + 1};
      if (cells == Cells::Quads)
        add({p, q, r, s});
      else if (cells == Cells::Irregular && random() < 0)
        add({p, q, s}), add({q, r, s});
      else
        add({p, q, r}), add({p, r, s});
    }
  return of;
}

/// A body of the pattern on its cylinder, which rests flat.
inline BodySpec rolled_body(const RolledPattern& pattern, std::vector<ConstraintSpec> constraints) {
  BodySpec body;
  body.name = "cloth", body.shape = pattern.shape(), body.density = 0.2, body.constraints = std::move(constraints);
  body.rest = RestPoints{pattern.flat};
  return body;
}

inline ConstraintSpec plate_of(double D, double nu = 0) {
  ConstraintSpec spec;
  spec.type = "plate", spec.rigidity = D, spec.parameter = nu;
  return spec;
}
inline ConstraintSpec membrane_of(double Y, double nu = 0.3) {
  ConstraintSpec spec;
  spec.type = "membrane", spec.young_modulus = Y, spec.parameter = nu;
  return spec;
}

}  // namespace malha
