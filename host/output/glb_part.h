// SPDX-License-Identifier: Apache-2.0
// The frames of a glTF file that is not whole yet.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "malha/mesh.h"

namespace malha {

inline constexpr int kPoseNumbers = 7;  // a translation and a quaternion x y z w

/// The beginning of the file, and then of the binary chunk of every .glb of ours: that is how a run goes on from one.
/// Frame after frame follow: its time (s), the poses of the objects that move, and how far each vertex is from where
/// the base mesh has it (m); all of them floats.
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

/// "run.glb.part" beside "run.glb", where frames are put as they come: a .glb names all its frames before the first.
class GlbPart {
 public:
  /// The frames of an earlier part of the run, up to `next`, are taken from the one file or the other.
  /// Throws std::runtime_error where there is one of them, but none that continues at `next`.
  GlbPart(const std::filesystem::path& glb, std::size_t vertices, std::size_t moving, int next);

  const std::filesystem::path& path() const { return path_; }
  bool empty() const { return header_.count == 0; }
  /// Numbers of one frame. Throws std::runtime_error (disk); what was there before is then still there.
  void write(std::span<const float> frame);

 private:
  bool go_on(const std::filesystem::path& from, int next);

  std::filesystem::path path_;
  GlbHeader header_;
};

/// The header at the beginning of these bytes; one of no frames where there is none.
GlbHeader glb_header(std::string_view bytes);

/// What follows the JSON chunk of a .glb, but for its own header; "" where there is nothing.
std::string_view glb_binary(std::string_view file);

}  // namespace malha
