// SPDX-License-Identifier: Apache-2.0
// PLY writer: one binary little-endian file a frame. Loose and unused points are vertices that no face and no edge
// uses.
#include "host/base/file.h"
#include "host/output/frame_formats.h"

namespace malha {

namespace {

class Ply : public FrameFormat {
 public:
  Ply(std::filesystem::path folder, const FrameTopology& topology)
      : folder_(std::move(folder)), in_double_(topology.in_double) {
    header_ = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(topology.rest.size()) + "\n";
    for (const char* name : {"x", "y", "z", "vx", "vy", "vz"})
      header_ += std::string("property ") + (in_double_ ? "double " : "float ") + name + "\n";
    if (!topology.faces.empty()) {
      header_ += "element face " + std::to_string(topology.faces.size()) + "\nproperty list uchar int vertex_indices\n";
    }
    if (!topology.lines.empty()) {
      header_ +=
          "element edge " + std::to_string(topology.lines.size()) + "\nproperty int vertex1\nproperty int vertex2\n";
    }
    header_ += "end_header\n";
    for (const auto& face : topology.faces) {
      const std::size_t corners = is_triangle(face) ? 3 : 4;
      elements_ += static_cast<char>(corners);
      append_all(elements_, std::span<const int>(face).first(corners));
    }
    append_all(elements_, std::span(topology.lines));
  }

  void write(const Frame& frame) override {
    bytes_ = header_;
    for (std::size_t i = 0; i < frame.points.size(); ++i) {
      append(bytes_, frame.points[i], in_double_);
      append(bytes_, frame.velocities[i], in_double_);
    }
    bytes_ += elements_;
    write_whole(folder_ / frame_name(frame.index, ".ply"), bytes_);
  }

 private:
  std::filesystem::path folder_;
  bool in_double_;
  std::string header_, elements_;  // the same in every frame
  std::string bytes_;              // of the last frame; kept, because new memory pages cost more than the copies
};

}  // namespace

std::unique_ptr<FrameFormat> make_ply(const std::filesystem::path& folder, const FrameTopology& topology, int next) {
  drop_frames(folder, ".ply", next);
  return std::make_unique<Ply>(folder, topology);
}

}  // namespace malha
