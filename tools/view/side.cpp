// SPDX-License-Identifier: Apache-2.0
#include "tools/view/side.h"

#include <cmath>

#include "host/base/file.h"
#include "host/base/stopwatch.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/report/warnings.h"

namespace malha::view {

namespace {

constexpr double kDecimatedParticles = 40'000;  // particles, about
constexpr double kCompliance = 1e-3;            // m/N, of the handle's spring: a weight of 1 kg extends it by 1 cm

std::shared_ptr<const Body> body_of(const Model& model) {
  auto body = std::make_shared<Body>();
  body->mesh = model.render_mesh;
  const Mesh mesh{model.render_mesh.points, model.render_mesh.faces, model.render_mesh.lines, {}};
  std::vector<bool> used(model.render_mesh.points.size(), false);
  for (const Triangle& t : triangles(mesh)) {
    body->triangles.push_back({unsigned(t[0]), unsigned(t[1]), unsigned(t[2])});
    for (const int i : t) used[i] = true;
  }
  for (const Edge& e : edges(mesh))
    body->edges.push_back({unsigned(e[0]), unsigned(e[1])}), used[e[0]] = used[e[1]] = true;
  const std::vector<Vec3>& start = model.render_mesh.points;
  for (const auto& [a, b] : body->edges) body->spacing += distance(start[a], start[b]) / double(body->edges.size());
  for (unsigned i = 0; i < used.size(); ++i)
    if (!used[i]) body->loose.push_back(i);
  for (int i = 0; i < model.count(); ++i)
    if (!(model.w[i] > 0)) body->pinned.push_back(unsigned(model.user_index[i]));
  if (body->triangles.size() > kManyTriangles)
    body->decimated = decimate(used.size(), body->triangles, body->edges, double(used.size()) / kDecimatedParticles);
  return body;
}

}  // namespace

Side::Side(const Scene& scene, const SimulationOptions& options) : options_(options) {
  options_.interactive = true;
  change(scene, true);
}

void Side::change(const Scene& scene, bool from_start) {
  std::unique_ptr<Simulation> next;
  set_up_ms_ = 1e3 * seconds([&] {
                 next = std::make_unique<Simulation>(scene, options_);
                 if (!from_start && simulation_) next->transfer_state_from(*simulation_);
               });
  simulation_ = std::move(next);
  scene_ = std::make_shared<const Scene>(scene);
  environment_ = std::make_shared<const std::vector<EnvironmentMesh>>(simulation_->model().environment);
  warnings_ = malha::warnings(simulation_->model());
  before_ = {}, pass_ms_ = {}, step_ms_ = 0;
  const std::map<int, Handle> handles = std::exchange(handles_, {});
  update_body();
  if (from_start) return;
  for (const auto& [particle, one] : handles) {
    try {
      set_handle(particle, one.to, one.is_held);
    } catch (const InputError&) {  // the new scene has no such particle or cannot hold it, so it is released
    }
  }
}

void Side::restore_scene(const std::shared_ptr<const Scene>& scene) {
  change(*scene, true);
  scene_ = scene;  // the same pointer, which identifies it
}

void Side::update_body() {
  const RenderMesh& mesh = simulation_->model().render_mesh;
  const auto same = [&mesh](const RenderMesh& one) {
    return one.points == mesh.points && one.faces == mesh.faces && one.lines == mesh.lines &&
           one.body_begin == mesh.body_begin;
  };
  if (!body_ || !same(body_->mesh)) body_ = body_of(simulation_->model());
  tears_ = simulation_->tears();
  fields_.reset();
  handles_.clear();  // tears may have renumbered the particles
  for (const ParticleHandle& one : simulation_->handles()) handles_[one.particle] = {one.to, one.is_held()};
}

std::shared_ptr<const VisualFields> Side::fields(VisualField field) {
  VisualFields next = fields_ ? *fields_ : VisualFields{body_, nullptr, nullptr, nullptr, nullptr, nullptr};
  const Model& model = simulation_->model();
  const bool structure =
      field == VisualField::Patch || field == VisualField::PatchColour || field == VisualField::Batch;
  if (field == VisualField::Strain && !next.strains)
    next.strains = std::make_shared<const Strains>(model);
  else if (field == VisualField::Residual && !next.residuals)
    next.residuals = std::make_shared<const Residuals>(model);
  else if (field == VisualField::Contact && !next.contacts)
    next.contacts = std::make_shared<const Contacts>(model);
  else if (field == VisualField::Force && !next.forces)
    next.forces = std::make_shared<const PinForces>(model);
  else if (structure && !next.structure)
    next.structure = std::make_shared<const Structure>(malha::structure(model, threads()));
  else if (fields_)
    return fields_;
  return fields_ = std::make_shared<const VisualFields>(std::move(next));
}

void Side::step() {
  step_ms_ = 1e3 * seconds([&] { simulation_->step(); });
  const auto& now = simulation_->solver().pass_seconds();
  for (std::size_t k = 0; k < now.size(); ++k) pass_ms_[k] = 1e3 * (now[k] - before_[k]);
  before_ = now;
  if (simulation_->tears() != tears_) update_body();
}

std::vector<std::shared_ptr<const Frame>> Side::step_by_substeps() {
  std::vector<std::shared_ptr<const Frame>> parts;
  simulation_->step([&](int substep, double time) {
    if (substep == scene_->solver.substeps) return;
    const auto part = std::make_shared<Frame>(*frame(false));
    part->substep = substep, part->time = time;
    parts.push_back(part);
  });
  before_ = simulation_->solver().pass_seconds();  // the time of copying frames is no time of a step
  if (simulation_->tears() != tears_) update_body();
  return parts;
}

std::size_t Side::bytes_of_substeps() const {
  return std::size_t(scene_->solver.substeps) * body_->mesh.points.size() * (sizeof(Point3f) + sizeof(float));
}

std::shared_ptr<const Frame> Side::frame(bool measured) {
  auto frame = std::make_shared<Frame>();
  frame->steps = simulation_->steps(), frame->time = simulation_->time(), frame->body = body_,
  frame->environment = environment_;
  for (const Vec3& x : simulation_->positions()) frame->x.push_back(to_point3f(x));
  for (const Vec3& v : simulation_->velocities()) frame->speed.push_back(float(std::sqrt(dot(v, v))));
  if (measured) frame->measures = simulation_->measure();
  frame->step_ms = step_ms_, frame->pass_ms = pass_ms_;
  return frame;
}

void Side::set_handle(int particle, const Vec3& to, bool is_held) {
  if (is_held)
    simulation_->hold(particle, to);
  else
    simulation_->pull(particle, to, kCompliance);
  handles_[particle] = {to, is_held};
}

void Side::release(int particle) {
  simulation_->release(particle);
  handles_.erase(particle);
}

void Side::release_all() {
  while (!handles_.empty()) release(handles_.begin()->first);
}

int Side::cut(const std::vector<Edge>& edges) {
  const int parted = simulation_->cut(edges);
  if (parted > 0) update_body();
  return parted;
}

void Side::save(const std::string& scene_path, const std::string& checkpoint_path) const {
  write_whole(scene_path, to_json(*scene_));
  simulation_->save_checkpoint(checkpoint_path);
}

void save_state(const Scene& scene, const std::string& state, const SimulationOptions& options,
                const std::string& scene_path, const std::string& checkpoint_path) {
  Simulation simulation(scene, options);
  simulation.restore_state(state);
  write_whole(scene_path, to_json(scene));
  simulation.save_checkpoint(checkpoint_path);
}

void Side::restore_state(const std::string& state) {
  release_all();
  simulation_->restore_state(state);
  if (simulation_->tears() != tears_) update_body();
  before_ = simulation_->solver().pass_seconds(), pass_ms_ = {}, step_ms_ = 0;
}

int Side::diverged_particle() const {
  const std::vector<Vec3> x = simulation_->positions(), v = simulation_->velocities();
  int fastest = -1;
  double most = -1;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double speed = std::hypot(v[i][0], v[i][1], v[i][2]);
    if (!std::isfinite(x[i][0] + x[i][1] + x[i][2]) || !std::isfinite(speed)) return static_cast<int>(i);
    if (speed > most) most = speed, fastest = static_cast<int>(i);
  }
  return fastest;
}

}  // namespace malha::view
