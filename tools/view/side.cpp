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

constexpr double kCoarse = 40'000;    // particles, about
constexpr double kCompliance = 1e-3;  // m/N, of the spring that pulls: 1 kg on it hangs 1 cm lower

std::shared_ptr<const Body> body_of(const Model& model) {
  auto body = std::make_shared<Body>();
  body->look = model.render_mesh;
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
    body->coarse = coarse_of(used.size(), body->triangles, body->edges, double(used.size()) / kCoarse);
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
  const std::map<int, Grip> grips = std::exchange(grips_, {});
  note_body();
  if (from_start) return;
  for (const auto& [particle, one] : grips) {
    try {
      grip(particle, one.to, one.firm);
    } catch (const InputError&) {  // the new scene has no such particle, or cannot hold it: it is free
    }
  }
}

void Side::change_back(const std::shared_ptr<const Scene>& scene) {
  change(*scene, true);
  scene_ = scene;  // the very same: it is known by that
}

void Side::note_body() {
  const RenderMesh& look = simulation_->model().render_mesh;
  const auto same = [&look](const RenderMesh& one) {
    return one.points == look.points && one.faces == look.faces && one.lines == look.lines &&
           one.body_begin == look.body_begin;
  };
  if (!body_ || !same(body_->look)) body_ = body_of(simulation_->model());
  tears_ = simulation_->tears();
  looks_.reset();
  grips_.clear();  // tears may have numbered them anew
  for (const ParticleHandle& one : simulation_->handles()) grips_[one.particle] = {one.to, one.is_held()};
}

std::shared_ptr<const Looks> Side::looks(Look look) {
  Looks next = looks_ ? *looks_ : Looks{body_, nullptr, nullptr, nullptr, nullptr, nullptr};
  const Model& model = simulation_->model();
  const bool structure = look == Look::Patch || look == Look::Phase || look == Look::Batch;
  if (look == Look::Strain && !next.strains)
    next.strains = std::make_shared<const Strains>(model);
  else if (look == Look::Residual && !next.residuals)
    next.residuals = std::make_shared<const Residuals>(model);
  else if (look == Look::Contact && !next.contacts)
    next.contacts = std::make_shared<const Contacts>(model);
  else if (look == Look::Force && !next.forces)
    next.forces = std::make_shared<const PinForces>(model);
  else if (structure && !next.structure)
    next.structure = std::make_shared<const Structure>(malha::structure(model, threads()));
  else if (looks_)
    return looks_;
  return looks_ = std::make_shared<const Looks>(std::move(next));
}

void Side::step() {
  step_ms_ = 1e3 * seconds([&] { simulation_->step(); });
  const auto& now = simulation_->solver().pass_seconds();
  for (std::size_t k = 0; k < now.size(); ++k) pass_ms_[k] = 1e3 * (now[k] - before_[k]);
  before_ = now;
  if (simulation_->tears() != tears_) note_body();
}

std::vector<std::shared_ptr<const Frame>> Side::step_in_parts() {
  std::vector<std::shared_ptr<const Frame>> parts;
  simulation_->step([&](int substep, double time) {
    if (substep == scene_->solver.substeps) return;
    const auto part = std::make_shared<Frame>(*frame(false));
    part->substep = substep, part->time = time;
    parts.push_back(part);
  });
  before_ = simulation_->solver().pass_seconds();  // looking took time: of no use as the time of a step
  if (simulation_->tears() != tears_) note_body();
  return parts;
}

std::size_t Side::bytes_of_parts() const {
  return std::size_t(scene_->solver.substeps) * body_->look.points.size() * (sizeof(Place) + sizeof(float));
}

std::shared_ptr<const Frame> Side::frame(bool measured) {
  auto frame = std::make_shared<Frame>();
  frame->steps = simulation_->steps(), frame->time = simulation_->time(), frame->body = body_,
  frame->environment = environment_;
  for (const Vec3& x : simulation_->positions()) frame->x.push_back(place_of(x));
  for (const Vec3& v : simulation_->velocities()) frame->speed.push_back(float(std::sqrt(dot(v, v))));
  if (measured) frame->measures = simulation_->measure();
  frame->step_ms = step_ms_, frame->pass_ms = pass_ms_;
  return frame;
}

void Side::grip(int particle, const Vec3& to, bool firm) {
  if (firm)
    simulation_->hold(particle, to);
  else
    simulation_->pull(particle, to, kCompliance);
  grips_[particle] = {to, firm};
}

void Side::release(int particle) {
  simulation_->release(particle);
  grips_.erase(particle);
}

void Side::release_all() {
  while (!grips_.empty()) release(grips_.begin()->first);
}

int Side::cut(const std::vector<Edge>& edges) {
  const int parted = simulation_->cut(edges);
  if (parted > 0) note_body();
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
  if (simulation_->tears() != tears_) note_body();
  before_ = simulation_->solver().pass_seconds(), pass_ms_ = {}, step_ms_ = 0;
}

int Side::lost() const {
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
