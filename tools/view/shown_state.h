// SPDX-License-Identifier: Apache-2.0
// What the window shows of a simulation at one time. Made by the solver's thread, and never changed afterwards.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "host/model/model.h"
#include "host/solver/solver.h"
#include "malha/measures.h"
#include "tools/view/camera.h"
#include "tools/view/coarse.h"

namespace malha::view {

inline constexpr std::size_t kManyTriangles = 400'000;  // more take long to draw

/// What does not change from frame to frame; another one after each tear and each change of the scene.
struct Body {
  RenderMesh look;  // by the user's numbers
  std::vector<std::array<unsigned, 3>> triangles;
  std::vector<std::array<unsigned, 2>> edges;  // of faces, and lines
  std::vector<unsigned> loose;                 // that belong to neither
  std::vector<unsigned> pinned;                // at the start
  double spacing = 0;                          // m, the mean length of the edges at the start
  std::optional<Coarse> coarse;                // of very many triangles, for pictures without a GPU
};

struct Frame {
  std::int64_t steps = 0;
  int substep = 0;  // of the next step, from 1, where it is looked at in parts; 0: the step is whole
  double time = 0;  // s
  std::shared_ptr<const Body> body;
  std::shared_ptr<const std::vector<EnvironmentMesh>> environment;
  std::vector<Place> x;                             // m, the user's order
  std::vector<float> speed;                         // m/s
  std::optional<Measures> measures;                 // not of every frame
  double step_ms = 0;                               // of the last step
  std::array<double, kPassNames.size()> pass_ms{};  // of its passes
};

}  // namespace malha::view
