// SPDX-License-Identifier: Apache-2.0
// Sources of animations: what a file says of the positions of all vertices over its own time.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/mesh/affine.h"
#include "host/mesh/io/gltf.h"
#include "malha/mesh.h"
#include "malha/scene.h"

namespace malha {

/// Memory of a pose, which later ones use again. Threads that share an animation have one each.
struct PoseMemory {
  GltfPose pose, next;
  GltfMaps maps;
};

class AnimationSource {
 public:
  virtual ~AnimationSource() = default;

  virtual int vertex_count() const = 0;
  /// The time from the first pose to the last (s), or, with `loop`, until the first one comes again.
  virtual double duration(bool loop) const = 0;
  /// The positions at a time in [0, duration] (m), mapped by `map`.
  virtual void pose(double time, const Affine& map, std::span<Vec3> points, PoseMemory& memory) const = 0;

  /// Times at which the source has poses of its own (s).
  virtual std::vector<double> key_times() const = 0;
  /// "frame 3" or "0.25 s", for messages.
  virtual std::string name_of(double key_time) const = 0;
  /// The source of these vertices alone, in this order.
  virtual std::unique_ptr<AnimationSource> select(std::span<const int> vertices) const = 0;
};

/// A clip of a glTF file, for a part of its vertices. `scene_file` and `pointer` are the place of the animation in the
/// scene, for messages.
std::unique_ptr<AnimationSource> read_clip(const std::string& file, const MeshPart& part, const AnimationSpec& spec,
                                           const std::string& scene_file, const std::string& pointer);

/// A PointCache2 file, whose header says how many frames pass from one sample to the next. The number of its first
/// frame is not used: the first sample is at time 0.
std::unique_ptr<AnimationSource> read_point_cache(const std::string& file, double frames_per_second);

/// A part of the OBJ or PLY files of a folder, or of a pattern such as "walk_*.ply", in the order of their numbers.
/// `mesh` is the welded mesh of the shape, whose faces they must have.
std::unique_ptr<AnimationSource> read_series(const std::string& files, const MeshPart& part, double frames_per_second,
                                             const Mesh& mesh);

}  // namespace malha
