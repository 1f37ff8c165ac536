// SPDX-License-Identifier: Apache-2.0
// Animations of tests, and what they sample.
#pragma once
#include <string>
#include <vector>

#include "host/animation/animation.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/weld.h"
#include "tests/scene_builders.h"

namespace malha {

/// An object whose shape is this file.
inline Scene animated_scene(const std::string& shape, const AnimationSpec& animation) {
  EnvironmentSpec object = obstacle("walker", MeshFile{shape}, Sides::TwoSided);
  object.animation = animation;
  return scene_of({}, {object});
}

inline std::shared_ptr<const Animation> animation_of(const Scene& scene) {
  const auto& file = std::get<MeshFile>(scene.environment[0].shape);
  Mesh mesh = read_mesh(file.path);
  weld(mesh, file.weld.value_or(0), file.path);
  return load_animation(scene, 0, mesh);
}

inline std::vector<Vec3> sampled(const Animation& animation, double time) {
  std::vector<Vec3> points(static_cast<std::size_t>(animation.vertex_count()));
  animation.sample(time, points);
  return points;
}

}  // namespace malha
