// SPDX-License-Identifier: Apache-2.0
#include "host/model/vertex_map.h"

#include <algorithm>
#include <cmath>

#include "host/mesh/io/mesh_io.h"
#include "host/mesh/weld.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

const char* const kChannels[]{"red", "green", "blue", "alpha"};

int channel_named(const std::string& name) {
  return static_cast<int>(std::ranges::find(kChannels, name) - std::begin(kChannels));
}

/// The file of a shape whose vertices a map refers to.
const MeshFile& file_of(const Shape& shape, const MapPlace& place, const char* what) {
  const auto* file = std::get_if<MeshFile>(&shape);
  if (!file) refuse(place.file, place.pointer, std::string(what) + " of a generated shape", "those of a file ('mesh')");
  return *file;
}

double in_range(const VertexMap& map, double part) { return map.range[0] + part * (map.range[1] - map.range[0]); }

std::vector<double> from_colours(const MeshFile& shape, const VertexMap& map) {
  const FileMesh file = read_file_mesh(shape.path, shape.part, Attributes::All);
  if (file.colours.empty())
    refuse(shape.path, "", "no colours of vertices", "an OBJ, PLY or glTF file with them, which a map refers to");
  std::vector<double> values;
  for (const auto& colour : file.colours)
    values.push_back(in_range(map, double{colour[static_cast<std::size_t>(channel_named(map.colours))]}));
  return values;
}

std::vector<double> from_picture(const MeshFile& shape, const VertexMap& map) {
  const FileMesh file = read_file_mesh(shape.path, shape.part, Attributes::All);
  const Polygons& polygons = file.polygons;
  const ChannelPicture picture = read_picture(map.picture);
  const int channel = channel_named(map.channel);
  std::vector<double> sum(file.mesh.points.size(), 0), values(sum.size(), map.range[0]);
  std::vector<int> corners(sum.size(), 0);
  for (std::size_t c = 0; c < polygons.corners.size(); ++c) {
    const int uv = polygons.uv_of(static_cast<int>(c));
    if (uv < 0) continue;
    const auto vertex = static_cast<std::size_t>(polygons.corners[c]);
    const auto [u, v] = polygons.uv[static_cast<std::size_t>(uv)];
    // glTF counts v from above.
    sum[vertex] += picture.at(channel, u, is_gltf_file(shape.path) ? 1 - v : v);
    ++corners[vertex];
  }
  if (std::ranges::count(corners, 0) == static_cast<std::ptrdiff_t>(corners.size()))
    refuse(shape.path, "", "no texture coordinates", "an OBJ or glTF file with them, on which a map lays a picture");
  for (std::size_t v = 0; v < values.size(); ++v)
    if (corners[v] > 0) values[v] = in_range(map, sum[v] / corners[v]);
  return values;
}

}  // namespace

double ChannelPicture::at(int channel, double u, double v) const {
  const int alpha = channels == 2 ? 1 : channels == 4 ? 3 : -1;
  const int of = channel == 3 ? alpha : channels < 3 ? 0 : channel;
  if (of < 0) return 1;  // opaque
  // Both borders are part of the picture: texture coordinates of 1 are those of its last pixels.
  const auto inside = [](double at) { return at >= 0 && at <= 1 ? at : at - std::floor(at); };
  const double x = inside(u) * width - 0.5, y = (1 - inside(v)) * height - 0.5;
  const auto pixel = [&](double column, double row) {
    const auto i = static_cast<std::size_t>(std::clamp(static_cast<int>(column), 0, width - 1));
    const auto j = static_cast<std::size_t>(std::clamp(static_cast<int>(row), 0, height - 1));
    return double{values[(j * static_cast<std::size_t>(width) + i) * static_cast<std::size_t>(channels) +
                         static_cast<std::size_t>(of)]};
  };
  const double left = std::floor(x), top = std::floor(y), s = x - left, t = y - top;
  return (1 - t) * ((1 - s) * pixel(left, top) + s * pixel(left + 1, top)) +
         t * ((1 - s) * pixel(left, top + 1) + s * pixel(left + 1, top + 1));
}

std::vector<double> values_at_points(const Shape& shape, const Mesh& mesh, const VertexMap& map,
                                     const MapPlace& place) {
  const std::vector<int> point = points_of_vertices(mesh.vertices, static_cast<int>(mesh.points.size()));
  std::vector<double> of_vertices;
  if (!map.colours.empty())
    of_vertices = from_colours(file_of(shape, place, "colours of vertices"), map);
  else if (!map.picture.empty())
    of_vertices = from_picture(file_of(shape, place, "texture coordinates"), map);
  else
    of_vertices = map.values;
  if (of_vertices.size() != point.size())
    refuse(place.file, place.pointer, counted(of_vertices.size(), "value"),
           "one for each vertex of the shape, " + std::to_string(point.size()));
  std::vector<double> values(mesh.points.size(), 0);
  std::vector<int> vertices(values.size(), 0);
  for (std::size_t v = 0; v < point.size(); ++v)
    if (point[v] >= 0)
      values[static_cast<std::size_t>(point[v])] += of_vertices[v], ++vertices[static_cast<std::size_t>(point[v])];
  for (std::size_t i = 0; i < values.size(); ++i) values[i] /= vertices[i];
  return values;
}

std::vector<double> factors_at_points(const Scene& scene, std::size_t body, const Mesh& mesh, const VertexMap& map,
                                      const std::string& pointer, const FactorRange& range) {
  const std::vector<double> values = values_at_points(scene.bodies[body].shape, mesh, map, {scene.file, pointer});
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(values[i] >= kLeastFactor || (range.zero_allowed && values[i] == 0)) || !(values[i] <= range.most))
      refuse(scene.file, pointer,
             "the factor " + shown(values[i]) + " at vertex " +
                 std::to_string(vertex_of(mesh.vertices, static_cast<int>(i))),
             std::string(range.zero_allowed ? "0, and " : "") + "factors from " + shown(kLeastFactor) + " to " +
                 shown(range.most) + "; \"range\" says what 0 and 1 of a channel are");
  return values;
}

std::vector<double> parameter_factors_at_points(const Scene& scene, std::size_t body, const Mesh& mesh,
                                                const VertexMap& map, const Parameter& parameter, double value,
                                                const std::string& pointer) {
  const std::vector<double> values = values_at_points(scene.bodies[body].shape, mesh, map, {scene.file, pointer});
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double there = values[i] * value;
    if ((parameter.minimum_allowed ? there >= parameter.minimum : there > parameter.minimum) &&
        there <= parameter.maximum && std::isfinite(there))
      continue;
    const std::string below = std::isfinite(parameter.maximum) ? ", <= " + shown(parameter.maximum) : "";
    refuse(scene.file, pointer,
           "the factor " + shown(values[i]) + " at vertex " +
               std::to_string(vertex_of(mesh.vertices, static_cast<int>(i))) + ", with which '" + parameter.name +
               "' is " + shown(there),
           "factors with which it is " + std::string(parameter.minimum_allowed ? ">= " : "> ") +
               shown(parameter.minimum) + below + "; \"range\" says what 0 and 1 of a channel are");
  }
  return values;
}

}  // namespace malha
