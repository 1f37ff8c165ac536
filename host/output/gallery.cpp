// SPDX-License-Identifier: Apache-2.0
#include "host/output/gallery.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/attachments/object_motion.h"
#include "host/base/file.h"
#include "host/model/tear.h"
#include "host/output/choose_camera.h"

namespace malha {

namespace {

constexpr int kScenes = 6, kColumns = 3;  // pictures and columns of the storyboard

std::vector<std::array<float, 3>> to_float(const std::vector<Vec3>& points, int begin, int end) {
  std::vector<std::array<float, 3>> result;
  for (int i = begin; i < end; ++i) result.push_back({float(points[i][0]), float(points[i][1]), float(points[i][2])});
  return result;
}

Drawing draw_body(const Model& model, const std::vector<Vec3>& positions, int body) {
  const RenderMesh& render_mesh = model.render_mesh;
  const Mesh mesh = body_mesh(render_mesh, body);
  Drawing drawing;
  drawing.points = to_float(positions, render_mesh.body_begin[body], render_mesh.body_begin[body + 1]);
  add_faces(drawing, mesh.faces);
  drawing.lines = mesh.lines;
  drawing.loose = mesh.faces.empty();
  drawing.colour = body_colour(body);
  drawing.name = model.scene.bodies[body].name;
  return drawing;
}

}  // namespace

Drawing draw_environment(const EnvironmentMesh& mesh, double time) {
  const std::vector<Vec3> points = points_at(mesh, time);
  Drawing drawing;
  drawing.points = to_float(points, 0, static_cast<int>(points.size()));
  add_faces(drawing, mesh.mesh.faces);
  drawing.wire = false;
  drawing.colour = stone_colour();
  drawing.name = mesh.spec.name;
  return drawing;
}

std::vector<Drawing> draw(const Model& model, const std::vector<Vec3>& positions, double time) {
  std::vector<Drawing> drawings;
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b)
    drawings.push_back(draw_body(model, positions, static_cast<int>(b)));
  for (const EnvironmentMesh& mesh : model.environment) drawings.push_back(draw_environment(mesh, time));
  return drawings;
}

Gallery::Gallery(const Simulation& simulation, const Results& results, std::int64_t first, std::int64_t last,
                 const std::atomic<bool>* stop)
    : simulation_(simulation),
      results_(results),
      first_(first),
      last_(last),
      camera_(choose_camera(simulation.model(), *simulation.model().scene.outputs.picture)),
      stop_(stop) {
  if (simulation.model().scene.outputs.picture_every > 0) make_folder(results.pictures);
}

bool Gallery::in_series(std::int64_t step) const {
  const int every = simulation_.model().scene.outputs.picture_every;
  return every > 0 && step % every == 0;
}

bool Gallery::in_storyboard(std::int64_t step) const {
  // kScenes steps are evenly distributed from the first to the last.
  const auto scene = [this](std::int64_t at) { return (at - first_) * (kScenes - 1) / (last_ - first_); };
  return step == first_ || scene(step) != scene(step - 1);
}

bool Gallery::is_due(std::int64_t step) const { return in_series(step) || in_storyboard(step); }

void Gallery::draw_if_due(std::int64_t step, double time, const std::vector<Vec3>& positions) {
  if (in_series(step)) {
    char name[64];
    std::snprintf(name, sizeof name, "picture_%06lld.png", static_cast<long long>(step));
    if (const Image image = render_image(time, positions, 1, stop_); image.width > 0)
      write_png(results_.pictures / name, image);
  }
  if (!in_storyboard(step)) return;
  if (Image image = render_image(time, positions, 2, stop_); image.width > 0) storyboard_.push_back(std::move(image));
}

void Gallery::finish(double time, const std::vector<Vec3>& positions) const {
  write_png(results_.picture, render_image(time, positions, 1, nullptr));
}

void Gallery::write_storyboard() const { write_png(results_.storyboard, contact_sheet(storyboard_, kColumns)); }

Image Gallery::render_image(double time, const std::vector<Vec3>& positions, int divisor,
                            const std::atomic<bool>* stop) const {
  const auto& size = simulation_.model().scene.outputs.picture->size;
  return render(draw(simulation_.model(), positions, time), camera_, std::max(1, size[0] / divisor),
                std::max(1, size[1] / divisor), simulation_.threads(), stop);
}

}  // namespace malha
