// SPDX-License-Identifier: Apache-2.0
// PointCache2 writer: one growing file of samples, and the mesh at rest beside it for Blender's or Maya's mesh cache.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "host/animation/point_cache.h"
#include "host/base/file.h"
#include "host/base/mapped_file.h"
#include "host/output/frame_formats.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// Writes loose and unused points as lines of no length. Blender ignores "p" elements and drops vertices that no
/// element uses, and the cache would no longer match.
std::string elements(FrameTopology topology) {
  for (const auto* points : {&topology.loose, &topology.unused})
    for (const int point : *points) topology.lines.push_back({point, point});
  topology.loose.clear();
  return obj_elements(topology);
}

class Pc2 : public FrameFormat {
 public:
  Pc2(const fs::path& folder, const FrameTopology& topology, int next)
      : path_(folder / "points.pc2"), points_(topology.rest.size()), first_(next) {
    write_whole(folder / "rest.obj", obj_text(topology.rest, topology.in_double, elements(topology)));
    if (next > 0 && fs::exists(path_)) {
      resume(next);
    } else {
      PointCacheHeader header{{}, 1, static_cast<std::int32_t>(points_), static_cast<float>(next), 1, 0};
      std::memcpy(header.signature, kPointCache, sizeof kPointCache);
      write_whole(path_, bytes_of(header));
    }
  }

  /// Writes the sample before the count, so that an interrupted write only leaves unused bytes after the last sample.
  void write(const Frame& frame) override {
    const std::int32_t sample = frame.index - first_, count = sample + 1;
    bytes_.clear();
    for (const Vec3& x : frame.points) append(bytes_, x, false);
    overwrite(path_, {{bytes(sample), bytes_}, {offsetof(PointCacheHeader, samples), bytes_of(count)}});
  }

 private:
  std::uintmax_t bytes(int samples) const {
    return sizeof(PointCacheHeader) + 12 * static_cast<std::uintmax_t>(samples) * points_;
  }

  void resume(int next) {
    PointCacheHeader header{};
    if (const MappedFile file(path_); file.bytes().size() >= sizeof header)
      std::memcpy(&header, file.bytes().data(), sizeof header);
    first_ = static_cast<int>(header.first_frame);
    const bool ours = std::memcmp(header.signature, kPointCache, sizeof kPointCache) == 0 &&
                      header.points == static_cast<std::int32_t>(points_) && header.frames_per_sample == 1;
    const std::int32_t keep = next - first_;
    if (!ours || keep < 0 || keep > header.samples)
      throw std::runtime_error(
          path_.string() + ": does not continue at frame " + std::to_string(next) + ": found " +
          (ours ? "frames " + std::to_string(first_) + " to " + std::to_string(first_ + header.samples - 1)
                : "no point cache of " + std::to_string(points_) + " points"));
    overwrite(path_, {{offsetof(PointCacheHeader, samples), bytes_of(keep)}});
    fs::resize_file(path_, bytes(keep));
  }

  fs::path path_;
  std::size_t points_;
  int first_;          // index of the frame of sample 0
  std::string bytes_;  // of the last frame; kept, because new memory pages cost more than the copies
};

}  // namespace

std::unique_ptr<FrameFormat> make_pc2(const fs::path& folder, const FrameTopology& topology, int next) {
  return std::make_unique<Pc2>(folder, topology, next);
}

}  // namespace malha
