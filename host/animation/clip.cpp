// SPDX-License-Identifier: Apache-2.0
// Clips of glTF files: channels of keys, interpolated as the specification of glTF 2.0 says (appendix C).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "host/animation/animation_source.h"
#include "host/base/file.h"
#include "host/base/spelling_suggestion.h"
#include "host/mesh/io/gltf.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"

namespace malha {

namespace {

/// The rotation between a and b at the share s of the shorter way; both of unit length.
Quaternion slerp(const Quaternion& a, Quaternion b, double s) {
  double cosine = 0;
  for (std::size_t k = 0; k < 4; ++k) cosine += a[k] * b[k];
  if (cosine < 0)
    for (double& number : b) number = -number;
  const double angle = std::acos(std::min(std::abs(cosine), 1.0)), sine = std::sin(angle);
  const bool is_near = angle < 1e-6;  // where the sines cancel, the chord is the arc
  const double of_a = is_near ? 1 - s : std::sin((1 - s) * angle) / sine;
  const double of_b = is_near ? s : std::sin(s * angle) / sine;
  Quaternion between;
  for (std::size_t k = 0; k < 4; ++k) between[k] = of_a * a[k] + of_b * b[k];
  return between;
}

Quaternion unit(const double* q) {
  const double length = std::sqrt((q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3]));
  if (length == 0) return {0, 0, 0, 1};
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

/// Hermite's polynomial at the share s of an interval of `dt` seconds, from p with tangent m to q with tangent n.
double hermite(double s, double dt, double p, double m, double q, double n) {
  const double s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * p + dt * (s3 - 2 * s2 + s) * m + (-2 * s3 + 3 * s2) * q + dt * (s3 - s2) * n;
}

/// The value of a channel at a time; before the first key and after the last one it is theirs.
void evaluate(const GltfChannel& channel, double time, double* to) {
  const auto size = static_cast<std::size_t>(channel.size);
  const bool is_spline = channel.interpolation == GltfInterpolation::CubicSpline;
  const std::size_t stride = is_spline ? 3 * size : size, value = is_spline ? size : 0;
  const auto after = std::ranges::upper_bound(channel.times, time);
  const std::size_t i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - channel.times.begin(), 1)) - 1;
  const double* a = &channel.values[stride * i];
  if (channel.interpolation == GltfInterpolation::Step || time <= channel.times[i] || after == channel.times.end()) {
    std::copy_n(a + value, size, to);
    return;
  }
  const double* b = a + stride;
  const double dt = channel.times[i + 1] - channel.times[i], s = (time - channel.times[i]) / dt;
  if (is_spline)
    for (std::size_t k = 0; k < size; ++k) to[k] = hermite(s, dt, a[size + k], a[2 * size + k], b[size + k], b[k]);
  else if (channel.path == GltfPath::Rotation)
    std::ranges::copy(slerp(unit(a), unit(b), s), to);
  else
    for (std::size_t k = 0; k < size; ++k) to[k] = a[k] + s * (b[k] - a[k]);
}

void set_pose(const GltfClip& clip, double time, GltfPose& pose) {
  for (const GltfChannel& channel : clip.channels) {
    const auto target = static_cast<std::size_t>(channel.target);
    if (channel.path == GltfPath::Weights)
      evaluate(channel, time, &pose.weights[target]);
    else if (channel.path == GltfPath::Translation)
      evaluate(channel, time, pose.places[target].translation.data());
    else if (channel.path == GltfPath::Rotation)
      evaluate(channel, time, pose.places[target].rotation.data());
    else
      evaluate(channel, time, pose.places[target].scale.data());
  }
}

/// Blends a pose with another one at the share s.
void blend(GltfPose& between, const GltfPose& b, double s) {
  const auto mix = [s](double& x, double y) { x += s * (y - x); };
  for (std::size_t i = 0; i < between.places.size(); ++i) {
    GltfPlace& place = between.places[i];
    const GltfPlace& other = b.places[i];
    for (std::size_t k = 0; k < 3; ++k)
      mix(place.translation[k], other.translation[k]), mix(place.scale[k], other.scale[k]);
    place.rotation = slerp(unit(place.rotation.data()), unit(other.rotation.data()), s);
  }
  for (std::size_t i = 0; i < between.weights.size(); ++i) mix(between.weights[i], b.weights[i]);
}

/// The clip that the scene names, by its name or its number.
std::size_t find_clip(const std::vector<GltfClip>& clips, const AnimationSpec& spec, const std::string& file,
                      const std::string& scene_file, const std::string& pointer) {
  if (clips.empty()) refuse(file, "/animations", "no clips", "one or more");
  std::vector<std::string> names;
  for (const GltfClip& clip : clips) names.push_back(clip.name);
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "'" : ", '") + name + "'";
  const std::string allowed = "clips of " + file + ": " + all + ", or their numbers from 0";
  if (const int* number = std::get_if<int>(&spec.clip)) {
    if (*number < 0 || static_cast<std::size_t>(*number) >= clips.size())
      refuse(scene_file, pointer + "/clip", std::to_string(*number), allowed);
    return static_cast<std::size_t>(*number);
  }
  const std::string& name = std::get<std::string>(spec.clip);
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    refuse(scene_file, pointer + "/clip", "\"" + name + "\"" + did_you_mean(name, names), allowed);
  return static_cast<std::size_t>(found - names.begin());
}

class ClipSource : public AnimationSource {
 public:
  ClipSource(GltfScene file, std::size_t clip) : file_(std::move(file)), clip_(file_.clips[clip]) {
    file_.clips = {};
    for (const GltfChannel& channel : clip_.channels) {
      begin_ = std::min(begin_, channel.times.front()), end_ = std::max(end_, channel.times.back());
      times_.insert(times_.end(), channel.times.begin(), channel.times.end());
    }
    std::ranges::sort(times_);
    times_.erase(std::ranges::unique(times_).begin(), times_.end());
    for (double& time : times_) time -= begin_;
    if (!ends_as_it_begins()) return_ = times_.back() - times_[times_.size() - 2];
  }

  int vertex_count() const override { return static_cast<int>(file_.points.size()); }
  double duration(bool loop) const override { return end_ - begin_ + (loop ? return_ : 0); }
  void pose(double time, const Affine& map, std::span<Vec3> points, PoseMemory& memory) const override {
    const double after_end = time - (end_ - begin_);
    pose_at(after_end > 0 ? end_ : begin_ + time, memory.pose);
    if (after_end > 0) pose_at(begin_, memory.next), blend(memory.pose, memory.next, after_end / return_);
    deform(file_, memory.pose, map, points, memory.maps);
  }
  std::vector<double> key_times() const override { return times_; }
  std::string name_of(double key_time) const override {
    char text[40];
    std::snprintf(text, sizeof text, "%.6g s of clip ", begin_ + key_time);
    return text + ("'" + clip_.name + "'");
  }
  std::unique_ptr<AnimationSource> select(std::span<const int> vertices) const override {
    auto selected = std::make_unique<ClipSource>(*this);
    select_vertices(selected->file_, vertices);
    return selected;
  }

 private:
  void pose_at(double time, GltfPose& pose) const {
    pose = file_.rest;
    set_pose(clip_, time, pose);
  }
  /// True if no vertex is elsewhere at the last key than at the first one, to a ten thousandth of the figure's size.
  bool ends_as_it_begins() const {
    std::vector<Vec3> first(file_.points.size()), last = first;
    GltfPose pose;
    pose_at(begin_, pose), deform(file_, pose, {}, first);
    pose_at(end_, pose), deform(file_, pose, {}, last);
    double size = 0, apart = 0;
    for (std::size_t v = 0; v < first.size(); ++v)
      size = std::max(size, distance(first[v], first[0])), apart = std::max(apart, distance(first[v], last[v]));
    return apart <= 1e-4 * size;
  }

  GltfScene file_;
  GltfClip clip_;
  double begin_ = std::numeric_limits<double>::infinity(), end_ = -begin_;  // s, first and last key
  double return_ = 0;  // s, in which a loop leads from its last pose to its first one, as the last two keys are apart
  std::vector<double> times_;  // of all keys, from the first one
};

}  // namespace

std::unique_ptr<AnimationSource> read_clip(const std::string& file, const MeshPart& part, const AnimationSpec& spec,
                                           const std::string& scene_file, const std::string& pointer) {
  GltfScene gltf =
      read_gltf_scene(file, read_input(file, "a readable glTF file"), part ? Attributes::All : Attributes::None);
  if (part) {
    FileMesh whole{{}, gltf.triangles};
    whole.mesh.points = gltf.points;
    select_vertices(gltf, select_part(whole, part, file));
  }
  const std::size_t clip = find_clip(gltf.clips, spec, file, scene_file, pointer);
  if (gltf.clips[clip].channels.empty())
    refuse(file, "/animations/" + std::to_string(clip), "a clip that moves no node and no morph target",
           "one or more channels");
  return std::make_unique<ClipSource>(std::move(gltf), clip);
}

}  // namespace malha
