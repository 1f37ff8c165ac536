// SPDX-License-Identifier: Apache-2.0
#include "host/run/redraw.h"

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/base/file.h"
#include "host/output/frame_formats.h"
#include "host/output/frame_vertices.h"
#include "host/output/gallery.h"
#include "host/output/results.h"
#include "malha/error.h"
#include "malha/simulation.h"
#include "malha/text.h"

namespace malha {

namespace {

namespace fs = std::filesystem;

/// Reads a result of a run; throws InputError if it is missing.
std::string read_result(const fs::path& path) { return read_input(path, "a folder of results of malha run"); }

Scene scene_of_report(const fs::path& path) {
  const auto report = nlohmann::json::parse(read_result(path), nullptr, false);
  const auto input = report.is_object() ? report.find("input") : report.end();
  if (input == report.end() || !input->is_object() || !input->contains("scene"))
    refuse(path.string(), "/input", "no scene", "a report of this version of malha");
  return parse_scene((*input)["scene"].dump(), path.string() + ": /input/scene",
                     fs::canonical(path.parent_path()).string());
}

/// Reads `count` vectors; returns none if the size does not match.
template <class R>
std::vector<Vec3> vectors_of(const char* from, std::uint64_t size, std::size_t count) {
  std::vector<Vec3> vectors;
  for (std::size_t i = 0; size == count * 3 * sizeof(R) && i < count; ++i) {
    R x[3];
    std::memcpy(x, from + i * sizeof x, sizeof x);
    vectors.push_back({x[0], x[1], x[2]});
  }
  return vectors;
}

/// Reads the points of a .vtp frame that malha wrote; returns none if there are not `count` of them.
std::vector<Vec3> points_of(const fs::path& path, std::size_t count) {
  const std::string bytes = read_result(path), start = "<AppendedData encoding=\"raw\">\n_";
  const std::size_t at = bytes.find(start);
  std::uint64_t size = 0;
  if (at == std::string::npos || bytes.size() - at - start.size() < sizeof size)
    refuse(path.string(), "", "no points", "a frame that malha run wrote");
  const char* const from = bytes.data() + at + start.size();
  std::memcpy(&size, from, sizeof size);
  if (size > bytes.size() - at - start.size() - sizeof size)
    refuse(path.string(), "", counted(size, "byte") + " of points in a shorter file", "a frame that malha run wrote");
  if (bytes.find("type=\"Float64\" Name=\"points\"") < at) return vectors_of<double>(from + sizeof size, size, count);
  return vectors_of<float>(from + sizeof size, size, count);
}

}  // namespace

std::string redraw(const std::string& folder, int threads) {
  const Results results{folder};
  std::optional<FolderLock> lock;
  if (fs::is_directory(results.folder)) lock.emplace(results.folder);
  Scene scene = scene_of_report(results.report);
  if (!scene.outputs.picture) scene.outputs.picture.emplace();
  scene.outputs.picture_every = 0;
  Simulation simulation(scene, {.threads = threads});
  simulation.load_checkpoint(results.checkpoint);

  const std::vector<CollectedFrame> frames = collected_frames(results.frames);
  const FrameVertices vertices(simulation.model().render_mesh);
  const auto last = static_cast<std::int64_t>(frames.size()) - 1;
  Gallery gallery(simulation, results, 0, std::max<std::int64_t>(last, 1));
  gallery.finish(simulation.time(), simulation.positions());
  if (last < 1) return "no storyboard: it needs frames for ParaView (malha run --format vtp)";
  for (std::int64_t k = 0; k <= last; ++k) {
    if (!gallery.is_due(k)) continue;
    const auto& [index, time] = frames[static_cast<std::size_t>(k)];
    const std::filesystem::path path = results.frames / frame_name(index, ".vtp");
    const std::vector<Vec3> points = vertices.particle_positions(points_of(path, vertices.count()));
    if (points.empty()) return "no storyboard: the mesh tore between the frames";
    gallery.draw_if_due(k, time, points);
  }
  gallery.write_storyboard();
  return "";
}

}  // namespace malha
