// SPDX-License-Identifier: Apache-2.0
// Pictures of a scene, ray-traced with Embree on the CPU: no GPU, no display. The same picture, bit for bit, on any
// number of threads.
#pragma once
#include <array>
#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "host/render/image.h"
#include "malha/scene.h"

namespace malha {

/// One thing to draw. Triangles with a corner that is not finite, and points and lines likewise, are left out.
struct Drawing {
  std::vector<std::array<float, 3>> points;  // m
  std::vector<Triangle> triangles;           // seen from both sides
  std::vector<unsigned char> hidden;  // one a triangle: bit k hides its edge from corner k to k + 1; empty: none hidden
  bool wire = false;                  // draws the edges that are not hidden as thin darker lines
  std::vector<Edge> lines;            // as round rods
  bool loose = false;                 // draws the points that no triangle and no line uses as balls
  std::array<float, 3> colour{0.7f, 0.7f, 0.7f};  // sRGB, [0, 1]
  std::string name;
};

/// Adds the faces' triangles; a quad a b c d becomes a b c, a c d with its diagonal hidden. Meshes of fewer than 3,000
/// faces get wires, so that one sees the cells.
void add_faces(Drawing& drawing, std::span<const Quad> faces);

/// Distinct colours for bodies 0, 1, 2, ... (they repeat after eight), and grey stone for what bodies fall on.
std::array<float, 3> body_colour(int body);
std::array<float, 3> stone_colour();

/// From the front, the right and above (y is up).
inline constexpr Vec3 kViewDirection{-0.55, -0.42, -0.85};

/// A camera that looks along `direction` and whose picture of width / height = `aspect` just holds all the points.
/// Points that are not finite are left out; without any, the default camera.
Camera frame_all(std::span<const std::array<float, 3>> points, double aspect = 16.0 / 9.0,
                 const Vec3& direction = kViewDirection);

/// The picture that the camera sees; after `stop`, where it is given, one without pixels. Throws std::invalid_argument
/// for a size below 1 x 1, std::runtime_error where Embree fails.
Image render(std::span<const Drawing> drawings, const Camera& camera, int width, int height, int threads,
             const std::atomic<bool>* stop = nullptr);

}  // namespace malha
