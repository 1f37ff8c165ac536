// SPDX-License-Identifier: Apache-2.0
// Animations: the vertices of an environment object over the time of the simulation.
#pragma once
#include <cstddef>
#include <memory>
#include <span>

#include "host/animation/animation_source.h"

namespace malha {

/// The points of an animated mesh over time. It does not change once it is made, so that threads may share it.
class Animation {
 public:
  /// Maps the points of `source` by `map`. The spec says when they are where.
  Animation(std::unique_ptr<const AnimationSource> source, const AnimationSpec& spec, const Affine& map);

  int vertex_count() const { return source_->vertex_count(); }
  /// The time of the simulation from the first pose to the last (s), or, of a loop, until the first comes again.
  double duration() const { return source_->duration(spec_.loop) / spec_.speed; }
  /// The positions at `time` (s of the simulation), in m: as many as there are vertices.
  void sample(double time, std::span<Vec3> points, PoseMemory& memory) const;
  void sample(double time, std::span<Vec3> points) const;
  /// The animation of these vertices alone, in this order.
  std::shared_ptr<const Animation> select(std::span<const int> vertices) const;

 private:
  std::unique_ptr<const AnimationSource> source_;
  AnimationSpec spec_;
  Affine map_;
};

/// The animation of scene.environment[index], which has one that is not from code, for the points of its mesh.
/// `mesh` is welded, and still has the numbers of its file. The object's transform is applied to every pose. Throws
/// InputError.
std::shared_ptr<const Animation> load_animation(const Scene& scene, std::size_t index, const Mesh& mesh);

}  // namespace malha
