// SPDX-License-Identifier: Apache-2.0
// PointCache2 writer: a growing file of samples for each mesh, and the meshes at rest beside them, for Blender's or
// Maya's mesh cache.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <set>
#include <stdexcept>

#include "host/animation/point_cache.h"
#include "host/base/file.h"
#include "host/base/mapped_file.h"
#include "host/output/frame_formats.h"
#include "host/output/materials.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

/// One file of the samples of one mesh.
class PointCache {
 public:
  PointCache(const fs::path& path, std::size_t points, int next) : path_(path), points_(points), first_(next) {
    if (next > 0 && fs::exists(path_)) {
      resume(next);
    } else {
      PointCacheHeader header{{}, 1, static_cast<std::int32_t>(points_), static_cast<float>(next), 1, 0};
      std::memcpy(header.signature, kPointCache, sizeof kPointCache);
      write_whole(path_, bytes_of(header));
    }
  }

  /// Writes the sample before the count, so that an interrupted write only leaves unused bytes after the last sample.
  void write(int frame, std::span<const Vec3> points) {
    const std::int32_t sample = frame - first_, count = sample + 1;
    bytes_.clear();
    for (const Vec3& x : points) append(bytes_, x, false);
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

/// The meshes at rest as OBJ, and a point cache for each.
class Pc2 : public FrameFormat {
 public:
  Pc2(const fs::path& folder, const FrameTopology& topology, int next) : topology_(topology) {
    write_mtl(folder, topology);
    write_whole(folder / "rest.obj", ObjDocument(topology, ObjDocument::LoosePoints::AsLines).text(topology.rest));
    std::set<std::string> names;
    for (std::size_t m = 0; m < topology.meshes.size(); ++m)
      caches_.emplace_back(folder / ("points_" + file_stem(topology.meshes[m].name, names) + ".pc2"),
                           points_of(topology, m, topology.rest).size(), next);
  }

  void write(const Frame& frame) override {
    for (std::size_t m = 0; m < caches_.size(); ++m)
      caches_[m].write(frame.index, points_of(topology_, m, frame.points));
  }

 private:
  FrameTopology topology_;
  std::vector<PointCache> caches_;
};

}  // namespace

std::string file_stem(const std::string& name, std::set<std::string>& names) {
  std::string stem = name.empty() || name[0] == '.' ? "_" + name : name;
  for (char& letter : stem)
    if (static_cast<unsigned char>(letter) < ' ' || std::strchr("/\\:*?\"<>|", letter)) letter = '_';
  while (!names.insert(stem).second) stem += '_';
  return stem;
}

std::unique_ptr<FrameFormat> make_pc2(const fs::path& folder, const FrameTopology& topology, int next) {
  return std::make_unique<Pc2>(folder, topology, next);
}

}  // namespace malha
