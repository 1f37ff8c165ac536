// SPDX-License-Identifier: Apache-2.0
#include "malha/simulation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "host/base/adaptive_thread_count.h"
#include "host/base/hash.h"
#include "host/base/start_threads.h"
#include "host/environment/edge_crossings.h"
#include "host/environment/initial_overlap.h"
#include "host/environment/solid_crossings.h"
#include "host/mesh/vectors.h"
#include "host/model/cut.h"
#include "host/model/machine.h"
#include "host/model/memory_estimate.h"
#include "host/model/set_pins.h"
#include "host/model/tear.h"
#include "host/model/validate_outputs.h"
#include "host/report/expect.h"
#include "host/report/report.h"
#include "host/run/checkpoint.h"
#include "host/solver/solver.h"
#include "kernels/parallel/compute.h"
#include "malha/text.h"

namespace malha {

namespace {

/// So many rows of numbers that squares of stay finite in single precision.
void require_numbers(const char* what, const std::vector<Vec3>& rows, std::size_t count, const char* each) {
  if (rows.size() != count) refuse(what, "", counted(rows.size(), "row"), std::to_string(count) + ", " + each);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const double number : rows[i])
      if (!(std::abs(number) <= 1e18)) refuse(what, "row " + std::to_string(i), shown(number), "numbers up to 1e18");
}

}  // namespace

Backend backend_named(const std::string& name) {
  const auto found = std::find(kBackends.begin(), kBackends.end(), name);
  if (found == kBackends.end())
    refuse("simulation", "backend", malha::quoted(name), "\"openmp\", \"serial\", \"cuda\"");
  return static_cast<Backend>(found - kBackends.begin());
}

struct Simulation::Parts {
  Model model;  // the solver refers to it
  std::unique_ptr<Solver> solver;
  SimulationOptions options;
  RunTimes times;
  int threads = 1;
  std::optional<AdaptiveThreadCount> choice;      // none: all threads, always
  std::optional<std::uint64_t> scene;             // its hash: the same all the time, taken when it is first needed
  std::optional<std::vector<int>> pins_at_start;  // where others were set: layouts depend on them
  // Of scenes that tear:
  RenderMesh whole;  // before the first tear
  std::vector<Split> splits;

  /// Of the model before any tear.
  std::uint64_t hash_of_scene() {
    if (!scene) scene = scene_hash(model);
    return *scene;
  }
  /// What its checkpoints are for. Gravity and wind are not in them, so that those of the start count.
  std::uint64_t hash_of_scene_now() {
    if (!pins_at_start) return hash_of_scene();
    const std::vector<int> now = still_pins(model);
    return now == *pins_at_start ? hash_of_scene() : hash_bytes(now.data(), now.size() * sizeof(int), hash_of_scene());
  }

  void make_solver_of_model() {
    model.interactive =
        options.interactive || !options.constraints.empty();  // either acts on what the visits do not know
    solver = options.backend == Backend::Cuda
                 ? make_solver_on_cuda(model, threads, options.progress, options.timed_passes)
                 : make_solver(model, threads, options.instructions, options.progress);
    times.strains.every = solver->steps_to_sample();
    if (!options.constraints.empty()) add_user_constraints();
    release_setup_memory(model);
  }
  /// By the present numbers: what tears shifts those of the bodies behind it.
  void add_user_constraints() {
    std::vector<UserConstraint> all = options.constraints;
    for (UserConstraint& one : all)
      for (int& particle : one.particles)
        for (std::size_t body = 0; body + 1 < whole.body_begin.size(); ++body)
          if (particle >= whole.body_begin[body] && particle < whole.body_begin[body + 1]) {
            particle += model.look.body_begin[body] - whole.body_begin[body];
            break;
          }
    solver->add_user_constraints(all);
  }

  /// A step of constraints whose functions may throw: then it was none.
  void step_whole(const SubstepCallback& after) {
    const std::string before = solver->save();
    const std::vector<ParticleHandle> taken = solver->taken();
    try {
      solver->step(after);
    } catch (const Diverged&) {
      throw;
    } catch (...) {
      solver->restore(before);
      for (const ParticleHandle& one : taken) solver->take(one);
      throw;
    }
  }
  /// What is taken by hand stays taken.
  void place(const std::vector<Vec3>& x, const std::vector<Vec3>& v) {
    const std::vector<ParticleHandle> taken = solver->taken();
    place(solver->steps(), x, v);
    for (const ParticleHandle& one : taken) solver->take(one);
  }
  /// Pins have the velocity 0, or that of their keyframes, which any step gives anew: with another one, substeps that
  /// are passes would carry them off.
  void place(std::int64_t steps, const std::vector<Vec3>& x, std::vector<Vec3> v) {
    const double time = static_cast<double>(steps) * model.scene.solver.dt;
    const std::vector<bool> pinned = pinned_now(model, time), driven = on_keyframes(model);
    const std::vector<Vec3> now = solver->velocities();
    for (std::size_t i = 0; i < v.size(); ++i)
      if (pinned[i]) v[i] = driven[i] ? now[i] : Vec3{0, 0, 0};
    solver->set_state(steps, x, v);
  }

  /// Refuses a state from which no step can start.
  void require_finite(const char* what) const {
    for (const auto& rows : {solver->positions(), solver->velocities()})
      for (std::size_t i = 0; i < rows.size(); ++i)
        if (!finite(rows[i]))
          refuse(what, "", particle_name(model, static_cast<int>(i)) + ", which has no finite place or velocity",
                 "a finite state");
  }

  /// Lays everything out with these splits, in a state that is still to be given.
  void lay_out(std::vector<Split> all, Model torn) {
    solver.reset();
    model = std::move(torn);
    make_solver_of_model();
    splits = std::move(all), times.splits = static_cast<int>(splits.size());
    ++times.layouts;
  }
  Model torn(const std::vector<Split>& all) const {
    return build_torn_model(model.scene, {&whole, &all, &model.environment, model.zero_area_faces, &model.notes},
                            threads, model.patches.bounds);
  }

  void tear() { split(find_tears(model, solver->positions(), pinned())); }
  std::vector<bool> pinned() const {
    std::vector<int> held;
    for (const ParticleHandle& one : solver->taken())
      if (one.is_held()) held.push_back(one.particle);
    return pinned_now(model, solver->time(), held);
  }
  void split(const std::vector<Split>& found) {
    if (found.empty()) return;
    times.layout_seconds += seconds([&] {
      std::vector<Split> all = splits;
      all.insert(all.end(), found.begin(), found.end());
      Model next = torn(all);
      const std::vector<int> from = ancestors(model, next, all, splits.size());
      const std::string state = solver->save();
      const auto passes = solver->pass_seconds();
      const std::size_t particles = model.x.size();
      std::vector<ParticleHandle> taken = solver->taken();
      for (ParticleHandle& one : taken) {  // duplicates are the last of their bodies
        const int body = body_of(model, one.particle);
        one.particle += next.look.body_begin[body] - model.look.body_begin[body];
      }
      lay_out(std::move(all), std::move(next));
      solver->restore_after_split(state, particles, from, passes);
      for (const ParticleHandle& one : taken) solver->take(one);
    });
  }

  /// What the next step depends on: the tears, where there can be any, and the solver's state.
  std::string save() const {
    if (!malha::tears(model.scene)) return solver->save();
    const std::vector<int> numbers = numbers_of(splits);
    const std::uint64_t count = numbers.size();
    std::string bytes(reinterpret_cast<const char*>(&count), sizeof count);
    if (count > 0) bytes.append(reinterpret_cast<const char*>(numbers.data()), count * sizeof(int));
    return bytes + solver->save();
  }
  /// `file`: what a refusal names. After one everything is as it was.
  void restore(const std::string& bytes, const std::string& file) {
    if (!malha::tears(model.scene)) return solver->restore(bytes, file);
    std::uint64_t count = 0;
    if (bytes.size() < sizeof count) refuse(file, "state", counted(bytes.size(), "byte"), "a number of tears at least");
    std::memcpy(&count, bytes.data(), sizeof count);
    const std::size_t most = (bytes.size() - sizeof count) / sizeof(int);
    if (count > most) refuse(file, "tears", counted(count, "number"), "at most the " + std::to_string(most) + " there");
    std::vector<int> numbers(count);
    if (count > 0) std::memcpy(numbers.data(), bytes.data() + sizeof count, count * sizeof(int));
    const std::string state = bytes.substr(sizeof count + count * sizeof(int));
    if (numbers == numbers_of(splits)) return solver->restore(state, file);
    std::vector<Split> all = splits_of(numbers, model.scene, whole, file), before = splits;
    const std::string there = solver->save();
    const std::vector<ParticleHandle> taken = solver->taken();
    lay_out_anew(std::move(all));
    try {
      solver->restore(state, file);
    } catch (const InputError&) {
      lay_out_anew(std::move(before));
      solver->restore(there);
      for (const ParticleHandle& one : taken) solver->take(one);
      throw;
    }
  }
  void lay_out_anew(std::vector<Split> all) {
    Model next = torn(all);
    lay_out(std::move(all), std::move(next));
  }
};

Simulation::Simulation(const Scene& scene, const SimulationOptions& options) : parts_(std::make_unique<Parts>()) {
  const bool serial = options.backend == Backend::Serial, on_device = options.backend == Backend::Cuda;
  if (on_device) require_cuda();
  parts_->options = options;
  parts_->threads = serial ? 1 : options.threads > 0 ? options.threads : available_threads();
  require_threads(parts_->threads);
  if ((options.threads <= 0 || options.adaptive_threads) && !on_device) parts_->choice.emplace(parts_->threads);
  const auto doing = [&](const char* what) {
    if (options.progress) options.progress(what, -1);
  };
  doing("reading meshes, listing and ordering constraints");
  parts_->times.model_seconds = seconds([&] {
    parts_->model =
        build_model(scene, parts_->threads, machine_named(options.machine).patch_bounds(scene.solver.precision));
    note_solid_crossings(parts_->model);
    start_outside(parts_->model), note_starts_behind(parts_->model);
    refuse_edge_crossings(parts_->model);
  });
  doing(scene.environment.empty() ? "colouring and laying out" : "colouring and laying out, building trees");
  parts_->times.solver_seconds = seconds([&] { parts_->make_solver_of_model(); });
  if (malha::tears(scene)) parts_->whole = parts_->model.look, parts_->hash_of_scene();
}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

void Simulation::step() { step(SubstepCallback{}); }

void Simulation::step(const SubstepCallback& after) {
  std::optional<LaunchTrace> trace;
  if (parts_->times.steps.count() == 0) trace.emplace();
  if (parts_->threads > 1 && parts_->choice && parts_->choice->threads() == 1) ++parts_->times.steps_alone;
  const auto step = [&] {
    parts_->options.constraints.empty() ? parts_->solver->step(after) : parts_->step_whole(after);
  };
  parts_->times.steps.add(seconds([&] {
    parts_->choice ? parts_->choice->take(step) : step();
    if (parts_->solver->overstretched()) parts_->tear();
    LargestStrains& strains = parts_->times.strains;
    if (strains.every > 0 && steps() % strains.every == 0) strains.take(parts_->solver->strains(), steps());
  }));
  if (trace) parts_->times.launches = trace->list();
}

void Simulation::check_divergence() { parts_->solver->check_divergence(); }

void Simulation::move_pin(int particle, const Vec3& to) { parts_->solver->move_pins({particle}, {to}); }
void Simulation::move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to) {
  require_numbers("places of pins", to, particles.size(), "one a pin");
  parts_->solver->move_pins(particles, to);
}

void Simulation::set_positions(const std::vector<Vec3>& x) {
  require_numbers("positions", x, parts_->model.x.size(), "one a particle");
  std::vector<Vec3> v = velocities();
  for (Vec3& one : v)
    if (!finite(one)) one = {0, 0, 0};
  parts_->place(x, v);
}
void Simulation::set_velocities(const std::vector<Vec3>& v) {
  require_numbers("velocities", v, parts_->model.x.size(), "one a particle");
  const std::vector<Vec3> x = positions();
  if (!std::all_of(x.begin(), x.end(), finite))
    refuse("velocities", "", "positions that are not finite", "to set positions first");
  parts_->place(x, v);
}

void Simulation::set_gravity(const Vec3& gravity) {
  require_numbers("gravity", {gravity}, 1, "one");
  if (gravity == parts_->model.scene.gravity) return;
  parts_->hash_of_scene();
  if (!parts_->solver->facts().levels.empty()) {
    Scene scene = parts_->model.scene;
    scene.gravity = gravity;
    return lay_out_anew(scene);
  }
  parts_->model.scene.gravity = gravity;
  parts_->solver->change_gravity();
}
void Simulation::set_wind(const Vec3& velocity) {
  require_numbers("wind", {velocity}, 1, "one");
  Scene& scene = parts_->model.scene;
  if (!scene.wind) refuse("set_wind", "", "a scene without wind", "one that names it: air is laid out at the start");
  if (velocity == scene.wind->velocity) return;
  parts_->hash_of_scene();
  scene.wind->velocity = velocity;
  parts_->solver->change_wind();
}

std::vector<int> Simulation::pins() const { return still_pins(parts_->model); }
void Simulation::set_pins(std::vector<int> particles) {
  std::sort(particles.begin(), particles.end());
  particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
  const std::vector<int> before = pins();
  if (particles == before) return;
  if (!parts_->splits.empty())
    refuse("pins", "", "a scene that has torn", "to set them before a vertex is torn or cut in two");
  const Scene scene = with_pins(parts_->model, particles);
  parts_->hash_of_scene();
  if (!parts_->pins_at_start) parts_->pins_at_start = before;
  lay_out_anew(scene, particles);
}

void Simulation::lay_out_anew(const Scene& scene, const std::optional<std::vector<int>>& pins) {
  Simulation next(scene, parts_->options);
  Parts& parts = *next.parts_;
  if (!parts_->splits.empty()) parts.lay_out_anew(parts_->splits);
  if (pins && next.pins() != *pins)
    refuse("pins", "", "a particle left out that a rigid attachment holds", "all those that attachments hold");
  parts.place(steps(), positions(), velocities());
  for (const ParticleHandle& one : handles())
    if (!pins || !std::binary_search(pins->begin(), pins->end(), one.particle)) parts.solver->take(one);
  parts.scene = parts_->scene, parts.pins_at_start = parts_->pins_at_start;
  std::swap(parts.times, parts_->times);
  *this = std::move(next);
}

void Simulation::pull(int particle, const Vec3& to, double compliance) {
  if (compliance == 0)  // which would be a hold
    throw InputError("pull: found compliance 0; allowed: 1e-12 to 1e12 m/N");
  parts_->solver->take({particle, to, compliance});
}
void Simulation::hold(int particle) {
  const std::vector<Vec3> x = positions();
  const bool there = particle >= 0 && static_cast<std::size_t>(particle) < x.size();
  hold(particle, there ? x[particle] : Vec3{});
}
void Simulation::hold(int particle, const Vec3& to) { parts_->solver->take({particle, to}); }
void Simulation::release(int particle) { parts_->solver->release(particle); }
std::vector<ParticleHandle> Simulation::handles() const { return parts_->solver->taken(); }

int Simulation::cut(const std::vector<Edge>& edges) {
  const std::vector<Split> found = find_cuts(parts_->model, edges, parts_->pinned());
  parts_->split(found);
  if (!found.empty()) parts_->solver->wake();
  return static_cast<int>(found.size());
}

std::string Simulation::save_state() const { return stamped(parts_->save(), parts_->hash_of_scene_now()); }
void Simulation::restore_state(const std::string& state) {
  parts_->restore(unstamped(state, parts_->hash_of_scene_now()), "state");
}

void Simulation::wake() { parts_->solver->wake(); }

double Simulation::time() const { return parts_->solver->time(); }
std::int64_t Simulation::steps() const { return parts_->solver->steps(); }
int Simulation::threads() const { return parts_->threads; }
int Simulation::tears() const { return parts_->times.splits; }
std::vector<Vec3> Simulation::positions() const { return parts_->solver->positions(); }
std::vector<Vec3> Simulation::velocities() const { return parts_->solver->velocities(); }
std::vector<double> Simulation::inverse_masses() const { return parts_->solver->inverse_masses(); }
std::vector<double> Simulation::constraint_values(std::size_t index) const {
  return parts_->solver->values_of_user_constraint(index);
}
std::vector<int> Simulation::particles_of_vertices(std::size_t body) const {
  return malha::particles_of_vertices(parts_->model.look, body);
}
Measures Simulation::measure() const { return parts_->solver->measure(); }
void Simulation::count_crossings() {
  const Scene& scene = parts_->model.scene;
  if (!scene.self_collision && !names_edges(scene)) return;
  RunTimes& times = parts_->times;
  times.most_crossings = std::max(times.most_crossings, parts_->solver->crossings()), ++times.crossings_counted;
}
std::uint64_t Simulation::state_hash() const { return parts_->solver->state_hash(); }

std::vector<std::string> Simulation::failed_expectations() const {
  const Model& model = parts_->model;
  std::vector<ParticlesOfBody> bodies;
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b)
    bodies.push_back({model.scene.bodies[b].name, static_cast<std::size_t>(model.look.body_begin[b]),
                      static_cast<std::size_t>(model.look.body_begin[b + 1]), model.look.vertices[b]});
  Measures measures = measure();
  measures.crossings = std::max(measures.crossings, parts_->times.most_crossings);
  return unmet_expectations(model.scene.expect, measures, positions(), bodies);
}

void Simulation::save_checkpoint(const std::string& path, std::int64_t frames) const {
  parts_->require_finite("checkpoint");
  write_checkpoint(path, parts_->hash_of_scene_now(),
                   {parts_->save(), frames, parts_->times.most_crossings, parts_->times.crossings_counted});
}

std::int64_t Simulation::load_checkpoint(const std::string& path) {
  const Checkpoint checkpoint = read_checkpoint(path, parts_->hash_of_scene_now());
  parts_->restore(checkpoint.state, path);
  parts_->times.most_crossings = checkpoint.crossings, parts_->times.crossings_counted = checkpoint.counted;
  return checkpoint.frames;
}

void Simulation::transfer_state_from(const Simulation& before) {
  if (malha::tears(model().scene) && !before.parts_->splits.empty()) parts_->lay_out_anew(before.parts_->splits);
  const RenderMesh &now = model().look, &then = before.model().look;
  std::vector<Vec3> x = positions(), v = velocities();
  const std::vector<Vec3> x_then = before.positions(), v_then = before.velocities();
  for (std::size_t b = 0; b < model().scene.bodies.size(); ++b)
    for (std::size_t a = 0; a < before.model().scene.bodies.size(); ++a) {
      const int first = now.body_begin[b], from = then.body_begin[a], count = then.body_begin[a + 1] - from;
      const bool same = model().scene.bodies[b].name == before.model().scene.bodies[a].name;
      if (!same || now.body_begin[b + 1] - first != count) continue;
      std::copy_n(x_then.begin() + from, count, x.begin() + first);
      std::copy_n(v_then.begin() + from, count, v.begin() + first);
    }
  const auto steps = static_cast<std::int64_t>(std::ceil(before.time() / model().scene.solver.dt - 1e-6));
  parts_->place(steps, x, v);
}

std::string Simulation::report(const std::string& status, const std::vector<std::string>& notes) const {
  return report_json(status, notes, parts_->model, *parts_->solver, parts_->threads, parts_->times, ".");
}

const Model& Simulation::model() const { return parts_->model; }
const Solver& Simulation::solver() const { return *parts_->solver; }
const RunTimes& Simulation::times() const { return parts_->times; }

}  // namespace malha
