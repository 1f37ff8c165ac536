// SPDX-License-Identifier: Apache-2.0
// Frames of a run that are collected for a file which can be written only at its end.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "host/output/frames.h"

namespace malha {

inline constexpr int kPoseNumbers = 7;  // of a pose: a translation and a quaternion x y z w

/// Header of the part file, and of the binary chunk of every .glb that malha writes, so that a run can resume from
/// either. The frames follow, each of floats: its time (s), the poses of rigid objects that move, and three numbers (m)
/// of each vertex of bodies and of objects that deform: in glTF its displacement from the base mesh, in USD its place.
struct FramePartHeader {
  char signature[8];
  std::int32_t vertices, moving;  // objects that move rigidly
  std::int32_t first, count;      // frames

  std::size_t numbers() const {  // of a frame
    return 1 + kPoseNumbers * static_cast<std::size_t>(moving) + 3 * static_cast<std::size_t>(vertices);
  }
  std::size_t bytes(int frames) const { return sizeof *this + 4 * numbers() * static_cast<std::size_t>(frames); }
};
static_assert(sizeof(FramePartHeader) == 24);

/// The file "run.glb.part" beside "run.glb", or "run.usda.part", that collects frames as they come: a .glb describes
/// all its frames before the first, and a .usda has those of one mesh after those of another.
class FramePart {
 public:
  /// Keeps the frames of an earlier part of the run, up to `next`, from either file. Throws std::runtime_error if there
  /// is such a file, but none that continues at `next`.
  FramePart(const std::filesystem::path& file, std::size_t vertices, std::size_t moving, int next);

  const std::filesystem::path& path() const { return path_; }
  bool empty() const { return header_.count == 0; }
  /// Appends the numbers of one frame. Throws std::runtime_error (disk) and keeps the frames before.
  void write(std::span<const float> frame);

 private:
  bool resume_from(const std::filesystem::path& from, int next);

  std::filesystem::path path_;
  FramePartHeader header_;
};

/// Returns the header at the beginning of these bytes; one of no frames if there is none.
FramePartHeader frame_part_header(std::string_view bytes);

/// Appends the pose at a time (s) of an object that moves rigidly: where its point `middle` is, and its rotation.
void append_pose(std::vector<float>& numbers, const EnvironmentMesh& object, const Vec3& middle, double time);

/// Number of objects that move rigidly.
std::size_t moving_objects(std::span<const EnvironmentMesh> environment);

}  // namespace malha
