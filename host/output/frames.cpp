// SPDX-License-Identifier: Apache-2.0
#include "host/output/frames.h"

#include <charconv>
#include <cstdio>
#include <stdexcept>

#include "host/base/file.h"
#include "host/output/frame_formats.h"

namespace malha {

namespace fs = std::filesystem;

std::string frame_name(int index, const std::string& extension) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%06d", index);
  return name + extension;
}

int frame_index(const std::string& name, const std::string& extension) {
  constexpr std::size_t kPrefix = 6;  // "frame_"
  if (name.size() <= kPrefix + extension.size()) return -1;
  int index = -1;
  std::from_chars(name.data() + kPrefix, name.data() + name.size() - extension.size(), index);
  return index >= 0 && frame_name(index, extension) == name ? index : -1;
}

void drop_frames(const fs::path& folder, const std::string& extension, int next) {
  std::vector<fs::path> late;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (frame_index(entry.path().filename().string(), extension) >= next) late.push_back(entry.path());
  }
  for (const auto& path : late) fs::remove(path);
}

namespace {

std::unique_ptr<FrameFormat> make(const std::string& format, const fs::path& folder, const FrameTopology& topology,
                                  int next) {
  if (format == "vtp") return make_vtp(folder, topology, next);
  if (format == "pc2") return make_pc2(folder, topology, next);
  if (format == "ply") return make_ply(folder, topology, next);
  if (format == "obj") return make_obj(folder, topology, next);
  if (format == "usda") return make_usda(folder, topology, next);
  if (format == "glb") return make_glb(folder, topology, next);
  throw std::invalid_argument("unknown frame format \"" + format + "\"");
}

}  // namespace

FrameWriter::FrameWriter(const fs::path& folder, const std::vector<std::string>& formats, const FrameTopology& topology,
                         int next)
    : point_count_(topology.rest.size()), next_(next) {
  make_folder(folder);
  for (const auto& format : formats) formats_.push_back(make(format, folder, topology, next));
}

FrameWriter::FrameWriter(FrameWriter&&) noexcept = default;
FrameWriter& FrameWriter::operator=(FrameWriter&&) noexcept = default;
FrameWriter::~FrameWriter() = default;

void FrameWriter::write(double time, std::span<const Vec3> points, std::span<const Vec3> velocities) {
  if (points.size() != point_count_ || velocities.size() != point_count_) {
    throw std::invalid_argument("a frame of " + std::to_string(points.size()) + " points and " +
                                std::to_string(velocities.size()) + " velocities; expected " +
                                std::to_string(point_count_) + " of each");
  }
  for (const auto& format : formats_) format->write({next_, time, points, velocities});
  ++next_;
}

void FrameWriter::finish() {
  for (const auto& format : formats_) format->finish();
}

}  // namespace malha
