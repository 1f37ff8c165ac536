// SPDX-License-Identifier: Apache-2.0
#include "tools/view/app.h"

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "host/base/file.h"
#include "host/render/image.h"
#include "malha/text.h"
#include "tools/view/layout.h"
#include "tools/view/pick.h"
#include "tools/view/scenes.h"

namespace malha::view {

namespace {

constexpr Colour kHandle{255, 210, 60}, kPin{230, 60, 60}, kDiverged{255, 30, 30};

Vec3 vec3(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }

}  // namespace

App::App(const WindowOptions& options, bool in_software, float scale)
    : options_(options), session_(options.simulation), panels_(scale), decimates_while_moving_(in_software) {
  choices_.scenes = scenes_near(options.scenes.empty() ? "" : options.scenes[0]);
  if (!options.scenes.empty()) session_.open(options.scenes[0]);
  if (options.scenes.size() == 2) session_.compare(load_scene(options.scenes[1]));
}

std::string App::title() const {
  if (now_.sides.empty()) return "malha";
  const SideShown& side = now_.sides[0];
  const int substep = side.frame->substep;
  return side.scene->name + ": step " + std::to_string(side.frame->steps) +
         (substep > 0 ? ", substep " + std::to_string(substep) : "") + ", " + shown(side.frame->time) + " s, " +
         (side.diverged_particle >= 0 ? "diverged"
          : now_.running              ? "running"
                                      : "paused") +
         " - malha";
}

void App::drop(const std::string& path) {
  if (std::filesystem::path(path).extension() == ".json") return session_.open(path);
  try {
    session_.open_made(scene_of_mesh(path));
  } catch (const std::exception& error) {
    session_.say(error.what(), true);
  }
}

void App::lay_out(int width, int height) {
  const int sides = std::max(1, int(now_.sides.size()));
  ports_.clear();
  for (int side = 0; side < sides; ++side)
    ports_.push_back(port_of(side, sides, choices_.panels, width, height, panels_));
  while (painters_.size() < ports_.size()) painters_.emplace_back();
}

void App::show_all() {
  std::vector<std::shared_ptr<const Frame>> frames;
  for (const SideShown& side : now_.sides) frames.push_back(side.frame);
  camera_.frame(points_to_frame(frames), ports_[0].aspect());
}

void App::frame(int width, int height) {
  const std::int64_t before = now_.version;
  now_ = session_.snapshot();
  still_ = before == now_.version ? still_ + 1 : 0;
  const std::size_t sides = ports_.size();
  lay_out(width, height);
  if (!now_.sides.empty() && sides > 0 && ports_.size() != sides)
    show_all();  // because the width of each side has changed
  if (!now_.sides.empty() && framed_ != now_.sides[0].scene) {
    const bool other = !framed_ || framed_->name != now_.sides[0].scene->name;
    framed_ = now_.sides[0].scene;
    const auto& picture = framed_->outputs.picture;
    if (other && picture && picture->camera && sides < 2 && ports_.size() < 2)
      camera_ = OrbitCamera(*picture->camera, double(picture->size[0]) / picture->size[1], ports_[0].aspect());
    else if (other)
      camera_ = OrbitCamera(), show_all();
  }
  panels(width, height);
  mouse();
  const Eigen::Matrix4d seen = camera_.view();
  const bool moves = now_.running || dragged_ || knife_ || still_ <= 2 || seen != seen_;
  seen_ = seen, decimated_ = decimates_while_moving_ && moves && !picture_;
  glViewport(0, 0, width, height);
  glClearColor(0.87f, 0.89f, 0.92f, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  coloured_.clear();
  for (std::size_t s = 0; s < now_.sides.size(); ++s) {
    draw_side(s, height);
    overlay(s);
  }
  glViewport(0, 0, width, height);
}

void App::draw_side(std::size_t s, int height) {
  const SideShown& side = now_.sides[s];
  Coloured coloured = view::coloured(*side.frame, *side.fields, choices_.field);
  Picture picture{side.frame.get(), std::move(coloured.colours), choices_.surface, std::move(coloured.marks),
                  decimated_};
  add_marks(side, picture.marks);
  painters_[s].draw(picture, camera_, ports_[s], height);
  coloured_.push_back(std::move(coloured));
}

void App::add_marks(const SideShown& side, Marks& marks) const {
  const auto ball = [&](const Point3f& at, const Colour& colour) {
    marks.balls.push_back(at), marks.ball_colours.push_back(colour);
  };
  if (choices_.pins)
    for (const unsigned i : side.frame->body->pinned) ball(side.frame->x[i], kPin);
  for (const auto& [particle, handle] : side.handles) {
    if (std::size_t(particle) >= side.frame->x.size()) continue;
    ball(side.frame->x[particle], handle.is_held ? kPin : kHandle);
    if (handle.is_held) continue;
    ball(to_point3f(handle.to), kHandle);
    marks.lines.insert(marks.lines.end(), {side.frame->x[particle], to_point3f(handle.to)});
    marks.line_colours.insert(marks.line_colours.end(), {kHandle, kHandle});
  }
  const bool is_diverged = side.diverged_particle >= 0 && std::size_t(side.diverged_particle) < side.frame->x.size();
  if (is_diverged && std::fmod(ImGui::GetTime(), 0.6) < 0.35) ball(side.frame->x[side.diverged_particle], kDiverged);
}

std::optional<std::size_t> App::side_at(double x, double y) const {
  for (std::size_t s = 0; s < now_.sides.size(); ++s)
    if (ports_[s].contains(x, y)) return s;
  return std::nullopt;
}

void App::mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  const double x = io.MousePos.x, y = io.MousePos.y;
  const double tall = ports_[0].height;
  if (!ImGui::IsMouseDown(0) && dragged_) {
    if (!dragged_->is_held) session_.release(sides_to_pull(dragged_->side), dragged_->particle);
    dragged_.reset();
  }
  if (!ImGui::IsMouseDown(0)) knife_.reset();
  if (!ImGui::IsMouseDown(0) && !ImGui::IsMouseDown(1)) orbits_ = false;
  if (!ImGui::IsMouseDown(0) && !ImGui::IsMouseDown(2)) pans_ = false;
  if (!io.WantCaptureMouse) {
    const std::optional<std::size_t> side = side_at(x, y);
    if (side && ImGui::IsMouseClicked(0)) press(*side, x, y);
    if (side && ImGui::IsMouseClicked(1)) orbits_ = true;
    if (side && ImGui::IsMouseClicked(2)) pans_ = true;
    if (io.MouseWheel != 0) camera_.zoom(std::pow(0.88, io.MouseWheel));
  }
  if (dragged_ || knife_) return drag(x, y);
  if (orbits_) camera_.orbit(3 * io.MouseDelta.x / tall, 3 * io.MouseDelta.y / tall);
  if (pans_) camera_.pan(io.MouseDelta.x / tall, -io.MouseDelta.y / tall);
}

void App::press(std::size_t side, double x, double y) {
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsKeyDown(GLFW_KEY_C)) {
    knife_ = {x, y};
    return;
  }
  if (io.KeyShift) {
    pans_ = true;
    return;
  }
  const Frame& frame = *now_.sides[side].frame;
  const std::optional<int> particle = pick(frame, camera_, ports_[side], x, y);
  if (!particle) {
    orbits_ = true;
    return;
  }
  if (io.KeyCtrl) return pin_or_release(side, *particle);
  const Point3f& at = frame.x[*particle];
  const double depth = camera_.on_screen(ports_[side], {at[0], at[1], at[2]}).z();
  const auto handle = now_.sides[side].handles.find(*particle);
  dragged_ = {side, *particle, depth, handle != now_.sides[side].handles.end() && handle->second.is_held};
}

void App::drag(double x, double y) {
  if (dragged_) {
    const ImVec2 moved = ImGui::GetMouseDragDelta(0, 0);
    if (moved.x == 0 && moved.y == 0) return;
    session_.set_handle(sides_to_pull(dragged_->side), dragged_->particle,
                        vec3(camera_.at(ports_[dragged_->side], x, y, dragged_->depth)), dragged_->is_held);
    return;
  }
  const std::array<double, 2> to{x, y};
  if (std::hypot(to[0] - (*knife_)[0], to[1] - (*knife_)[1]) < 4) return;
  if (const std::optional<std::size_t> side = side_at(x, y)) {
    const std::vector<Edge> edges = edges_crossed(*now_.sides[*side].frame, camera_, ports_[*side], *knife_, to);
    if (!edges.empty()) session_.cut(*side, edges);
  }
  knife_ = to;
}

void App::pin_or_release(std::size_t side, int particle) {
  const auto& handles = now_.sides[side].handles;
  if (handles.contains(particle)) return session_.release(sides_to_pull(side), particle);
  const Point3f& at = now_.sides[side].frame->x[particle];
  session_.set_handle(sides_to_pull(side), particle, {at[0], at[1], at[2]}, true);
}

/// Returns both sides if they have the same bodies, so that a comparison pulls both alike; otherwise the side under the
/// mouse.
std::vector<std::size_t> App::sides_to_pull(std::size_t side) const {
  if (now_.sides.size() < 2) return {side};
  const SideShown &one = now_.sides[0], &other = now_.sides[1];
  const auto& a = one.scene->bodies;
  const auto& b = other.scene->bodies;
  const auto same_name = [](const BodySpec& left, const BodySpec& right) { return left.name == right.name; };
  const bool same = std::equal(a.begin(), a.end(), b.begin(), b.end(), same_name) &&
                    one.frame->body->mesh.body_begin == other.frame->body->mesh.body_begin;
  return same ? std::vector<std::size_t>{0, 1} : std::vector<std::size_t>{side};
}

void App::key(int key, int held) {
  // A text field that lost the focus in the last frame still reports WantTextInput in this one.
  if (ImGui::GetIO().WantTextInput && ImGui::IsAnyItemActive()) return;
  if (held & GLFW_MOD_CONTROL) return command_key(key);
  const auto toggle = [&](Surface surface) {
    choices_.surface = choices_.surface == surface ? Surface::Shaded : surface;
  };
  if (key >= GLFW_KEY_1 && key < GLFW_KEY_1 + int(kVisualFieldNames.size())) {
    choices_.field = VisualField(key - GLFW_KEY_1);
    session_.set_visual_field(choices_.field);
  }
  const ImVec2 cursor = ImGui::GetIO().MousePos;
  if (key == GLFW_KEY_F1) choices_.help = !choices_.help;
  if (key == GLFW_KEY_SPACE) session_.toggle_run();
  if (key == GLFW_KEY_PERIOD || key == GLFW_KEY_RIGHT) session_.step();
  if (key == GLFW_KEY_COMMA) session_.substep();
  if (key == GLFW_KEY_LEFT) session_.show_back();
  if (key == GLFW_KEY_R) session_.reset();
  if (key == GLFW_KEY_LEFT_BRACKET) session_.set_pace(now_.pace > 0 ? now_.pace / 2 : 1);
  if (key == GLFW_KEY_RIGHT_BRACKET) session_.set_pace(now_.pace > 0 ? 2 * now_.pace : 1);
  if (key == GLFW_KEY_BACKSLASH) session_.set_pace(0);
  if (key == GLFW_KEY_F && !now_.sides.empty()) show_all();
  if (key == GLFW_KEY_B) throw_ball_at(cursor.x, cursor.y);
  if (key == GLFW_KEY_W) toggle(Surface::Wireframe);
  if (key == GLFW_KEY_Q) toggle(Surface::Particles);
  if (key == GLFW_KEY_A) choices_.axes = !choices_.axes;
  if (key == GLFW_KEY_D) toggle_second(now_, session_);
  if (key == GLFW_KEY_P) picture_ = true;
  if (key == GLFW_KEY_TAB) choices_.panels = !choices_.panels;
}

void App::command_key(int key) {
  if (key == GLFW_KEY_Q) should_quit_ = true;
  if (key == GLFW_KEY_S) save();
}

void App::save() {
  if (now_.sides.empty()) return;
  try {
    const auto scene = free_name("scene", ".json");
    const auto run = std::filesystem::path(scene).replace_extension("");  // the folder for malha run --resume
    make_folder(run);
    session_.save(choices_.side, scene.string(), (run / "checkpoint.malha").string());
  } catch (const std::exception& error) {
    session_.say(error.what(), true);
  }
}

void App::throw_ball_at(double x, double y) {
  const std::optional<std::size_t> side = side_at(x, y);
  if (!side) return;
  constexpr double kFlight = 0.5;  // s, flight time to the cursor at the distance of the camera's target
  const double far = camera_.distance();
  const Eigen::Vector3d from = camera_.eye() - 0.25 * far * camera_.up();
  const Eigen::Vector3d goal = camera_.at(ports_[*side], x, y, far);
  for (std::size_t s = 0; s < now_.sides.size(); ++s) {
    Scene scene = *now_.sides[s].scene;
    Vec3 velocity = vec3((goal - from) / kFlight);
    for (int k = 0; k < 3; ++k) velocity[k] -= 0.5 * kFlight * scene.gravity[k];
    throw_ball(scene, now_.sides[s].frame->time, vec3(from), velocity, 0.06 * far);
    session_.change(s, scene);
  }
}

std::filesystem::path App::free_name(const std::string& stem, const std::string& extension) const {
  make_folder(options_.out);
  for (int number = 0;; ++number) {
    char digits[16];
    std::snprintf(digits, sizeof digits, "_%03d", number);
    const auto path = options_.out / (stem + digits + extension);
    if (!std::filesystem::exists(path)) return path;
  }
}

void App::drawn(int width, int height) {
  if (!picture_) return;
  picture_ = false;
  try {
    const auto path = free_name("picture", ".png");
    write_png(path, read_back(width, height));
    session_.say("saved " + path.string());
  } catch (const std::exception& error) {
    session_.say(error.what(), true);
  }
}

void App::panels(int width, int height) {
  const auto fixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoTitleBar |
                     ImGuiWindowFlags_NoBringToFrontOnFocus;
  const auto begin = [&](const char* name, float x, float y, float w, float h) {
    ImGui::SetNextWindowPos({x, y}), ImGui::SetNextWindowSize({w, h});
    ImGui::Begin(name, nullptr, fixed);
  };
  const float left = choices_.panels ? float(panels_.left) : 0, right = choices_.panels ? float(panels_.right) : 0;
  const float bottom = float(panels_.timeline);
  if (choices_.panels) {
    begin("settings", 0, 0, left, float(height));
    run_panel(now_, session_, choices_);
    ImGui::Separator();
    settings_panel(now_, session_, choices_, edited_);
    ImGui::End();
    begin("numbers", float(width) - right, 0, right, float(height));
    numbers_panel(now_, choices_);
    ImGui::End();
  }
  begin("timeline", left, float(height) - bottom, float(width) - left - right, bottom);
  timeline(now_, session_);
  const std::string& line = now_.doing.empty() ? now_.message : now_.doing + " ...";
  const ImVec4 colour = now_.doing.empty() && now_.is_error ? ImVec4(1, 0.5f, 0.4f, 1) : ImVec4(0.8f, 0.8f, 0.8f, 1);
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextWrapped("%s", line.c_str());
  ImGui::PopStyleColor();
  ImGui::End();
  help_panel(choices_);
}

/// Draws axes, a scale in metres, the legend of the colours, and the settings of the side.
void App::overlay(std::size_t s) {
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  const Viewport& port = ports_[s];
  const ImU32 ink = IM_COL32(40, 40, 50, 255);
  const float bottom = float(port.top + port.height), unit = panels_.scale;
  if (choices_.axes) {
    const ImVec2 origin{float(port.left) + 40 * unit, bottom - 40 * unit};
    constexpr std::array<const char*, 3> kNames{"x", "y", "z"};
    constexpr std::array<ImU32, 3> kColours{IM_COL32(210, 60, 60, 255), IM_COL32(50, 150, 60, 255),
                                            IM_COL32(60, 90, 220, 255)};
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(k);
      const ImVec2 end{origin.x + 28 * unit * float(axis.dot(camera_.right())),
                       origin.y - 28 * unit * float(axis.dot(camera_.up()))};
      draw->AddLine(origin, end, kColours[k], 2);
      draw->AddText({end.x + 2, end.y - 6 * unit}, kColours[k], kNames[k]);
    }
    const double pixel = camera_.metres_per_pixel(port, camera_.distance());
    const double metres = std::pow(10, std::floor(std::log10(0.25 * port.width * pixel)));
    const float length = float(metres / pixel), right = float(port.left + port.width) - 16;
    draw->AddLine({right - length, bottom - 14 * unit}, {right, bottom - 14 * unit}, ink, 2);
    const std::string text = shown(metres) + " m";
    const float wide = std::max(length, ImGui::CalcTextSize(text.c_str()).x);
    draw->AddText({right - wide, bottom - 32 * unit}, ink, text.c_str());
  }
  const auto& coloured = coloured_[s];
  const float x = float(port.left) + 12;
  const float room = std::max(float(port.left + port.width) - x - 8, 60 * unit);
  float y = float(port.top) + 10;
  const auto say = [&](const std::string& text) {  // wrapped to the width of the side
    draw->AddText(nullptr, 0, {x, y}, ink, text.c_str(), nullptr, room);
    y += ImGui::CalcTextSize(text.c_str(), nullptr, false, room).y + 4;
  };
  if (now_.sides.size() == 2) {
    const SolverSpec& solver = now_.sides[s].scene->solver;
    char times[64];
    std::snprintf(times, sizeof times, "dt %.4g s, %.3g ms a step", solver.dt, now_.sides[s].frame->step_ms);
    say(solver.type + ", " + counted(solver.substeps, "substep")), say(times);
  }
  if (const Body& body = *now_.sides[s].frame->body; decimated_ && body.decimated) {
    const std::string drawn = "while it moves " + std::to_string(body.decimated->particles.size()) + " of " +
                              std::to_string(body.mesh.points.size()) + " particles are drawn";
    say(drawn);
  }
  if (!coloured.most) return say(coloured.legend);
  for (int k = 0; k < 120; ++k) {
    const Colour c = turbo(k / 119.0);
    draw->AddRectFilled({x + unit * float(k), y}, {x + unit * float(k + 1), y + 10}, IM_COL32(c[0], c[1], c[2], 255));
  }
  draw->AddText({x, y + 12}, ink, "0");
  draw->AddText(nullptr, 0, {x + 90 * unit, y + 12}, ink, (shown(*coloured.most) + " " + coloured.legend).c_str(),
                nullptr, room - 90 * unit);
}

}  // namespace malha::view
