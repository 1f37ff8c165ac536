// SPDX-License-Identifier: Apache-2.0
#include "host/output/frame_part.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "host/attachments/object_motion.h"
#include "host/base/file.h"
#include "host/base/mapped_file.h"
#include "host/output/frame_formats.h"
#include "host/output/glb.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

constexpr char kPartSignature[8] = {'m', 'a', 'l', 'h', 'a', 'g', 'l', 'b'};

}  // namespace

FramePartHeader frame_part_header(std::string_view bytes) {
  FramePartHeader header{};
  if (bytes.size() < sizeof header) return {};
  std::memcpy(&header, bytes.data(), sizeof header);
  const bool ours = std::memcmp(header.signature, kPartSignature, sizeof kPartSignature) == 0 && header.vertices >= 0 &&
                    header.moving >= 0 && header.count >= 0 && header.bytes(header.count) <= bytes.size();
  return ours ? header : FramePartHeader{};
}

std::string_view glb_binary(std::string_view file) {
  constexpr std::size_t kFile = 12, kChunk = 8;  // bytes of the headers of file and chunk
  std::uint32_t json = 0;
  if (file.size() < kFile + kChunk || !file.starts_with("glTF")) return "";
  std::memcpy(&json, file.data() + kFile, sizeof json);
  const std::size_t begin = kFile + kChunk + json + kChunk;
  return begin <= file.size() ? file.substr(begin) : "";
}

FramePart::FramePart(const fs::path& file, std::size_t vertices, std::size_t moving, int next)
    : path_(file.string() + ".part"),
      header_{{}, static_cast<std::int32_t>(vertices), static_cast<std::int32_t>(moving), next, 0} {
  std::memcpy(header_.signature, kPartSignature, sizeof kPartSignature);
  if (next > 0 && (resume_from(path_, next) || resume_from(file, next))) return;
  if (next > 0 && (fs::exists(path_) || fs::exists(file)))
    throw std::runtime_error((fs::exists(path_) ? path_ : file).string() + ": does not continue at frame " +
                             std::to_string(next) + " of " + std::to_string(vertices) + " points");
  fs::remove(file);
  write_whole(path_, bytes_of(header_));
}

bool FramePart::resume_from(const fs::path& from, int next) {
  if (!fs::exists(from)) return false;
  const MappedFile file(from);
  const std::string_view bytes = from == path_ ? file.bytes() : glb_binary(file.bytes());
  FramePartHeader found = frame_part_header(bytes);
  const int keep = next - found.first;
  if (found.numbers() != header_.numbers() || found.vertices != header_.vertices || keep < 0 || keep > found.count)
    return false;
  found.count = keep, header_ = found;
  write_whole(path_, {bytes_of(header_), bytes.substr(sizeof header_, header_.bytes(keep) - sizeof header_)});
  return true;
}

/// Writes the frame before the count, so that an interrupted write only leaves unused bytes after the last frame.
void FramePart::write(std::span<const float> frame) {
  FramePartHeader after = header_;
  ++after.count;
  const std::string_view bytes(reinterpret_cast<const char*>(frame.data()), frame.size_bytes());
  overwrite(path_, {{header_.bytes(header_.count), bytes}, {0, bytes_of(after)}});
  header_ = after;
}

void append_pose(std::vector<float>& numbers, const EnvironmentMesh& object, const Vec3& middle, double time) {
  const Pose pose = pose_at(object.spec.motion, time);
  const auto at = to_world(pose, {middle[0], middle[1], middle[2]});
  const Eigen::Matrix3d turn = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.r);
  const Eigen::Vector4d quaternion = Eigen::Quaterniond(turn).normalized().coeffs();
  for (const double x : {at.x, at.y, at.z, quaternion[0], quaternion[1], quaternion[2], quaternion[3]})
    numbers.push_back(static_cast<float>(x));
}

std::size_t moving_objects(std::span<const EnvironmentMesh> environment) {
  return static_cast<std::size_t>(std::ranges::count_if(environment, moves_rigidly));
}

}  // namespace malha
