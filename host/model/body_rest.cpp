// SPDX-License-Identifier: Apache-2.0
#include "host/model/body_rest.h"

#include <algorithm>
#include <cmath>

#include "host/mesh/bounding_box.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/rest_shape.h"
#include "host/mesh/tetrahedra.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "host/model/body.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

constexpr double kNoArea = 1e-12;   // over the square of the diagonal of the bounding box, as in check_mesh()
constexpr double kNoVolume = 1e-6;  // over the cube of the longest edge, as in complete_tetrahedra()

std::string item(const char* what, std::size_t number) {
  return std::string(what) + " " + std::to_string(number) + " (0-based)";
}

template <class Item>
std::string corners_of(const Item& item) {
  std::string text;
  for (const int corner : item)
    if (corner >= 0) text += (text.empty() ? "" : ", ") + std::to_string(corner);
  return text;
}

/// Fits the rest shape of one body.
class RestFitter {
 public:
  RestFitter(const Scene& scene, std::size_t index, const Mesh& as_read, const Mesh& mesh)
      : scene_(scene), spec_(scene.bodies[index]), index_(index), as_read_(as_read), mesh_(mesh) {}

  Mesh fit() {
    const Mesh in_file = std::visit([this](const auto& rest) { return places(rest); }, *spec_.rest);
    std::vector<int> number;  // in the file, of each face of the mesh
    std::vector<Quad> corners;
    if (mesh_.tetrahedra.empty()) find_faces(in_file, number, corners);
    std::vector<Vec3> place = mesh_.points;
    const bool has_seams = !find_places(in_file, corners, place);
    Mesh rest;
    if (!has_seams)
      rest = {std::move(place), mesh_.faces, mesh_.lines, {}};
    else
      rest = {in_file.points, std::move(corners), {}, {}};
    if (has_seams && !(mesh_.lines.empty() && mesh_.tetrahedra.empty()))
      refuse_rest("merged vertices with different places at rest, of a body with lines or tetrahedra",
                  "equal places there, or no \"weld\"");
    check(rest, number);
    return rest;
  }

 private:
  /// The places in the numbering of the shape's file, and its faces by the numbers of the places.
  Mesh places(const RestMesh& of) const {
    const auto* shape = std::get_if<MeshFile>(&spec_.shape);
    Mesh rest = read_mesh(of.path, shape ? shape->part : MeshPart{});
    const std::string as = " as of " + origin(scene_, spec_.shape);
    if (rest.points.size() != as_read_.points.size())
      refuse(of.path, "", counted(rest.points.size(), "vertex", "vertices"),
             std::to_string(as_read_.points.size()) + as + ", whose rest shape this is");
    const auto compare = [&](const auto& found, const auto& wanted, const char* one, const char* many) {
      const auto [a, b] = std::ranges::mismatch(found, wanted);
      if (a != found.end() && b != wanted.end())
        refuse(of.path, item(one, static_cast<std::size_t>(a - found.begin())), "the vertices " + corners_of(*a),
               corners_of(*b) + as + ", whose rest shape this is");
      if (found.size() != wanted.size())
        refuse(of.path, "", counted(found.size(), one, many),
               std::to_string(wanted.size()) + as + ", whose rest shape this is");
    };
    compare(rest.tetrahedra, as_read_.tetrahedra, "tetrahedron", "tetrahedra");
    compare(rest.faces, as_read_.faces, "face", "faces"), compare(rest.lines, as_read_.lines, "line", "lines");
    return rest;
  }
  Mesh places(const RestPoints& of) const {
    if (of.points.size() != as_read_.points.size())
      refuse(scene_.file, pointer("bodies", index_, "rest/points"), "a list of " + std::to_string(of.points.size()),
             "a place for each of the " + counted(as_read_.points.size(), "vertex", "vertices") + " of the shape");
    return {of.points, as_read_.faces, {}, {}};
  }
  Mesh places(const RestUv& of) const {
    if (as_read_.faces.empty() || !as_read_.lines.empty() || !as_read_.tetrahedra.empty())
      refuse(
          scene_.file, pointer("bodies", index_, "rest/uv"),
          "a pattern of texture coordinates for " + std::string(!as_read_.tetrahedra.empty() ? "tetrahedra" : "lines"),
          "a shape of faces only, or 'mesh' or 'points'");
    const auto& shape = std::get<MeshFile>(spec_.shape);
    Mesh texture = read_texture_coordinates(shape.path, shape.part);
    for (Vec3& point : texture.points)
      for (double& coordinate : point) coordinate *= of.metres;
    return texture;
  }
  bool is_pattern() const { return std::holds_alternative<RestUv>(*spec_.rest); }

  /// Finds each face of the mesh in the file, in whose order they are, and the places of its corners.
  void find_faces(const Mesh& in_file, std::vector<int>& number, std::vector<Quad>& corners) const {
    const FileVertices& vertices = mesh_.vertices;
    std::vector<int> vertex(mesh_.points.size());  // the lowest of each point
    const std::vector<int> point = points_of_vertices(vertices, static_cast<int>(mesh_.points.size()));
    for (std::size_t v = point.size(); v-- > 0;)
      if (point[v] >= 0) vertex[point[v]] = static_cast<int>(v);
    std::size_t f = 0;
    for (std::size_t k = 0; k < mesh_.faces.size(); ++k) {
      Quad face = vertices.faces.empty() ? mesh_.faces[k] : vertices.faces[k];
      if (vertices.faces.empty())
        for (int& corner : face)
          if (corner >= 0) corner = vertex[corner];
      const auto is_corner = [&](int v) {
        return v < 0 || std::ranges::find(as_read_.faces[f], v) != as_read_.faces[f].end();
      };
      while (!std::ranges::all_of(face, is_corner)) ++f;
      Quad& at = corners.emplace_back(Quad{-1, -1, -1, -1});
      for (int c = 0; c < 4; ++c)
        if (face[c] >= 0)
          at[c] = in_file.faces[f][std::ranges::find(as_read_.faces[f], face[c]) - as_read_.faces[f].begin()];
      number.push_back(static_cast<int>(f++));
    }
  }

  /// Finds the place of each point. Returns false if one has several.
  bool find_places(const Mesh& in_file, const std::vector<Quad>& corners, std::vector<Vec3>& place) const {
    std::vector<bool> known(place.size(), false);
    bool single = true;
    const auto set = [&](int point, const Vec3& at) {
      single = single && (!known[point] || place[point] == at);
      place[point] = at, known[point] = true;
    };
    if (!is_pattern()) {
      const std::vector<int> point = points_of_vertices(mesh_.vertices, static_cast<int>(mesh_.points.size()));
      for (std::size_t v = 0; v < in_file.points.size(); ++v)
        if (point[v] >= 0) set(point[v], in_file.points[v]);
      return single;
    }
    for (std::size_t f = 0; f < corners.size(); ++f)
      for (int k = 0; k < 4; ++k)
        if (corners[f][k] >= 0) set(mesh_.faces[f][k], in_file.points[corners[f][k]]);
    return single && !is_folded(place);
  }

  /// True if triangles of a flat pattern lie on their neighbours, so that their common edge is a seam.
  bool is_folded(const std::vector<Vec3>& place) const {
    const auto side = [&](const std::array<int, 4>& hinge, int wing) {
      return normal(place[hinge[0]], place[hinge[1]], place[hinge[wing]])[2];
    };
    return std::ranges::any_of(hinges(mesh_), [&](const auto& hinge) { return side(hinge, 2) * side(hinge, 3) > 0; });
  }

  void check(const Mesh& rest, const std::vector<int>& number) const {
    const auto [low, high] = bounds_of(rest.points);
    const double none = kNoArea * squared_distance(low, high);
    const auto has_area = [&](int a, int b, int c) {
      return area(rest.points[a], rest.points[b], rest.points[c]) > none;
    };
    for (std::size_t f = 0; f < number.size(); ++f) {
      const auto& [a, b, c, d] = rest.faces[f];
      if (!has_area(a, b, c) || (d >= 0 && !has_area(a, c, d)))
        refuse_rest(item("face", number[f]) + " without area", "faces and halves of quads with an area at rest");
    }
    for (std::size_t l = 0; l < rest.lines.size(); ++l)
      if (rest.points[rest.lines[l][0]] == rest.points[rest.lines[l][1]])
        refuse_rest(item("line", l) + " without length", "lines with a length at rest");
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
      const Tetrahedron& of = mesh_.tetrahedra[t];
      double longest = 0;
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < j; ++k) longest = std::max(longest, distance(rest.points[of[j]], rest.points[of[k]]));
      if (const double V = volume(rest.points, of); !(V > kNoVolume * longest * longest * longest))
        refuse_rest(item("tetrahedron", t) + " with a volume of " + shown(V) + " m^3",
                    "positive volumes at rest, above 1e-6 of the longest edge's cube");
    }
  }

  [[noreturn]] void refuse_rest(const std::string& found, const std::string& allowed) const {
    refuse(scene_.file, pointer("bodies", index_, "rest"), found, allowed);
  }

  const Scene& scene_;
  const BodySpec& spec_;
  std::size_t index_;
  const Mesh& as_read_;
  const Mesh& mesh_;
};

}  // namespace

std::optional<Mesh> load_rest(const Scene& scene, std::size_t index, const Mesh& as_read, const Mesh& mesh) {
  if (!scene.bodies[index].rest) return std::nullopt;
  return RestFitter(scene, index, as_read, mesh).fit();
}

}  // namespace malha
