// SPDX-License-Identifier: Apache-2.0
// Parts of a glTF file: the frames that it collects, and the JSON chunk that describes its binary chunk.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/output/frames.h"

namespace malha {

inline constexpr int kPoseNumbers = 7;  // of a pose: a translation and a quaternion x y z w

/// Header of the part file, and of the binary chunk of every .glb that malha writes, so that a run can resume from
/// either. The frames follow, each of floats: its time (s), the poses of rigid objects that move, and the displacement
/// of each vertex of bodies and of objects that deform from the base mesh (m).
struct GlbHeader {
  char signature[8];
  std::int32_t vertices, moving;  // objects that move rigidly
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

using Float3 = std::array<float, 3>;

/// Points relative to the centre of their bounding box, where their node is placed. Floats are then precise enough for
/// a small body far from the origin.
struct CentredPoints {
  Float3 middle;               // m
  std::vector<Float3> points;  // m, from `middle`
};
CentredPoints centred(std::span<const Vec3> points);

/// Returns the points of a body.
template <class Points>
auto points_of(const FrameTopology& topology, std::size_t body, Points&& points) {
  const std::size_t begin = topology.bodies[body].begin;
  const bool last = body + 1 == topology.bodies.size();
  const std::size_t end = last ? topology.rest.size() : topology.bodies[body + 1].begin;
  return std::span(points).subspan(begin, end - begin);
}

struct GlbText {
  std::string json;
  std::string rest;  // the binary chunk after the frames
};

/// Builds the JSON and the rest of the binary chunk. `frames`: the bytes of a GlbPart with at least one frame. Throws
/// std::logic_error if malha was built without tinygltf.
GlbText glb_text(const FrameTopology& topology, std::string_view frames);

}  // namespace malha
