// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 writer: one binary file of the bodies, the environment and all frames, for browsers, Blender and other
// viewers. Layout: 12 bytes of header, a JSON chunk, a binary chunk. The binary chunk begins with the contents of a
// FramePart.
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "host/attachments/object_motion.h"
#include "host/base/file.h"
#include "host/base/mapped_file.h"
#include "host/base/memory_size.h"
#include "host/output/frame_formats.h"
#include "host/output/glb.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

class Glb : public FrameFormat {
 public:
  Glb(const fs::path& folder, const FrameTopology& topology, int next)
      : path_(folder / "run.glb"),
        topology_(topology),
        vertices_(glb_vertices(topology)),
        part_(path_, vertices_.point.size() + deforming_vertices(topology.environment),
              moving_objects(topology.environment), next) {
    for (std::size_t m = 0; m < topology.meshes.size(); ++m)
      meshes_.push_back(centred(vertices_.gathered(m, topology.rest)));
    for (const EnvironmentMesh& object : topology.environment) {
      if (moves_rigidly(object)) {
        const Float3 middle = centred(object.mesh.points).middle;
        moving_.push_back({&object, {middle[0], middle[1], middle[2]}});
      }
      if (deforms(object)) deforming_.push_back({&object, centred(object.mesh.points)});
    }
  }

  void write(const Frame& frame) override {
    numbers_.assign(1, static_cast<float>(frame.time));
    for (const auto& [object, middle] : moving_) append_pose(numbers_, *object, middle, frame.time);
    for (std::size_t m = 0; m < meshes_.size(); ++m) add_displacements(vertices_.gathered(m, frame.points), meshes_[m]);
    for (const auto& [object, base] : deforming_) add_displacements(points_at(*object, frame.time), base);
    part_.write(numbers_);
  }

  void finish() override {
    if (!part_.empty()) assemble();
    fs::remove(part_.path());
  }

 private:
  struct Moving {
    const EnvironmentMesh* object;
    Vec3 middle;
  };

  struct Deforming {
    const EnvironmentMesh* object;
    CentredPoints base;
  };

  void add_displacements(std::span<const Vec3> points, const CentredPoints& base) {
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        numbers_.push_back(static_cast<float>(points[i][k] - base.middle[k] - base.points[i][k]));
  }

  void assemble() const {
    const MappedFile part(part_.path());
    const FramePartHeader header = frame_part_header(part.bytes());
    const std::string_view frames = part.bytes().substr(0, header.bytes(header.count));
    GlbText text = glb_text(topology_, vertices_, frames);
    text.json.resize((text.json.size() + 3) / 4 * 4, ' ');
    const std::uint64_t binary = frames.size() + text.rest.size();
    const std::uint64_t all = 12 + 8 + text.json.size() + 8 + binary;
    if (all > std::numeric_limits<std::uint32_t>::max())
      throw std::runtime_error(path_.string() + ": cannot write: " + std::to_string(all) +
                               " bytes are more than glTF counts");
    const auto number = [](std::string& bytes, std::uint64_t value) {
      append(bytes, static_cast<std::uint32_t>(value));
    };
    std::string before = "glTF", between;
    for (const std::uint64_t value : {std::uint64_t{2}, all, std::uint64_t{text.json.size()}}) number(before, value);
    before += "JSON";
    number(between, binary);
    between.append("BIN\0", 4);
    write_whole(path_, {before, text.json, between, frames, text.rest});
  }

  fs::path path_;
  FrameTopology topology_;
  GlbVertices vertices_;
  FramePart part_;
  std::vector<CentredPoints> meshes_;
  std::vector<Moving> moving_;
  std::vector<Deforming> deforming_;
  std::vector<float> numbers_;  // of the last frame; kept, because new memory pages cost more than the copies
};

}  // namespace

std::size_t deforming_vertices(std::span<const EnvironmentMesh> environment) {
  std::size_t sum = 0;
  for (const EnvironmentMesh& object : environment)
    if (deforms(object)) sum += object.mesh.points.size();
  return sum;
}

void check_glb(const Scene& scene, std::size_t points, std::int64_t frames) {
  constexpr double kMostFrames =
      2000;                           // browsers hold each morph target in a layer of a texture, which has at most 2048
  constexpr double kMostBytes = 4e9;  // 2^32, less the data besides frames
  const double bytes = 12.0 * static_cast<double>(points) * static_cast<double>(frames);
  const auto check = [&](double found, double most, const std::string& as_text, const std::string& most_as_text) {
    if (found > most)
      refuse(scene.file, "/outputs/frames/every",
             std::to_string(scene.outputs.every) + ", with which glb has " + as_text,
             "what leads to at most " + most_as_text + " in one file");
  };
  check(static_cast<double>(frames), kMostFrames, counted(frames, "frame"), "2000");
  check(bytes, kMostBytes, in_gib(bytes) + " of frames", in_gib(kMostBytes));
}

std::unique_ptr<FrameFormat> make_glb(const fs::path& folder, const FrameTopology& topology, int next) {
  return std::make_unique<Glb>(folder, topology, next);
}

}  // namespace malha
