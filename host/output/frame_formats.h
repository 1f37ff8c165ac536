// SPDX-License-Identifier: Apache-2.0
// Interface and helpers of the frame formats; host/output/frames.h is the public interface.
#pragma once
#include <array>
#include <bit>
#include <charconv>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/output/frames.h"

namespace malha {

/// The data of one frame.
struct Frame {
  int index;
  double time;                       // s
  std::span<const Vec3> points;      // m
  std::span<const Vec3> velocities;  // m/s
};

/// One file format. The files are valid after the constructor and after every write. A format with a finish() of its
/// own completes its file there; a run that was killed before can still be resumed.
class FrameFormat {
 public:
  virtual ~FrameFormat() = default;
  virtual void write(const Frame& frame) = 0;
  virtual void finish() {}
};

static_assert(std::endian::native == std::endian::little, "the binary frame formats are written as they lie in memory");

std::unique_ptr<FrameFormat> make_vtp(const std::filesystem::path& folder, const FrameTopology& topology, int next);
std::unique_ptr<FrameFormat> make_pc2(const std::filesystem::path& folder, const FrameTopology& topology, int next);
std::unique_ptr<FrameFormat> make_ply(const std::filesystem::path& folder, const FrameTopology& topology, int next);
std::unique_ptr<FrameFormat> make_obj(const std::filesystem::path& folder, const FrameTopology& topology, int next);
std::unique_ptr<FrameFormat> make_usda(const std::filesystem::path& folder, const FrameTopology& topology, int next);
std::unique_ptr<FrameFormat> make_glb(const std::filesystem::path& folder, const FrameTopology& topology, int next);

/// Returns "frame_000012.vtp" for (12, ".vtp").
std::string frame_name(int index, const std::string& extension);

/// Returns the index in a name that frame_name made with this extension; -1 for any other name.
int frame_index(const std::string& name, const std::string& extension);

/// Returns the name of a mesh as a part of a file's name, different from `names`, to which it is added.
std::string file_stem(const std::string& name, std::set<std::string>& names);

/// Removes the frames of `extension` in `folder` whose index is `next` or more.
void drop_frames(const std::filesystem::path& folder, const std::string& extension, int next);

/// A frame in frames.pvd, the collection of .vtp files.
struct CollectedFrame {
  int index;
  double time;  // s
};
/// Returns the frames that frames.pvd in this folder lists; none if it is missing.
std::vector<CollectedFrame> collected_frames(const std::filesystem::path& folder);

/// The meshes as Wavefront OBJ text: each an object with its points, polygons, lines and loose points.
class ObjDocument {
 public:
  /// As lines of no length, points that no polygon and no line uses are vertices in programs that ignore "p" and drop
  /// what nothing uses.
  enum class LoosePoints { AsPoints, AsLines };

  explicit ObjDocument(const FrameTopology& topology, LoosePoints loose = LoosePoints::AsPoints);

  /// Returns the text with these points. Each number has the fewest digits that read back to the same double or float.
  std::string text(std::span<const Vec3> points) const;

 private:
  struct Part {
    std::size_t end;     // of its points
    std::string before;  // its name, and the first one's material files and texture coordinates
    std::string elements;
  };
  std::vector<Part> parts_;
  bool in_double_;
};

/// Appends a number with the fewest digits that read back to it.
template <class T>
void append_number(std::string& text, T value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

template <class T>
std::string_view bytes_of(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

template <class T>
void append(std::string& bytes, const T& value) {
  bytes += bytes_of(value);
}

template <class T>
void append_all(std::string& bytes, std::span<const T> values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

/// Appends three numbers as doubles or as floats.
inline void append(std::string& bytes, const Vec3& x, bool in_double) {
  if (in_double) return append(bytes, x);
  append(bytes, std::array{static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])});
}

}  // namespace malha
