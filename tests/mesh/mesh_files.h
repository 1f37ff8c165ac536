// SPDX-License-Identifier: Apache-2.0
// Helpers for tests of mesh files: temporary files, and numbers in binary ones.
#pragma once
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "malha/mesh.h"
#include "tests/refusal.h"

namespace malha {

/// A new folder for a test's files, removed with this object.
class MeshFiles : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "malha_mesh_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Writes the bytes and returns the path.
  std::string file(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return (folder_ / name).string();
  }

  std::filesystem::path folder_;
};

/// Appends a value's bytes.
template <class T>
void append(std::string& bytes, T value, bool big = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big) std::reverse(raw, raw + sizeof(T));  // the machines that build this are little-endian
  bytes.append(raw, sizeof(T));
}

inline const Vec3 tetrahedron[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
inline const std::vector<Quad> tetrahedron_faces{{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}};

inline std::string ascii_stl() {
  std::ostringstream text;
  text << "solid tetra hedron\n";
  for (const Quad& face : tetrahedron_faces) {
    text << " facet normal nan 0 0\n  outer loop\n";
    for (int k = 0; k < 3; ++k) {
      const Vec3& point = tetrahedron[face[k]];
      text << "   vertex " << point[0] << ' ' << point[1] << ' ' << point[2] << '\n';
    }
    text << "  endloop\n endfacet\n";
  }
  return text.str() + "endsolid tetra hedron\n";
}

/// `header`: the start of the 80 bytes before the count.
inline std::string binary_stl(const std::string& header) {
  std::string bytes = header;
  bytes.resize(80, ' ');
  append(bytes, static_cast<std::uint32_t>(tetrahedron_faces.size()));
  for (const Quad& face : tetrahedron_faces) {
    for (int k = 0; k < 3; ++k) append(bytes, 0.0f);
    for (int k = 0; k < 3; ++k) {
      for (const double value : tetrahedron[face[k]]) append(bytes, static_cast<float>(value));
    }
    append(bytes, std::uint16_t{0x2020});
  }
  return bytes;
}

}  // namespace malha
