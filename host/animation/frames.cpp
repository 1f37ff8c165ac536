// SPDX-License-Identifier: Apache-2.0
// Animations whose frames have all vertices: PointCache2 files, and series of mesh files.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "host/animation/animation_source.h"
#include "host/animation/point_cache.h"
#include "host/base/mapped_file.h"
#include "host/base/memory_size.h"
#include "host/base/spelling_suggestion.h"
#include "host/mesh/io/mesh_io.h"
#include "host/mesh/vectors.h"
#include "malha/error.h"

namespace malha {

namespace fs = std::filesystem;

namespace {

using Point = std::array<float, 3>;

class FrameSource : public AnimationSource {
 public:
  FrameSource(std::size_t vertices, std::vector<Point> points, double seconds)
      : vertices_(vertices), points_(std::move(points)), seconds_(seconds) {}

  int vertex_count() const override { return static_cast<int>(vertices_); }
  double duration(bool loop) const override { return seconds_ * static_cast<double>(frames() - (loop ? 0 : 1)); }
  void pose(double time, const Affine& map, std::span<Vec3> points, PoseMemory& /*memory*/) const override {
    const double frame = time / seconds_, whole = std::floor(frame), s = frame - whole;
    const Point* a = at(static_cast<std::size_t>(whole) % frames());
    const Point* b = at((static_cast<std::size_t>(whole) + 1) % frames());
    for (std::size_t v = 0; v < vertices_; ++v) {
      Vec3 x;
      for (std::size_t k = 0; k < 3; ++k)
        x[k] = (1 - s) * static_cast<double>(a[v][k]) + s * static_cast<double>(b[v][k]);
      points[v] = map * x;
    }
  }
  std::vector<double> key_times() const override {
    std::vector<double> times;
    for (std::size_t i = 0; i < frames(); ++i) times.push_back(seconds_ * static_cast<double>(i));
    return times;
  }
  std::string name_of(double key_time) const override {
    return "frame " + std::to_string(std::lround(key_time / seconds_));
  }
  std::unique_ptr<AnimationSource> select(std::span<const int> vertices) const override {
    std::vector<Point> points;
    points.reserve(frames() * vertices.size());
    for (std::size_t i = 0; i < frames(); ++i)
      for (const int v : vertices) points.push_back(at(i)[v]);
    return std::make_unique<FrameSource>(vertices.size(), std::move(points), seconds_);
  }

 private:
  std::size_t frames() const { return points_.size() / vertices_; }
  const Point* at(std::size_t frame) const { return &points_[frame * vertices_]; }

  std::size_t vertices_;
  std::vector<Point> points_;  // m, of one frame after the other
  double seconds_;             // from one frame to the next
};

/// Refuses frames that do not fit into memory twice: of the file, and of the points of the mesh.
void require_memory(const std::string& file, std::size_t frames, std::size_t vertices) {
  const double bytes = 2.0 * sizeof(Point) * static_cast<double>(frames) * static_cast<double>(vertices);
  const auto free = static_cast<double>(available_memory());
  if (bytes > free)
    refuse<OutOfMemory>(file, "", std::to_string(frames) + " frames, which take " + in_gib(bytes),
                        "what is free: " + in_gib(free));
}

PointCacheHeader read_header(const std::string& file, std::string_view bytes) {
  PointCacheHeader header{};
  if (bytes.size() >= sizeof header) std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.signature, kPointCache, sizeof kPointCache) != 0)
    refuse(file, "byte 0", "no header of a point cache", "POINTCACHE2");
  if (header.version != 1) refuse(file, "byte 12", "version " + std::to_string(header.version), "1");
  if (header.points < 1) refuse(file, "byte 16", std::to_string(header.points) + " points", "one or more");
  if (!(header.frames_per_sample > 0) || !std::isfinite(header.frames_per_sample))
    refuse(file, "byte 24", "a number of frames for each sample that is not above 0", "> 0");
  if (header.samples < 1) refuse(file, "byte 28", std::to_string(header.samples) + " samples", "one or more");
  return header;
}

// Series.

struct NumberedFile {
  long long number;
  std::string path;
};

/// The digits at [begin, end) as a number; false for none, and for other characters.
bool to_number(const std::string& text, std::size_t begin, std::size_t end, long long& number) {
  const char *first = text.data() + begin, *last = text.data() + end;
  const bool digits = first != last && std::all_of(first, last, [](char c) { return '0' <= c && c <= '9'; });
  return digits && std::from_chars(first, last, number).ec == std::errc();
}

/// The mesh files of a folder, numbered by the last digits in their names.
std::vector<NumberedFile> frames_of_folder(const fs::path& folder) {
  std::vector<NumberedFile> frames;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string extension = lower(entry.path().extension().string());
    if (extension != ".obj" && extension != ".ply") continue;
    const std::string stem = entry.path().stem().string();
    const std::size_t end = stem.find_last_of("0123456789");
    NumberedFile frame{0, entry.path().string()};
    const std::size_t before = end == std::string::npos ? end : stem.find_last_not_of("0123456789", end);
    if (end == std::string::npos || !to_number(stem, before + 1, end + 1, frame.number))
      refuse(folder.string(), "", "'" + entry.path().filename().string() + "'", "OBJ and PLY files with a number each");
    frames.push_back(frame);
  }
  return frames;
}

/// The files whose names have a number where the pattern has a star.
std::vector<NumberedFile> frames_of_pattern(const fs::path& pattern) {
  const std::string name = pattern.filename().string();
  const std::size_t star = name.find('*');
  const std::string before = name.substr(0, star), after = name.substr(star + 1);
  std::error_code missing;
  std::vector<NumberedFile> frames;
  const fs::path folder = pattern.has_parent_path() ? pattern.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, missing)) {
    const std::string found = entry.path().filename().string();
    NumberedFile frame{0, entry.path().string()};
    if (found.size() > before.size() + after.size() && found.starts_with(before) && found.ends_with(after) &&
        to_number(found, before.size(), found.size() - after.size(), frame.number))
      frames.push_back(frame);
  }
  return frames;
}

/// The files in the order of their numbers, which have the same distance from one to the next.
std::vector<NumberedFile> frames_of(const std::string& files) {
  const std::string name = fs::path(files).filename().string();
  if (std::ranges::count(name, '*') > 1) refuse(files, "", "several stars", "one '*' in the name, for the number");
  const bool is_pattern = name.find('*') != std::string::npos;
  if (!is_pattern && !fs::is_directory(files))
    refuse(files, "", "no folder", "a folder, or a pattern such as \"walk_*.ply\"");
  std::vector<NumberedFile> frames = is_pattern ? frames_of_pattern(files) : frames_of_folder(files);
  if (frames.empty()) refuse(files, "", "no frames", "OBJ or PLY files with a number each");
  std::ranges::sort(frames, {}, [](const NumberedFile& file) { return std::pair(file.number, file.path); });
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const long long step = frames[1].number - frames[0].number;
    if (frames[i].number == frames[i - 1].number)
      refuse(files, "", "two frames " + std::to_string(frames[i].number), "one file for each number");
    if (frames[i].number != frames[i - 1].number + step)
      refuse(files, "",
             "no frame " + std::to_string(frames[i - 1].number + step) + " between " +
                 std::to_string(frames[i - 1].number) + " and " + std::to_string(frames[i].number),
             "numbers at equal distances");
  }
  return frames;
}

void check_topology(const std::string& file, const Mesh& found, std::size_t vertices, const std::vector<Quad>& faces) {
  if (found.points.size() != vertices)
    refuse(file, "", counted(static_cast<long long>(found.points.size()), "vertex", "vertices"),
           std::to_string(vertices) + ", as in the frame before");
  if (found.faces.size() != faces.size())
    refuse(file, "", counted(static_cast<long long>(found.faces.size()), "face", "faces"),
           std::to_string(faces.size()) + ", as in the frame before");
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (found.faces[f] != faces[f])
      refuse(file, "face " + std::to_string(f), "other vertices", "those of the frame before");
}

}  // namespace

std::unique_ptr<AnimationSource> read_point_cache(const std::string& file, double frames_per_second) {
  if (!fs::is_regular_file(file)) refuse(file, "", "no file", "a readable PC2 file");
  const MappedFile mapped(file);
  const PointCacheHeader header = read_header(file, mapped.bytes());
  const auto vertices = static_cast<std::size_t>(header.points), samples = static_cast<std::size_t>(header.samples);
  const double wanted =
      sizeof header + 1.0 * sizeof(Point) * static_cast<double>(samples) * static_cast<double>(vertices);
  if (static_cast<double>(mapped.bytes().size()) < wanted)
    refuse(file, "", std::to_string(mapped.bytes().size()) + " bytes",
           std::to_string(static_cast<long long>(wanted)) + " for " + std::to_string(samples) + " samples of " +
               std::to_string(vertices) + " points");
  require_memory(file, samples, vertices);
  std::vector<Point> points(samples * vertices);
  std::memcpy(points.data(), mapped.bytes().data() + sizeof header, points.size() * sizeof(Point));
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const float number : points[i])
      if (!(std::abs(number) <= 1e18f))
        refuse(file, "frame " + std::to_string(i / vertices),
               shown(number) + " at vertex " + std::to_string(i % vertices), "numbers up to 1e18");
  return std::make_unique<FrameSource>(vertices, std::move(points),
                                       static_cast<double>(header.frames_per_sample) / frames_per_second);
}

std::unique_ptr<AnimationSource> read_series(const std::string& files, const MeshPart& part, double frames_per_second,
                                             const Mesh& mesh) {
  const std::vector<NumberedFile> frames = frames_of(files);
  std::vector<Point> points;
  std::vector<Quad> faces;
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Mesh frame = read_mesh(frames[i].path, part);
    if (i == 0) {
      vertices = frame.points.size(), faces = frame.faces;
      require_memory(files, frames.size(), vertices);
      points.reserve(frames.size() * vertices);
      // Welding may have removed faces, or corners of them.
      const std::vector<Quad>& of_shape = mesh.vertices.faces.empty() ? mesh.faces : mesh.vertices.faces;
      if (of_shape.size() == faces.size() && of_shape != faces)
        refuse(frames[i].path, "", "other faces than those of the shape", "the same vertices and faces");
    }
    check_topology(frames[i].path, frame, vertices, faces);
    for (const Vec3& x : frame.points)
      points.push_back({static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])});
  }
  return std::make_unique<FrameSource>(vertices, std::move(points), 1 / frames_per_second);
}

}  // namespace malha
