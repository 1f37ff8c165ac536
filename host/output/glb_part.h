// SPDX-License-Identifier: Apache-2.0
// Frames of a glTF file that is not complete yet.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "malha/mesh.h"

namespace malha {

inline constexpr int kPoseNumbers = 7;  // of a pose: a translation and a quaternion x y z w

/// Header of the part file, and of the binary chunk of every .glb that malha writes, so that a run can resume from
/// either. The frames follow, each of floats: its time (s), the poses of moving objects, and the displacement of each
/// vertex from the base mesh (m).
struct GlbHeader {
  char signature[8];
  std::int32_t vertices, moving;  // objects that move
  std::int32_t first, count;      // frames

  std::size_t numbers() const {  // of a frame
    return 1 + kPoseNumbers * static_cast<std::size_t>(moving) + 3 * static_cast<std::size_t>(vertices);
  }
  std::size_t bytes(int frames) const { return sizeof *this + 4 * numbers() * static_cast<std::size_t>(frames); }
};
static_assert(sizeof(GlbHeader) == 24);

/// The file "run.glb.part" beside "run.glb" that collects frames as they come, because a .glb describes all its frames
/// before the first.
class GlbPart {
 public:
  /// Keeps the frames of an earlier part of the run, up to `next`, from either file. Throws std::runtime_error if there
  /// is such a file, but none that continues at `next`.
  GlbPart(const std::filesystem::path& glb, std::size_t vertices, std::size_t moving, int next);

  const std::filesystem::path& path() const { return path_; }
  bool empty() const { return header_.count == 0; }
  /// Appends the numbers of one frame. Throws std::runtime_error (disk) and keeps the frames before.
  void write(std::span<const float> frame);

 private:
  bool resume_from(const std::filesystem::path& from, int next);

  std::filesystem::path path_;
  GlbHeader header_;
};

/// Returns the header at the beginning of these bytes; one of no frames if there is none.
GlbHeader glb_header(std::string_view bytes);

/// Returns the contents of the binary chunk of a .glb; "" if there is none.
std::string_view glb_binary(std::string_view file);

}  // namespace malha
