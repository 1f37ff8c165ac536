// SPDX-License-Identifier: Apache-2.0
// Immutable state of a simulation at one time for display; the solver's thread makes it.
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
#include "tools/view/decimated_mesh.h"

namespace malha::view {

inline constexpr std::size_t kManyTriangles = 400'000;  // above this, drawing is simplified

/// Meshes that frames share; a new one after each tear and each change of the scene.
struct Body {
  RenderMesh mesh;  // in the user's numbering
  std::vector<std::array<unsigned, 3>> triangles;
  std::vector<std::array<unsigned, 2>> edges;  // of faces and lines
  std::vector<unsigned> loose;                 // particles in no face and no line
  std::vector<unsigned> pinned;                // at the start
  double spacing = 0;                          // m, the mean length of the edges at the start
  std::optional<DecimatedMesh> decimated;      // of bodies with very many triangles, for drawing without a GPU
};

struct Frame {
  std::int64_t steps = 0;
  int substep = 0;  // of the next step, from 1, when substeps are shown; 0 after a whole step
  double time = 0;  // s
  std::shared_ptr<const Body> body;
  std::shared_ptr<const std::vector<EnvironmentMesh>> environment;
  std::vector<Point3f> x;                           // m, the user's order
  std::vector<float> speed;                         // m/s
  std::optional<Measures> measures;                 // only of some frames
  double step_ms = 0;                               // duration of the last step
  std::array<double, kPassNames.size()> pass_ms{};  // durations of its passes
};

}  // namespace malha::view
