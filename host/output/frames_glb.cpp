// SPDX-License-Identifier: Apache-2.0
// glTF 2.0 writer: one binary file of the bodies, the environment and all frames, for browsers, Blender and other
// viewers. Layout: 12 bytes of header, a JSON chunk, a binary chunk. The binary chunk begins with the contents of a
// GlbPart.
#include <Eigen/Geometry>
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
        part_(path_, topology.rest.size() + deforming_vertices(topology.environment),
              static_cast<std::size_t>(std::ranges::count_if(topology.environment, moves_rigidly)), next) {
    for (std::size_t b = 0; b < topology.bodies.size(); ++b)
      bodies_.push_back(centred(points_of(topology, b, topology.rest)));
    for (const EnvironmentMesh& object : topology.environment) {
      if (moves_rigidly(object)) moving_.push_back({&object.spec.motion, centred(object.mesh.points).middle});
      if (deforms(object)) deforming_.push_back({&object, centred(object.mesh.points)});
    }
  }

  void write(const Frame& frame) override {
    numbers_.assign(1, static_cast<float>(frame.time));
    for (const Moving& object : moving_) add_pose(object, frame.time);
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      add_displacements(points_of(topology_, b, frame.points), bodies_[b]);
    for (const auto& [object, base] : deforming_) add_displacements(points_at(*object, frame.time), base);
    part_.write(numbers_);
  }

  void finish() override {
    if (!part_.empty()) assemble();
    fs::remove(part_.path());
  }

 private:
  struct Moving {
    const std::vector<Keyframe>* motion;
    Float3 middle;
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

  void add_pose(const Moving& object, double time) {
    const Pose pose = pose_at(*object.motion, time);
    const auto at = to_world(pose, {object.middle[0], object.middle[1], object.middle[2]});
    const Eigen::Matrix3d turn = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.r);
    const Eigen::Vector4d quaternion = Eigen::Quaterniond(turn).normalized().coeffs();
    for (const double x : {at.x, at.y, at.z, quaternion[0], quaternion[1], quaternion[2], quaternion[3]})
      numbers_.push_back(static_cast<float>(x));
  }

  void assemble() const {
    const MappedFile part(part_.path());
    const GlbHeader header = glb_header(part.bytes());
    const std::string_view frames = part.bytes().substr(0, header.bytes(header.count));
    GlbText text = glb_text(topology_, frames);
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
  GlbPart part_;
  std::vector<CentredPoints> bodies_;
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
