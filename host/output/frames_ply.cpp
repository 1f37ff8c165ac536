// SPDX-License-Identifier: Apache-2.0
// PLY writer: one binary little-endian file a frame. Loose and unused points are vertices that no face and no edge
// uses. Polygons have the numbers of their object, group and material, which comments name, and "texcoord": u and v of
// each corner, as MeshLab writes them.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>

#include "host/base/file.h"
#include "host/output/frame_formats.h"

namespace malha {

namespace {

class Ply : public FrameFormat {
 public:
  Ply(std::filesystem::path folder, const FrameTopology& topology)
      : folder_(std::move(folder)), in_double_(topology.in_double) {
    header_ = "ply\nformat binary_little_endian 1.0\n";
    add_comments("object", topology.meshes, &FrameMesh::name);
    add_comments("group", topology.polygons.groups, std::identity());
    add_comments("material", topology.materials, &FrameMaterial::name);
    header_ += "element vertex " + std::to_string(topology.rest.size()) + "\n";
    for (const char* name : {"x", "y", "z", "vx", "vy", "vz"})
      header_ += std::string("property ") + (in_double_ ? "double " : "float ") + name + "\n";
    if (topology.polygons.count() > 0) add_polygons(topology);
    if (!topology.lines.empty()) {
      header_ +=
          "element edge " + std::to_string(topology.lines.size()) + "\nproperty int vertex1\nproperty int vertex2\n";
    }
    header_ += "end_header\n";
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
  /// Adds names to the header, by whose numbers polygons refer to them.
  template <class Items, class Name>
  void add_comments(const std::string& what, const Items& items, Name name) {
    for (std::size_t i = 0; i < items.size(); ++i)
      header_ += "comment " + what + " " + std::to_string(i) + " " + std::invoke(name, items[i]) + "\n";
  }

  void add_polygons(const FrameTopology& topology) {
    const Polygons& polygons = topology.polygons;
    std::size_t most = 0;
    for (std::size_t f = 0; f < polygons.count(); ++f) most = std::max(most, polygons.corners_of(f).size());
    const bool has_uv = !polygons.uv.empty(), has_groups = !polygons.groups.empty();
    const bool in_bytes = 2 * most <= std::numeric_limits<std::uint8_t>::max();
    const std::string list = std::string("property list ") + (in_bytes ? "uchar " : "int ");
    header_ += "element face " + std::to_string(polygons.count()) + "\n" + list + "int vertex_indices\n";
    if (has_uv) header_ += list + "float texcoord\n";
    if (topology.meshes.size() > 1) header_ += "property int object\n";
    if (has_groups) header_ += "property int group\n";
    if (!topology.materials.empty()) header_ += "property int material\n";

    const auto append_count = [&](std::size_t count) {
      in_bytes ? append(elements_, static_cast<std::uint8_t>(count))
               : append(elements_, static_cast<std::int32_t>(count));
    };
    const auto add_polygon = [&](std::size_t f, std::int32_t mesh) {
      const std::span<const int> corners = polygons.corners_of(f);
      append_count(corners.size());
      append_all(elements_, corners);
      if (has_uv) {
        append_count(2 * corners.size());
        for (int c = polygons.begin[f]; c < polygons.begin[f + 1]; ++c) {
          const int uv = polygons.uv_of(c);
          for (std::size_t k = 0; k < 2; ++k)
            append(elements_, uv < 0 ? 0.0f : static_cast<float>(polygons.uv[static_cast<std::size_t>(uv)][k]));
        }
      }
      if (topology.meshes.size() > 1) append(elements_, mesh);
      if (has_groups) append(elements_, std::int32_t{polygons.group[f]});
      if (!topology.materials.empty()) append(elements_, std::int32_t{polygons.material[f]});
    };
    for (std::size_t m = 0; m < topology.meshes.size(); ++m) {
      const auto [first, end] = polygons_of(topology, m);
      for (std::size_t f = first; f < end; ++f) add_polygon(f, static_cast<std::int32_t>(m));
    }
  }

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
