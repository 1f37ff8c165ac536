// SPDX-License-Identifier: Apache-2.0
// Renderer of frames by OpenGL 3.3.
#pragma once
#include <deque>
#include <memory>
#include <vector>

#include "host/render/image.h"
#include "tools/view/gl.h"
#include "tools/view/shown_state.h"

namespace malha::view {

using Colour = std::array<unsigned char, 3>;  // sRGB

enum class Surface { Shaded, Wireframe, Particles };

/// Thin lines, and balls, drawn beside bodies.
struct Marks {
  std::vector<Point3f> lines;  // two points a line
  std::vector<Colour> line_colours;
  std::vector<Point3f> balls;
  std::vector<Colour> ball_colours;
};

struct Picture {
  const Frame* frame = nullptr;
  std::vector<Colour> colours;  // by particle
  Surface surface = Surface::Shaded;
  Marks marks;
  bool decimated = false;  // draws bodies with very many triangles decimated
};

/// Renderer of one side. It keeps GPU copies of data that does not change.
class Painter {
 public:
  Painter();
  ~Painter();

  /// Draws into a viewport of a window with this height (pixels).
  void draw(const Picture& picture, const OrbitCamera& camera, const Viewport& port, int window_height);

 private:
  struct Shapes;
  struct Obstacle;
  struct Programs;

  void update(const Picture& picture);
  void show(const std::vector<Point3f>& x, const std::vector<Colour>& colours,
            const std::vector<std::array<unsigned, 3>>& triangles);
  void update_environment(const Frame& frame);
  Eigen::Matrix4d light(const Frame& frame) const;
  void draw_surfaces(const Picture& picture, const Program& program) const;
  void draw_lines_and_balls(const Picture& picture, const OrbitCamera& camera, const Viewport& port) const;

  std::unique_ptr<Programs> programs_;
  std::unique_ptr<Shapes> body_, marks_;
  std::deque<Obstacle> obstacles_;
  std::shared_ptr<const Body> built_;
  bool decimated_ = false;  // the GPU copies are of the decimated mesh
  bool smooth_ = true;      // smooth shading with a shadow; very many faces are shaded flat without one
  std::shared_ptr<const std::vector<EnvironmentMesh>> environment_;
  std::vector<Point3f> normals_;
};

/// Reads back the pixels of the whole window.
Image read_back(int width, int height);

}  // namespace malha::view
