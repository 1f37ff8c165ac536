// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ writer: one text file a frame.
#include <algorithm>
#include <array>

#include "host/base/file.h"
#include "host/output/frame_formats.h"
#include "host/output/materials.h"

namespace malha {

namespace {

void append_corners(std::string& text, char kind, std::span<const int> corners) {
  text += kind;
  for (const int corner : corners) text += ' ', append_number(text, corner + 1);
  text += '\n';
}

/// Appends what has changed since the polygon before, and the polygon.
void append_polygon(std::string& text, const FrameTopology& topology, std::size_t f, int& group, int& material) {
  const Polygons& polygons = topology.polygons;
  if (!polygons.groups.empty() && polygons.group[f] != group) {
    group = polygons.group[f];
    text += "g " + (group < 0 ? "default" : polygons.groups[static_cast<std::size_t>(group)]) + '\n';
  }
  if (!topology.materials.empty() && polygons.material[f] != material) {
    material = polygons.material[f];
    text += "usemtl " + (material < 0 ? "" : topology.materials[static_cast<std::size_t>(material)].name) + '\n';
  }
  text += 'f';
  for (int c = polygons.begin[f]; c < polygons.begin[f + 1]; ++c) {
    text += ' ';
    append_number(text, polygons.corners[static_cast<std::size_t>(c)] + 1);
    const int uv = polygons.uv_of(c);
    if (uv >= 0) text += '/' + std::to_string(uv + 1);
  }
  text += '\n';
}

class Obj : public FrameFormat {
 public:
  Obj(const std::filesystem::path& folder, const FrameTopology& topology) : folder_(folder), document_(topology) {
    write_mtl(folder, topology);
  }

  void write(const Frame& frame) override {
    write_whole(folder_ / frame_name(frame.index, ".obj"), document_.text(frame.points));
  }

 private:
  std::filesystem::path folder_;
  ObjDocument document_;
};

}  // namespace

ObjDocument::ObjDocument(const FrameTopology& topology, LoosePoints loose) : in_double_(topology.in_double) {
  const Polygons& polygons = topology.polygons;
  const auto append_points_in = [&](std::string& text, const std::vector<int>& points, int begin, int end) {
    for (auto at = std::ranges::lower_bound(points, begin); at != points.end() && *at < end; ++at)
      if (loose == LoosePoints::AsPoints)
        append_corners(text, 'p', std::array{*at});
      else
        append_corners(text, 'l', std::array{*at, *at});
  };
  for (std::size_t m = 0; m < topology.meshes.size(); ++m) {
    const FrameMesh& mesh = topology.meshes[m];
    const int end = mesh.begin + static_cast<int>(points_of(topology, m, topology.rest).size());
    Part part{static_cast<std::size_t>(end), "", ""};
    if (m == 0 && !topology.materials.empty()) part.before = std::string("mtllib ") + kMaterialFile + "\n";
    part.before += "o " + mesh.name + "\n";
    if (m == 0)
      for (const auto& uv : polygons.uv) {
        part.elements += "vt";
        for (const double x : uv) part.elements += ' ', append_number(part.elements, x);
        part.elements += '\n';
      }
    int group = -2, material = -2;  // those of the object before would hold on
    const auto [first, behind] = polygons_of(topology, m);
    for (std::size_t f = first; f < behind; ++f) append_polygon(part.elements, topology, f, group, material);
    for (const Edge& line : topology.lines)
      if (mesh.begin <= line[0] && line[0] < end) append_corners(part.elements, 'l', line);
    append_points_in(part.elements, topology.loose, mesh.begin, end);
    if (loose == LoosePoints::AsLines) append_points_in(part.elements, topology.unused, mesh.begin, end);
    parts_.push_back(std::move(part));
  }
}

std::string ObjDocument::text(std::span<const Vec3> points) const {
  std::string text;
  std::size_t size = points.size() * (in_double_ ? 60 : 36), point = 0;
  for (const Part& part : parts_) size += part.before.size() + part.elements.size();
  text.reserve(size);
  for (const Part& part : parts_) {
    text += part.before;
    for (; point < part.end; ++point) {
      text += 'v';
      for (const double x : points[point]) {
        text += ' ';
        in_double_ ? append_number(text, x) : append_number(text, static_cast<float>(x));
      }
      text += '\n';
    }
    text += part.elements;
  }
  return text;
}

std::unique_ptr<FrameFormat> make_obj(const std::filesystem::path& folder, const FrameTopology& topology, int next) {
  drop_frames(folder, ".obj", next);
  return std::make_unique<Obj>(folder, topology);
}

}  // namespace malha
