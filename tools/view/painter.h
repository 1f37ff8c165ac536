// SPDX-License-Identifier: Apache-2.0
// Draws frames with OpenGL 3.3.
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
  std::vector<Place> lines;  // two a line
  std::vector<Colour> line_colours;
  std::vector<Place> balls;
  std::vector<Colour> ball_colours;
};

struct Picture {
  const Frame* frame = nullptr;
  std::vector<Colour> colours;  // of each particle
  Surface surface = Surface::Shaded;
  Marks marks;
  bool coarse = false;  // a body of very many triangles by few of its particles
};

/// What is drawn of one side. Keeps the GPU's copies of what does not change.
class Painter {
 public:
  Painter();
  ~Painter();

  /// Into this part of a window of so many pixels' height.
  void draw(const Picture& picture, const OrbitCamera& camera, const Viewport& port, int window_height);

 private:
  struct Shapes;
  struct Obstacle;
  struct Programs;

  void update(const Picture& picture);
  void show(const std::vector<Place>& x, const std::vector<Colour>& colours,
            const std::vector<std::array<unsigned, 3>>& triangles);
  void update_environment(const Frame& frame);
  Eigen::Matrix4d light(const Frame& frame) const;
  void draw_surfaces(const Picture& picture, const Program& program) const;
  void draw_lines_and_balls(const Picture& picture, const OrbitCamera& camera, const Viewport& port) const;

  std::unique_ptr<Programs> programs_;
  std::unique_ptr<Shapes> body_, marks_;
  std::deque<Obstacle> obstacles_;
  std::shared_ptr<const Body> built_;
  bool coarse_ = false;  // what is built
  bool smooth_ = true;   // with a shadow; very many faces are flat and cast none
  std::shared_ptr<const std::vector<EnvironmentMesh>> surroundings_;
  std::vector<Place> normals_;
};

/// What was drawn last, of the whole window.
Image read_back(int width, int height);

}  // namespace malha::view
