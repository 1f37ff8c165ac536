// SPDX-License-Identifier: Apache-2.0
// Ray-traced pictures of a scene by Embree on the CPU, without a GPU or a display. The bits of a picture are the same
// on any number of threads.
#pragma once
#include <array>
#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "host/render/image.h"
#include "malha/scene.h"

namespace malha {

/// An object to draw. Triangles, lines and points with a corner that is not finite are left out.
struct Drawing {
  std::vector<std::array<float, 3>> points;  // m
  std::vector<Triangle> triangles;           // visible from both sides
  std::vector<unsigned char> hidden;  // one a triangle: bit k hides its edge from corner k to k + 1; empty: none hidden
  bool wire = false;                  // draws edges that are not hidden as thin darker lines
  std::vector<Edge> lines;            // drawn as round rods
  bool loose = false;                 // draws points that no triangle and no line uses as balls
  std::array<float, 3> colour{0.7f, 0.7f, 0.7f};  // sRGB, [0, 1]
  std::string name;
};

/// Adds the faces' triangles; a quad a b c d becomes a b c, a c d with its diagonal hidden. Meshes of fewer than 3,000
/// faces get wires, which show the cells.
void add_faces(Drawing& drawing, std::span<const Quad> faces);

/// Returns the linear RGB of an sRGB colour.
std::array<float, 3> linear_colour(const std::array<float, 3>& srgb);
/// Returns distinct colours of bodies 0, 1, 2, ... (they repeat after eight), and the grey of environment objects.
std::array<float, 3> body_colour(int body);
std::array<float, 3> stone_colour();

/// The default view: from the front, the right and above (y is up).
inline constexpr Vec3 kViewDirection{-0.55, -0.42, -0.85};

/// Returns a camera with view direction `direction` whose picture of width / height = `aspect` just contains all the
/// points. Points that are not finite are left out; without any it is the default camera.
Camera frame_all(std::span<const std::array<float, 3>> points, double aspect = 16.0 / 9.0,
                 const Vec3& direction = kViewDirection);

/// Renders the picture of the camera; returns one without pixels once `stop` is set. Throws std::invalid_argument for a
/// size below 1 x 1, std::runtime_error if Embree fails.
Image render(std::span<const Drawing> drawings, const Camera& camera, int width, int height, int threads,
             const std::atomic<bool>* stop = nullptr);

}  // namespace malha
