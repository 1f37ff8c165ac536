// SPDX-License-Identifier: Apache-2.0
#include "host/animation/animation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/spelling_suggestion.h"
#include "host/mesh/generate.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"

namespace malha {

namespace {

/// Distance that vertices of one point may part, over the size of the mesh. Exporters round weights apart.
constexpr double parting = 1e-4;

/// The file, folder or pattern that an animation is read from.
std::string origin_of(const EnvironmentSpec& object) {
  const AnimationSpec& spec = *object.animation;
  if (!spec.frames.empty()) return spec.frames;
  const auto* shape = std::get_if<MeshFile>(&object.shape);
  return spec.file.empty() && shape ? shape->path : spec.file;
}

std::unique_ptr<AnimationSource> read_source(const Scene& scene, std::size_t index, const Mesh& mesh) {
  const AnimationSpec& spec = *scene.environment[index].animation;
  const std::string from = origin_of(scene.environment[index]);
  const std::string pointer = "/environment/" + std::to_string(index) + "/animation";
  const auto* shape = std::get_if<MeshFile>(&scene.environment[index].shape);
  const MeshPart part = shape ? shape->part : MeshPart{};
  if (spec.frames.empty()) return read_clip(from, part, spec, scene.file, pointer);
  if (!spec.frames_per_second) refuse(scene.file, pointer, "no 'frames_per_second'", "a number > 0 (1/s)");
  const bool is_cache = lower(std::filesystem::path(from).extension().string()) == ".pc2";
  return is_cache ? read_point_cache(from, *spec.frames_per_second)
                  : read_series(from, part, *spec.frames_per_second, mesh);
}

/// The vertices of the file that are points of the mesh, the lowest of each; and the others that were merged into them.
struct MergedVertices {
  std::vector<int> of_points;  // of each point
  std::vector<std::array<int, 2>> pairs;
};

MergedVertices merged_vertices(const Mesh& mesh) {
  MergedVertices merged{std::vector<int>(mesh.points.size(), -1), {}};
  const std::vector<int>& point = mesh.vertices.point;
  for (int v = 0; v < static_cast<int>(point.empty() ? mesh.points.size() : point.size()); ++v) {
    const int p = point.empty() ? v : point[static_cast<std::size_t>(v)];
    if (p < 0) continue;
    int& lowest = merged.of_points[static_cast<std::size_t>(p)];
    if (lowest < 0)
      lowest = v;
    else
      merged.pairs.push_back({lowest, v});
  }
  return merged;
}

double size_at_start(const AnimationSource& source) {
  std::vector<Vec3> points(static_cast<std::size_t>(source.vertex_count()));
  PoseMemory memory;
  source.pose(0, {}, points, memory);
  Vec3 low = points.front(), high = low;
  for (const Vec3& x : points)
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
  return distance(low, high);
}

/// Refuses merged vertices that part at some time by more than `most` (m).
void check_merged(const std::string& file, const AnimationSource& all, const std::vector<std::array<int, 2>>& pairs,
                  double most) {
  if (pairs.empty()) return;
  std::vector<int> vertices;
  for (const auto& pair : pairs) vertices.insert(vertices.end(), pair.begin(), pair.end());
  const std::unique_ptr<AnimationSource> merged = all.select(vertices);
  std::vector<Vec3> points(vertices.size());
  PoseMemory memory;
  for (const double time : all.key_times()) {
    merged->pose(time, {}, points, memory);
    for (std::size_t i = 0; i < points.size(); i += 2) {
      const double apart = distance(points[i], points[i + 1]);
      if (apart <= most) continue;
      char far[80];
      std::snprintf(far, sizeof far, " %.3g m apart, which are one point of the shape", apart);
      refuse(file, all.name_of(time),
             "vertices " + std::to_string(vertices[i]) + " and " + std::to_string(vertices[i + 1]) + far,
             "vertices that start in one place stay together");
    }
  }
}

/// The same map as apply() of host/mesh/generate.h.
Affine map_of(Transform transform) {
  const Vec3 translate = transform.translate;
  transform.translate = {0, 0, 0};
  Mesh axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, {}, {}};
  apply(transform, axes);
  Affine map;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t j = 0; j < 3; ++j) map.m[3 * j + k] = axes.points[j][k];
    map.m[9 + k] = translate[k];
  }
  return map;
}

}  // namespace

Animation::Animation(std::unique_ptr<const AnimationSource> source, const AnimationSpec& spec, const Affine& map)
    : source_(std::move(source)), spec_(spec), map_(map) {}

void Animation::sample(double time, std::span<Vec3> points) const {
  PoseMemory memory;
  sample(time, points, memory);
}
void Animation::sample(double time, std::span<Vec3> points, PoseMemory& memory) const {
  const double whole = source_->duration(spec_.loop);
  double local = spec_.offset + spec_.speed * time;
  if (spec_.loop && whole > 0) local -= whole * std::floor(local / whole);
  source_->pose(std::clamp(local, 0.0, whole), map_, points, memory);
}

std::shared_ptr<const Animation> Animation::select(std::span<const int> vertices) const {
  return std::make_shared<const Animation>(source_->select(vertices), spec_, map_);
}

std::shared_ptr<const Animation> load_animation(const Scene& scene, std::size_t index, const Mesh& mesh) {
  const EnvironmentSpec& object = scene.environment[index];
  const std::string file = origin_of(object);
  const std::unique_ptr<AnimationSource> all = read_source(scene, index, mesh);
  const std::size_t vertices = mesh.vertices.point.empty() ? mesh.points.size() : mesh.vertices.point.size();
  if (static_cast<std::size_t>(all->vertex_count()) != vertices)
    refuse(file, "", counted(all->vertex_count(), "vertex", "vertices"),
           "as many as the shape of object '" + object.name + "' has, " + std::to_string(vertices));
  const MergedVertices merged = merged_vertices(mesh);
  const auto* shape = std::get_if<MeshFile>(&object.shape);
  check_merged(file, *all, merged.pairs, (shape ? shape->weld.value_or(0) : 0) + parting * size_at_start(*all));
  return std::make_shared<const Animation>(all->select(merged.of_points), *object.animation, map_of(object.transform));
}

}  // namespace malha
