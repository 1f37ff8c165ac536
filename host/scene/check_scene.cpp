// SPDX-License-Identifier: Apache-2.0
#include "host/scene/check_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/scene/scene_fields.h"

namespace malha {

namespace {

bool are_numbers(const std::vector<Vec3>& points) {
  return std::ranges::all_of(points, [](const Vec3& point) {
    return std::ranges::all_of(point, [](double number) { return std::abs(number) <= largest_number; });
  });
}

/// True if the parser would accept the mesh data. That corners are points is checked when the mesh is generated.
bool is_valid(const MeshDataShape& shape) {
  const auto are_vertices = [](const auto& corners) {
    return std::all_of(corners.begin(), corners.end(), [](int i) { return i >= 0; });
  };
  const auto is_face = [&](const Quad& face) { return face[0] >= 0 && face[1] >= 0 && face[2] >= 0 && face[3] >= -1; };
  return !shape.points.empty() && shape.points.size() <= static_cast<std::size_t>(max_particles) &&
         are_numbers(shape.points) && std::all_of(shape.faces.begin(), shape.faces.end(), is_face) &&
         std::all_of(shape.lines.begin(), shape.lines.end(), are_vertices) &&
         std::all_of(shape.tetrahedra.begin(), shape.tetrahedra.end(), are_vertices);
}

/// Replaces valid mesh data by those of one point, since writing and parsing a large mesh takes longer than the rest of
/// the set-up.
void shorten(Shape& shape) {
  auto* const data = std::get_if<MeshDataShape>(&shape);
  if (!data || !is_valid(*data)) return;
  const bool faces = !data->faces.empty(), loose = data->loose();
  *data = {{{0, 0, 0}}, {}, {}, {}};
  if (faces) data->faces = {{0, 0, 0, -1}};
  if (!loose && !faces) data->lines = {{0, 0}};
}

/// The same for the points of a rest shape.
void shorten(std::optional<RestSpec>& rest) {
  auto* const listed = rest ? std::get_if<RestPoints>(&*rest) : nullptr;
  if (listed && are_numbers(listed->points)) listed->points.clear();
}

}  // namespace

void check_scene(const Scene& scene) {
  Scene small = scene;
  for (BodySpec& body : small.bodies) shorten(body.shape), shorten(body.rest);
  for (EnvironmentSpec& object : small.environment) shorten(object.shape);
  read_scene(write_scene(std::move(small), ""), scene.file, "");
}

}  // namespace malha
