// SPDX-License-Identifier: Apache-2.0
#include "host/output/page.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "host/attachments/object_motion.h"
#include "host/base/build_info.h"
#include "host/base/file.h"
#include "host/model/model.h"
#include "host/output/page_parts.h"
#include "host/render/picture.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

using Json = nlohmann::json;

constexpr double kFramesPerSecond = 60;
constexpr char kBegin[] = "<script type=\"application/json\" class=\"run\">";
constexpr char kEnd[] = "</script>\n";

std::string text_of(const std::vector<std::uint32_t>& numbers, std::size_t stride) {
  return base64(packed(numbers, stride, 4));
}

Json json_of(const PackedPoints& points) {
  return {{"low", points.low}, {"side", points.side}, {"data", base64(points.data)}};
}

Json json_of(const PackedContacts& touches) {
  return {{"count", touches.count},
          {"far", touches.far},
          {"particles", base64(touches.particles)},
          {"ways", base64(touches.ways)}};
}

Json json_of(const PackedForces& forces) {
  return {{"count", forces.count}, {"particles", base64(forces.particles)}, {"newtons", json_of(forces.forces)}};
}

/// Encodes faces with four corners each; a triangle repeats its third one.
std::string text_of(const std::vector<Quad>& faces) {
  std::vector<std::uint32_t> corners;
  for (const Quad& face : faces)
    for (int k = 0; k < 4; ++k) corners.push_back(static_cast<std::uint32_t>(face[k] < 0 ? face[2] : face[k]));
  return text_of(corners, 4);
}

/// Encodes numbers >= -1, each increased by 1.
std::string text_of(const std::vector<int>& numbers) {
  std::vector<std::uint32_t> from_0;
  for (const int number : numbers) from_0.push_back(static_cast<std::uint32_t>(number + 1));
  return text_of(from_0, 1);
}

/// Encodes lines and their batches, sorted by their ends: the lower end, and the difference to the higher one.
Json batches(const Structure& layout) {
  std::vector<std::array<int, 3>> all;
  for (std::size_t l = 0; l < layout.lines.size(); ++l) {
    const auto [low, high] = std::minmax(layout.lines[l][0], layout.lines[l][1]);
    all.push_back({low, high, layout.batch[l]});
  }
  std::sort(all.begin(), all.end());
  std::vector<std::uint32_t> ends, numbers;
  for (const auto& [low, high, batch] : all) {
    ends.insert(ends.end(), {std::uint32_t(low), std::uint32_t(high - low)});
    numbers.push_back(static_cast<std::uint32_t>(batch));
  }
  return {{"count", all.size()},
          {"most", layout.batches},
          {"ends", text_of(ends, 2)},
          {"numbers", text_of(numbers, numbers.size())}};
}

Json environment(const Model& model) {
  Json all = Json::array();
  for (const EnvironmentMesh& object : model.environment)
    all.push_back({{"name", object.spec.name},
                   {"colour", stone_colour()},
                   {"points", json_of(packed(object.mesh.points))},
                   {"count", object.mesh.points.size()},
                   {"faces", text_of(object.mesh.faces)},
                   {"face_count", object.mesh.faces.size()},
                   {"deforms", deforms(object)}});
  return all;
}

/// Encodes a pose: the rows of a rotation and a translation (m).
Json json_of(const Pose& pose) {
  Json numbers(pose.r);
  for (const double t : {pose.t.x, pose.t.y, pose.t.z}) numbers.push_back(t);
  return numbers;
}

Json json_of(const Measures& m) {
  const auto length = [](const std::array<double, 3>& a) { return std::hypot(a[0], a[1], a[2]); };
  return {{"kinetic", m.kinetic},
          {"potential", m.potential},
          {"elastic", m.elastic},
          {"strain_rms", m.strain_rms},
          {"strain_max", m.strain_max},
          {"speed_max", m.speed_max},
          {"momentum", length(m.momentum)},
          {"angular_momentum", length(m.angular_momentum)},
          {"penetration_max", m.penetration_max},
          {"contacts", m.contacts + m.self_contacts + m.edge_contacts},
          {"crossings", m.crossings}};
}

/// Writes JSON; names that are not UTF-8 get its replacement character.
std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// Escapes JSON for a <script> element, which must not contain its end tag.
std::string script_text(std::string text) {
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  return text;
}

/// Returns the pieces of the whole file with the JSON of these runs.
std::vector<std::string_view> around(const std::vector<std::string_view>& runs) {
  std::vector<std::string_view> all{kPageBeforeRuns};
  for (const std::string_view run : runs) all.insert(all.end(), {kBegin, run, kEnd});
  all.push_back(kPageAfterRuns);
  return all;
}

/// Returns the path of a page. `there`: its folder, or the page itself.
std::filesystem::path page_in(const std::filesystem::path& there) {
  return std::filesystem::is_regular_file(there) ? there : there / "page.html";
}

std::string run_of(const std::filesystem::path& path) {
  const std::string page = read_input(path, "a folder of results of malha run --page");
  const std::size_t begin = page.find(kBegin), end = page.find(kEnd, begin);
  if (begin == std::string::npos || end == std::string::npos)
    refuse(path.string(), "", "no run in it", "a page that malha run --page wrote");
  const std::size_t from = begin + sizeof kBegin - 1;
  if (page.find(kBegin, end) != std::string::npos)
    refuse(path.string(), "", "two runs in it", "a page that malha run --page wrote");
  return page.substr(from, end - from);
}

/// Returns the shortest endings of both paths that differ.
std::array<std::string, 2> short_names(const std::filesystem::path& one, const std::filesystem::path& other) {
  std::array<std::filesystem::path, 2> left, names;
  for (const auto k : {0, 1}) {
    left[k] = std::filesystem::weakly_canonical(k == 0 ? one : other);
    if (left[k].filename() == "page.html") left[k] = left[k].parent_path();
  }
  do
    for (const auto k : {0, 1}) {
      names[k] = names[k].empty() ? left[k].filename() : left[k].filename() / names[k];
      left[k] = left[k].parent_path();
    }
  while (names[0] == names[1] && left[0].has_filename() && left[1].has_filename());
  return {names[0].string(), names[1].string()};
}

/// Adds the name of the folder to the JSON of a run.
std::string named(const std::string& run, const std::string& folder) {
  return "{\"folder\":" + script_text(dumped(folder)) + "," + run.substr(run.find('{') + 1);
}

}  // namespace

Page::Page(const Simulation& simulation)
    : simulation_(simulation),
      max_bytes_(static_cast<std::size_t>(1e6 * simulation.model().scene.outputs.page->max_megabytes)),
      first_(simulation.steps()),
      every_(std::max<std::int64_t>(1, std::llround(1 / kFramesPerSecond / simulation.model().scene.solver.dt))) {
  if (!simulation.model().environment.empty()) contacts_.emplace(simulation.model(), simulation.threads());
  environment_ = dumped(environment(simulation.model()));
  std::size_t fixed = environment_.size() + 20'000;  // allowance for parts that are not counted
  for (const std::string_view piece : around({})) fixed += piece.size();
  max_bytes_ -= std::min(max_bytes_, fixed);
  add_mesh();
  store_frame(0);
}

bool Page::is_due(std::int64_t step) const { return (step - first_) % every_ == 0; }

void Page::add_frame(double step_ms) {
  step_ms_ = step_ms;
  if (!is_due(simulation_.steps())) return;
  store_frame(step_ms);
  thin_out(false);
}

void Page::add_mesh() {
  const RenderMesh& render_mesh = simulation_.model().render_mesh;
  std::vector<std::uint32_t> lines;
  for (const Edge& line : render_mesh.lines)
    lines.insert(lines.end(), {std::uint32_t(line[0]), std::uint32_t(line[1])});
  Json mesh{{"count", render_mesh.points.size()},  {"start", json_of(packed(render_mesh.points))},
            {"faces", text_of(render_mesh.faces)}, {"face_count", render_mesh.faces.size()},
            {"lines", text_of(lines, 2)},          {"line_count", render_mesh.lines.size()},
            {"body_begin", render_mesh.body_begin}};
  if (const Structure layout = structure(simulation_.model(), simulation_.threads()); layout.patches > 0) {
    mesh["patch"] = text_of(layout.patch), mesh["patches"] = layout.patches;
    mesh["colour"] = text_of(layout.colour), mesh["colours"] = layout.colours;
    if (!layout.lines.empty()) mesh["batch"] = batches(layout);
  }
  residuals_.emplace(simulation_.model(), simulation_.threads());
  if (!residuals_->any()) residuals_.reset();
  forces_.emplace(simulation_.model());
  mesh["too_stiff"] = forces_->left_out();
  if (!forces_->any()) forces_.reset();
  meshes_.push_back(dumped(mesh));
  tears_ = simulation_.tears();
}

void Page::store_frame(double step_ms) {
  if (simulation_.tears() != tears_) add_mesh();
  const std::vector<Vec3> x = simulation_.positions();
  Frame& frame = frames_.emplace_back();
  frame.step = simulation_.steps(), frame.time = simulation_.time(), frame.step_ms = step_ms;
  frame.mesh = meshes_.size() - 1, frame.points = packed(x), frame.measures = simulation_.measure();
  const std::vector<EnvironmentMesh>& environment = simulation_.model().environment;
  for (std::size_t e = 0; e < environment.size(); ++e) {
    if (deforms(environment[e])) frame.deformed.push_back(packed(points_at(environment[e], frame.time)));
    if (moves_rigidly(environment[e])) frame.placed.push_back({e, pose_at(environment[e].spec.motion, frame.time)});
  }
  if (residuals_) frame.residual = packed((*residuals_)(x));
  if (contacts_) frame.touches = packed((*contacts_)(x, environment, frame.time));
  if (forces_) frame.forces = packed((*forces_)(x, frame.time));
}

std::size_t Page::Frame::bytes() const {
  constexpr std::size_t kRest = 800;  // approximate bytes of measures, poses and field names
  std::size_t packed = points.data.size();
  for (const PackedPoints& object : deformed) packed += object.data.size() + kRest / 4;
  if (residual) packed += residual->data.size();
  if (touches) packed += touches->particles.size() + touches->ways.size();
  if (forces) packed += forces->particles.size() + forces->forces.data.size() + kRest / 4;
  return packed * 4 / 3 + kRest;
}

void Page::thin_out(bool keeps_last) {
  const auto size = [&] {
    std::size_t sum = 0;
    for (const std::string& mesh : meshes_) sum += mesh.size();
    for (const Frame& frame : frames_) sum += frame.bytes();
    return sum;
  };
  while (size() > max_bytes_ && frames_.size() > 1) {
    const std::int64_t end = frames_.back().step;
    every_ *= 2;
    std::erase_if(frames_, [&](const Frame& frame) {
      if (keeps_last) return frame.step < end && (!is_due(frame.step) || every_ > end - first_);
      return !is_due(frame.step);
    });
    std::vector<std::string> used;  // meshes between two tears may have lost all their frames
    std::size_t last = meshes_.size();
    for (Frame& frame : frames_) {
      if (frame.mesh != last) last = frame.mesh, used.push_back(std::move(meshes_[last]));
      frame.mesh = used.size() - 1;
    }
    if (last != meshes_.size() - 1) used.push_back(std::move(meshes_.back()));
    meshes_ = std::move(used);
  }
}

void Page::finish() {
  if (frames_.back().step != simulation_.steps()) store_frame(step_ms_);
  thin_out(true);
}

std::string Page::kept() const {
  return counted(frames_.size(), "frame") + ", one " + (every_ == 1 ? "a step" : "every " + counted(every_, "step"));
}

void Page::write(const std::filesystem::path& path, const std::string& report,
                 const std::vector<std::string>& warnings) const {
  const Model& model = simulation_.model();
  Json frames = Json::array(), bodies = Json::array();
  double rounding = 0;
  std::set<std::size_t> moving;  // objects with a pose in every frame, because they move in one at least
  for (const Frame& frame : frames_)
    for (const PlacedObject& one : frame.placed) moving.insert(one.object);
  const auto poses = [&](const Frame& frame) {
    Json all = Json::array();
    auto placed = frame.placed.begin();
    for (const std::size_t object : moving)
      all.push_back(json_of(placed != frame.placed.end() && placed->object == object ? (placed++)->pose : Pose{}));
    return all;
  };
  for (const Frame& frame : frames_) {
    rounding = std::max(rounding, frame.points.rounding());
    frames.push_back({{"step", frame.step},
                      {"time", frame.time},
                      {"step_ms", frame.step_ms},
                      {"mesh", frame.mesh},
                      {"points", json_of(frame.points)},
                      {"poses", poses(frame)},
                      {"measures", json_of(frame.measures)}});
    for (const PackedPoints& object : frame.deformed) frames.back()["deformed"].push_back(json_of(object));
    if (frame.residual)
      frames.back()["residual"] = {{"most", frame.residual->most}, {"data", base64(frame.residual->data)}};
    if (frame.touches) frames.back()["touches"] = json_of(*frame.touches);
    if (frame.forces) frames.back()["forces"] = json_of(*frame.forces);
  }
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b)
    bodies.push_back({{"name", model.scene.bodies[b].name}, {"colour", body_colour(static_cast<int>(b))}});
  Json run{{"malha", version()}, {"every", every_},  {"rounding", rounding}, {"bodies", bodies},
           {"frames", frames},   {"moving", moving}, {"warnings", warnings}, {"report", Json::parse(report)}};
  if (const auto& picture = model.scene.outputs.picture; picture && picture->camera)
    run["camera"] = {{"eye", picture->camera->eye},
                     {"target", picture->camera->target},
                     {"fov_degrees", picture->camera->fov_degrees}};
  std::string text = dumped(run);
  text.back() = ',';  // the JSON of environment and meshes follows
  text += "\"environment\":" + environment_ + ",\"meshes\":[";
  for (const std::string& mesh : meshes_) text += mesh + (&mesh == &meshes_.back() ? "]}" : ",");
  text = script_text(std::move(text));
  write_whole(path, around({text}));
}

void write_comparison(const std::filesystem::path& one, const std::filesystem::path& other,
                      const std::filesystem::path& path) {
  for (const auto& input : {page_in(one), page_in(other)})
    if (std::filesystem::weakly_canonical(input) == std::filesystem::weakly_canonical(path))
      refuse(path.string(), "--out", "a page that is compared", "another file");
  const auto folders = short_names(page_in(one), page_in(other));
  const std::string a = named(run_of(page_in(one)), folders[0]), b = named(run_of(page_in(other)), folders[1]);
  if (path.has_parent_path()) make_folder(path.parent_path());
  write_whole(path, around({a, b}));
}

}  // namespace malha
