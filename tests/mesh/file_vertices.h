// SPDX-License-Identifier: Apache-2.0
// Mesh files with more vertices than their elements use, in several formats.
#pragma once
#include <sstream>
#include <string>
#include <vector>

#include "malha/mesh.h"
#include "tests/constraints/mixed_sheet.h"
#include "tests/numbers.h"
#include "tests/support.h"

namespace malha {

/// A mesh with unused vertices before, between and after its own.
struct Interspersed {
  Mesh mesh;
  std::vector<int> number;  // of each vertex of the whole mesh: its number in this one
  std::vector<int> unused;
};

inline Interspersed interspersed(const Mesh& whole, unsigned seed) {
  Random random(seed);
  Interspersed all;
  const auto add_unused = [&] {
    all.unused.push_back(static_cast<int>(all.mesh.points.size()));
    all.mesh.points.push_back({random(), random(), random()});
  };
  add_unused(), add_unused();
  for (std::size_t i = 0; i < whole.points.size(); ++i) {
    if (i > 0 && random.below(3) == 0) add_unused();
    all.number.push_back(static_cast<int>(all.mesh.points.size()));
    all.mesh.points.push_back(whole.points[i]);
  }
  add_unused();
  const auto renumbered = [&all](auto items) {
    for (auto& item : items)
      for (int& corner : item)
        if (corner >= 0) corner = all.number[corner];
    return items;
  };
  all.mesh.faces = renumbered(whole.faces), all.mesh.tetrahedra = renumbered(whole.tetrahedra);
  return all;
}

/// A stream that writes numbers so that they read back exactly.
inline std::ostringstream exact_text() {
  std::ostringstream text;
  text.precision(17);
  return text;
}

inline std::string ply_text_of(const Mesh& mesh) {
  std::ostringstream text = exact_text();
  text << "ply\nformat ascii 1.0\nelement vertex " << mesh.points.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << mesh.faces.size()
       << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& p : mesh.points) text << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  for (const Quad& f : mesh.faces) text << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  return text.str();
}

inline std::string off_text_of(const Mesh& mesh) {
  std::ostringstream text = exact_text();
  text << "OFF\n" << mesh.points.size() << ' ' << mesh.faces.size() << " 0\n";
  for (const Vec3& p : mesh.points) text << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  for (const Quad& f : mesh.faces) text << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  return text.str();
}

/// Gmsh text whose node tags neither start at 1 nor ascend.
inline std::string gmsh_text_of(const Mesh& mesh) {
  std::ostringstream text = exact_text();
  const auto tag = [count = mesh.points.size()](std::size_t i) { return 7 + 3 * (count - i); };
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << mesh.points.size() << '\n';
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    text << tag(i) << ' ' << mesh.points[i][0] << ' ' << mesh.points[i][1] << ' ' << mesh.points[i][2] << '\n';
  text << "$EndNodes\n$Elements\n" << mesh.tetrahedra.size() << '\n';
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    text << t + 1 << " 4 0";
    for (const int corner : mesh.tetrahedra[t]) text << ' ' << tag(static_cast<std::size_t>(corner));
    text << '\n';
  }
  text << "$EndElements\n";
  return text.str();
}

inline std::string medit_text_of(const Mesh& mesh) {
  std::ostringstream text = exact_text();
  text << "MeshVersionFormatted 2\nDimension 3\nVertices " << mesh.points.size() << '\n';
  for (const Vec3& p : mesh.points) text << p[0] << ' ' << p[1] << ' ' << p[2] << " 0\n";
  text << "Tetrahedra " << mesh.tetrahedra.size() << '\n';
  for (const auto& [a, b, c, d] : mesh.tetrahedra)
    text << a + 1 << ' ' << b + 1 << ' ' << c + 1 << ' ' << d + 1 << " 0\n";
  text << "End\n";
  return text.str();
}

/// Writes name.node and name.ele, counted from 0, and returns the path of the first.
inline std::string write_tetgen(const TemporaryFolder& folder, const std::string& name, const Mesh& mesh) {
  std::ostringstream nodes = exact_text(), elements = exact_text();
  nodes << mesh.points.size() << " 3 0 0\n";
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    nodes << i << ' ' << mesh.points[i][0] << ' ' << mesh.points[i][1] << ' ' << mesh.points[i][2] << '\n';
  elements << mesh.tetrahedra.size() << " 4 0\n";
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const auto& [a, b, c, d] = mesh.tetrahedra[t];
    elements << t << ' ' << a << ' ' << b << ' ' << c << ' ' << d << '\n';
  }
  folder.write(name + ".ele", elements.str());
  return folder.write(name + ".node", nodes.str());
}

/// The contents of an OBJ file: positions, and its other lines by their letter, with corners counted from 0.
struct DrawnObj {
  std::vector<Vec3> places;
  std::vector<std::vector<int>> faces, lines, dots;
};

inline DrawnObj drawn_obj(const std::string& text) {
  DrawnObj drawn;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "o") continue;
    if (kind == "v") {
      Vec3& place = drawn.places.emplace_back();
      for (double& x : place) words >> x;
      continue;
    }
    auto& corners = (kind == "f" ? drawn.faces : kind == "l" ? drawn.lines : drawn.dots).emplace_back();
    for (int corner = 0; words >> corner;) corners.push_back(corner - 1);
  }
  return drawn;
}

inline DrawnObj drawn_file(const std::filesystem::path& path) { return drawn_obj(bytes_of(path)); }

/// The faces of a mesh in the form that an OBJ file lists them.
inline std::vector<std::vector<int>> corner_lists(const std::vector<Quad>& faces) {
  std::vector<std::vector<int>> lists;
  for (const Quad& face : faces) {
    lists.emplace_back(face.begin(), face.end());
    std::erase(lists.back(), -1);
  }
  return lists;
}

}  // namespace malha
