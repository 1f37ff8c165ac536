// SPDX-License-Identifier: Apache-2.0
#include "host/scene/check_scene.h"

#include <algorithm>
#include <cmath>

#include "host/scene/scene_read.h"

namespace malha {

namespace {

/// Whether the parser takes it: whether its corners are points is asked when the mesh is made.
bool is_sound(const MeshDataShape& shape) {
  const auto is_number = [](double number) { return std::abs(number) <= largest_number; };
  const auto are_numbers = [&](const Vec3& point) { return std::all_of(point.begin(), point.end(), is_number); };
  const auto are_vertices = [](const auto& corners) {
    return std::all_of(corners.begin(), corners.end(), [](int i) { return i >= 0; });
  };
  const auto is_face = [&](const Quad& face) { return face[0] >= 0 && face[1] >= 0 && face[2] >= 0 && face[3] >= -1; };
  return !shape.points.empty() && shape.points.size() <= static_cast<std::size_t>(max_particles) &&
         std::all_of(shape.points.begin(), shape.points.end(), are_numbers) &&
         std::all_of(shape.faces.begin(), shape.faces.end(), is_face) &&
         std::all_of(shape.lines.begin(), shape.lines.end(), are_vertices) &&
         std::all_of(shape.tetrahedra.begin(), shape.tetrahedra.end(), are_vertices);
}

/// A sound mesh as text and back takes longer than all the rest of a set-up: one of a point stands for it.
void shorten(Shape& shape) {
  auto* const listed = std::get_if<MeshDataShape>(&shape);
  if (!listed || !is_sound(*listed)) return;
  const bool faces = !listed->faces.empty(), loose = listed->loose();
  *listed = {{{0, 0, 0}}, {}, {}, {}};
  if (faces) listed->faces = {{0, 0, 0, -1}};
  if (!loose && !faces) listed->lines = {{0, 0}};
}

}  // namespace

void check_scene(const Scene& scene) {
  Scene small = scene;
  for (BodySpec& body : small.bodies) shorten(body.shape);
  for (EnvironmentSpec& object : small.environment) shorten(object.shape);
  parse_scene(to_json(small), scene.file, "");
}

}  // namespace malha
