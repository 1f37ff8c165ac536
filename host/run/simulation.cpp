// SPDX-License-Identifier: Apache-2.0
#include "malha/simulation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory_resource>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include "host/attachments/object_motion.h"
#include "host/attachments/pose.h"
#include "host/base/adaptive_thread_count.h"
#include "host/base/array.h"
#include "host/base/caller_threads.h"
#include "host/base/hash.h"
#include "host/base/scoped_value.h"
#include "host/base/spelling_suggestion.h"
#include "host/base/start_threads.h"
#include "host/environment/edge_crossings.h"
#include "host/environment/initial_overlap.h"
#include "host/environment/layout_map.h"
#include "host/environment/solid_crossings.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "host/model/machine.h"
#include "host/model/memory_estimate.h"
#include "host/model/tear.h"
#include "host/report/expect.h"
#include "host/report/report.h"
#include "host/run/checkpoint.h"
#include "host/solver/solver.h"
#include "host/solver/state.h"
#include "kernels/parallel/compute.h"
#include "malha/text.h"

namespace malha {

namespace {

/// Refuses another number of rows than `count`, and numbers whose squares overflow in single precision.
void require_numbers(const char* what, const std::vector<Vec3>& rows, std::size_t count, const char* each) {
  if (rows.size() != count) refuse(what, "", counted(rows.size(), "row"), std::to_string(count) + ", " + each);
  int wrong = 0;  // without a branch, so that the loop is vectorised
  for (const Vec3& row : rows)
    wrong |= !(std::abs(row[0]) <= 1e18) | !(std::abs(row[1]) <= 1e18) | !(std::abs(row[2]) <= 1e18);
  for (std::size_t i = 0; wrong != 0 && i < rows.size(); ++i)
    for (const double number : rows[i])
      if (!(std::abs(number) <= 1e18)) refuse(what, "row " + std::to_string(i), shown(number), "numbers up to 1e18");
}

void require_stride(std::size_t stride) {
  if (stride < 3) refuse("copy", "stride", std::to_string(stride), "3 numbers a particle, or more");
}

/// Returns the number in `now` of a particle of `then`, which tore into it: new particles come last in their bodies. A
/// number that is none of its particles stays.
int after_tears(int particle, const RenderMesh& then, const RenderMesh& now) {
  for (std::size_t body = 0; body + 1 < then.body_begin.size(); ++body)
    if (particle >= then.body_begin[body] && particle < then.body_begin[body + 1])
      return particle + now.body_begin[body] - then.body_begin[body];
  return particle;
}

}  // namespace

Backend backend_named(const std::string& name) {
  const auto found = std::find(kBackends.begin(), kBackends.end(), name);
  if (found == kBackends.end())
    refuse("simulation", "backend", malha::quoted(name), "\"openmp\", \"serial\", \"cuda\"");
  return static_cast<Backend>(found - kBackends.begin());
}

struct Simulation::Parts {
  /// All that an edit replaces.
  struct Layout {
    Model model;  // referenced by the solver
    std::vector<Split> splits;
    std::unique_ptr<Solver> solver;

    /// Sets the state. Pins get velocity 0, or that of their keyframes, which every step sets again, because substeps
    /// of separate passes would move them with any other velocity.
    void set_state(std::int64_t steps, const std::vector<Vec3>& x, std::vector<Vec3> v) const {
      const double time = static_cast<double>(steps) * model.scene.solver.dt;
      const std::vector<bool> pinned = pinned_now(model, time), driven = has_keyframes(model);
      const std::vector<Vec3> now = solver->velocities();
      for (std::size_t i = 0; i < v.size(); ++i)
        if (pinned[i]) v[i] = driven[i] ? now[i] : Vec3{0, 0, 0};
      solver->set_state(steps, x, v);
    }
  };
  /// A change of the model: what it becomes, the splits in it, and how the new solver gets its state.
  struct Edit {
    Model model;
    std::vector<Split> splits;
    std::function<void(const Layout& next)> set_state;
  };

  std::unique_ptr<Layout> layout;
  SimulationOptions options;
  std::optional<CallerThreads> caller;  // of options.parallel_for
  RunTimes times;
  int threads = 1;
  std::optional<AdaptiveThreadCount> choice;      // none: always all threads
  std::optional<std::uint64_t> scene;             // hash of the scene at the start, computed when it is first needed
  std::optional<std::vector<int>> pins_at_start;  // set once pins were changed, because layouts depend on them
  RenderMesh untorn;                              // the mesh before the first tear, of a scene that tears
  bool tears_due = false;                         // the last step overstretched edges, which have not torn yet
  std::vector<Vec3> normals, places;              // of copy_normals()

  OpenMP host() const { return {threads, widest_instructions(), caller ? &*caller : nullptr}; }
  Model& model() const { return layout->model; }
  /// Access to the solver for one expression, in which arrays come from the program's memory.
  struct Access {
    ScopedValue<std::pmr::memory_resource*> memory;
    Solver& solver;
    Solver* operator->() const { return &solver; }
  };
  Access solver() const { return {{array_resource, options.memory}, *layout->solver}; }
  const std::vector<Split>& splits() const { return layout->splits; }

  /// Returns the hash of the model before any edit.
  std::uint64_t hash_of_scene() {
    if (!scene) scene = scene_hash(model());
    return *scene;
  }
  /// Returns the hash that identifies checkpoints with the present pins. Checkpoints do not contain gravity and wind;
  /// those of the start count.
  std::uint64_t hash_of_scene_and_pins() {
    if (!pins_at_start) return hash_of_scene();
    const std::vector<int> now = static_pins(model());
    return now == *pins_at_start ? hash_of_scene() : hash_bytes(now.data(), now.size() * sizeof(int), hash_of_scene());
  }

  /// The number of the environment object of this name. `call`: that asks for it, for messages.
  std::size_t index_of(const std::string& name, const char* call) const {
    std::vector<std::string> names;
    for (const EnvironmentMesh& object : model().environment) {
      if (object.spec.name == name) return names.size();
      names.push_back(object.spec.name);
    }
    refuse(call, "", "unknown environment object '" + name + "'" + did_you_mean(name, names),
           names.empty() ? "one of the scene's environment, which has none" : join(names));
  }

  /// Tells whether the layout relies on the rest of an object: what is attached to it is pinned, and the edges of
  /// objects at rest are searched together.
  bool rests_in_layout(std::size_t index) const {
    const EnvironmentSpec& object = model().scene.environment[index];
    if (moves(model().environment[index])) return false;
    const auto is_attached = [&object](const BodySpec& body) {
      return std::ranges::any_of(body.attachments,
                                 [&object](const Attachment& one) { return one.environment == object.name; });
    };
    const auto rests_with_edges = [](const EnvironmentSpec& one) {
      return one.edges && one.motion.empty() && !one.animation;
    };
    return std::ranges::any_of(model().scene.bodies, is_attached) ||
           (object.edges && std::ranges::count_if(model().scene.environment, rests_with_edges) > 1);
  }
  /// Sets the motion of an object, and of what is attached to it.
  void set_motion(std::size_t index, const std::vector<Keyframe>& motion) const {
    EnvironmentSpec& object = model().scene.environment[index];
    object.motion = model().environment[index].spec.motion = motion;
    const auto set = [&](auto& all) {
      for (auto& one : all)
        if (one.target.environment == object.name) one.target.motion = motion;
    };
    set(model().moved), set(model().attached);
  }
  /// Rebuilds for the first motion of an object on whose rest the layout relies.
  void lay_out_with_motion(std::size_t index, const std::vector<Keyframe>& motion) {
    Scene moving = model().scene;
    moving.environment[index].motion = motion;
    Model made = splits().empty() ? read_model(moving) : torn_model(moving, splits());
    made.environment[index].spec.motion = motion;
    rebuild_with_same_particles(std::move(made));
  }

  /// Reads the meshes of a scene, and lays them out as they start.
  Model read_model(const Scene& of) const {
    show("reading meshes, listing and ordering constraints");
    Model made = build_model(of, host(), machine_named(options.machine).patch_bounds(of.solver.precision));
    note_solid_crossings(made);
    start_outside(made), note_starts_behind(made);
    refuse_edge_crossings(made);
    show(of.environment.empty() ? "colouring and laying out" : "colouring and laying out, building trees");
    return made;
  }
  /// Lays out the meshes before the first tear after these splits.
  Model torn_model(const Scene& of, const std::vector<Split>& all) const {
    const Model& now = model();
    return build_torn_model(of, {&untorn, &all, &now.environment, now.zero_area_faces, &now.notes}, host(),
                            now.patches.bounds);
  }
  void show(const char* what) const {
    if (options.progress) options.progress(what, -1);
  }

  std::unique_ptr<Layout> make_layout(Model model, std::vector<Split> splits) const {
    const ScopedValue<std::pmr::memory_resource*> memory(array_resource, options.memory);
    auto made = std::make_unique<Layout>(Layout{std::move(model), std::move(splits), nullptr});
    made->model.interactive = options.interactive || !options.constraints.empty();  // which act outside patch solves
    made->solver = options.backend == Backend::Cuda
                       ? make_solver_on_cuda(made->model, threads, options.progress, options.timed_passes)
                       : make_solver(made->model, host(), options.instructions, options.progress);
    std::vector<UserConstraint> all = options.constraints;
    for (UserConstraint& one : all)
      for (int& particle : one.particles) particle = after_tears(particle, untorn, made->model.render_mesh);
    if (!all.empty()) made->solver->add_user_constraints(all);
    if (const std::vector<Vec3> before = layout ? layout->solver->forces() : std::vector<Vec3>{}; !before.empty()) {
      std::vector<Vec3> forces(made->model.x.size(), Vec3{0, 0, 0});
      const auto copy = [&](int to, int from, int count) {
        std::copy_n(before.begin() + from, count, forces.begin() + to);
      };
      for_common_bodies(made->model, layout->model, copy, made->splits.size() != layout->splits.size());
      made->solver->set_forces(forces);
    }
    release_setup_memory(made->model);
    return made;
  }
  void swap_in(std::unique_ptr<Layout> next) noexcept {
    times.layouts += layout && layout->splits.size() != next->splits.size();
    layout = std::move(next);
    times.splits = static_cast<int>(splits().size());
    times.strains.every = solver()->steps_to_sample();
    times.strains.runs.reserve(solver()->lengths().size());
  }

  /// Calls work(first now, first then, count) for the particles of each body that both models have, by the user's
  /// numbers: those of the same name and number of particles, and, if `torn`, of bodies that tore.
  template <class Work>
  static void for_common_bodies(const Model& now, const Model& then, const Work& work, bool torn = false) {
    const RenderMesh &a = now.render_mesh, &b = then.render_mesh;
    for (std::size_t i = 0; i < now.scene.bodies.size(); ++i)
      for (std::size_t k = 0; k < then.scene.bodies.size(); ++k) {
        const int count = a.body_begin[i + 1] - a.body_begin[i], before = b.body_begin[k + 1] - b.body_begin[k];
        if (now.scene.bodies[i].name != then.scene.bodies[k].name) continue;
        if (count == before || torn) work(a.body_begin[i], b.body_begin[k], std::min(count, before));
      }
  }
  /// Tells whether a model, not yet laid out, is that of the present layout in all that steps depend on.
  bool is_present(const Model& made) const { return made.w == model().w && scene_hash(made) == scene_hash(model()); }
  /// The map from the layout of one scene to the model of another one, at the time of the former.
  static LayoutMap map_from(const Layout& before, const Model& next) {
    std::vector<int> user(next.x.size(), LayoutMap::kNew);
    for_common_bodies(next, before.model, [&](int first, int then, int count) {
      std::iota(user.begin() + first, user.begin() + first + count, then);
    });
    return map_of_scenes(before.model, next, user, before.solver->time());
  }
  /// Gives a layout the state of another one, as the map says. A scene that sleeps wakes, and must be at rest anew.
  static void continue_from(const Layout& before, const LayoutMap& map, const Layout& to) {
    State<double> state = before.solver->whole_state();
    state.rest.clear();
    state.steps = static_cast<std::int64_t>(std::ceil(before.solver->time() / to.model.scene.solver.dt - 1e-6));
    to.solver->continue_from(state, map, before.solver->pass_seconds());
  }
  /// Refuses bodies and objects that are in each other where they are now: contacts would throw them apart.
  static void refuse_new_penetrations(const Layout& before, const Layout& now) {
    if (now.model.environment.empty()) return;
    double thickness = 0;
    for (const EnvironmentSpec& object : now.model.scene.environment) thickness = std::max(thickness, object.thickness);
    const double depth = now.solver->measure().penetration_max;
    if (depth > thickness && depth > before.solver->measure().penetration_max)
      refuse("set_scene", "", "a body that is " + shown(depth) + " m deep inside an object",
             "objects and bodies that are apart where they are now; set_pose() moves an object, and what lies on it");
  }
  /// The same of bodies that go through others, and through edges of objects.
  static void refuse_new_crossings(const Layout& before, const Layout& now) {
    const auto& self = now.model.scene.self_collision;
    if ((!self && !names_edges(now.model.scene)) || (self && self->ignores_crossings)) return;
    const std::int64_t found = now.solver->crossings();
    if (found > before.solver->crossings())
      refuse("set_scene", "", counted(found, "crossing") + " of edges with triangles",
             "bodies and objects that do not go through others where these are now");
  }
  /// Takes the particles of a layout that the user has taken in another one.
  static void take_over_handles(const Layout& to, const Layout& from) {
    const std::vector<int> pins = static_pins(to.model);
    for (const ParticleHandle& one : from.solver->taken())
      for_common_bodies(to.model, from.model, [&](int first, int then, int count) {
        if (one.particle < then || one.particle >= then + count) return;
        ParticleHandle moved = one;
        moved.particle += first - then;
        if (!std::ranges::binary_search(pins, moved.particle)) to.solver->take(moved);
      });
  }
  /// Copies the normals of all particles, in single or double precision.
  template <class Number>
  void copy_normals(Number* to, std::size_t stride) {
    const RenderMesh& mesh = model().render_mesh;
    normals.assign(model().x.size(), Vec3{0, 0, 0}), places.resize(normals.size());
    solver()->copy_positions(places.data()->data(), 3);
    for (const Quad& face : mesh.faces)
      for (int k = 1; k + 1 < (face[3] < 0 ? 3 : 4); ++k) {
        const Vec3& a = places[face[0]];
        const Vec3 normal = cross(minus(places[face[k]], a), minus(places[face[k + 1]], a));
        for (const int corner : {face[0], face[k], face[k + 1]})
          for (int axis = 0; axis < 3; ++axis) normals[corner][axis] += normal[axis];
      }
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const double length = norm(normals[i]);
      for (int axis = 0; axis < 3; ++axis)
        to[i * stride + axis] = static_cast<Number>(length > 0 ? normals[i][axis] / length : 0);
    }
  }

  /// Carries out an edit: what can throw comes before the swap, and changes nothing here.
  void rebuild(Edit edit) {
    hash_of_scene();
    const ScopedValue<std::pmr::memory_resource*> memory(array_resource, options.memory);
    std::unique_ptr<Layout> next = make_layout(std::move(edit.model), std::move(edit.splits));
    edit.set_state(*next);
    swap_in(std::move(next));
  }
  /// Rebuilds with a model of the same particles. They keep their state, and those that are not pinned their handles.
  void rebuild_with_same_particles(Model made) {
    for (std::size_t e = 0; e < made.environment.size(); ++e) made.environment[e].set = model().environment[e].set;
    rebuild({std::move(made), splits(), [this](const Layout& next) {
               next.set_state(solver()->steps(), solver()->positions(), solver()->velocities());
               const std::vector<int> pins = static_pins(next.model);
               for (const ParticleHandle& one : solver()->taken())
                 if (!std::binary_search(pins.begin(), pins.end(), one.particle)) next.solver->take(one);
             }});
  }

  /// Takes a step with user constraints; if one throws, the state before is restored.
  void step_or_restore(const SubstepCallback& after) {
    const std::string before = solver()->save();
    const std::vector<ParticleHandle> taken = solver()->taken();
    try {
      solver()->step(after);
    } catch (const Diverged&) {
      throw;
    } catch (...) {
      solver()->restore(before);
      for (const ParticleHandle& one : taken) solver()->take(one);
      throw;
    }
  }
  /// Sets positions and velocities; handles stay.
  void set_state(const std::vector<Vec3>& x, const std::vector<Vec3>& v) {
    const ScopedValue<std::pmr::memory_resource*> memory(array_resource, options.memory);
    const std::vector<ParticleHandle> taken = solver()->taken();
    layout->set_state(solver()->steps(), x, v);
    for (const ParticleHandle& one : taken) solver()->take(one);
  }

  /// Refuses a state with positions or velocities that are not finite.
  void require_finite(const char* what) const {
    for (const auto& rows : {solver()->positions(), solver()->velocities()})
      for (std::size_t i = 0; i < rows.size(); ++i)
        if (!finite(rows[i]))
          refuse(what, "", particle_name(model(), static_cast<int>(i)) + ", whose position or velocity is not finite",
                 "a finite state");
  }

  void tear_if_due() {
    if (tears_due) split(find_tears(model(), solver()->positions(), pinned()));
    tears_due = false;
  }
  std::vector<bool> pinned() const {
    std::vector<int> held;
    for (const ParticleHandle& one : solver()->taken())
      if (one.is_held()) held.push_back(one.particle);
    return pinned_now(model(), solver()->time(), held);
  }
  void split(const std::vector<Split>& found) {
    if (found.empty()) return;
    times.layout_seconds += seconds([&] {
      std::vector<Split> all = splits();
      all.insert(all.end(), found.begin(), found.end());
      rebuild({torn_model(model().scene, all), all, [this](const Layout& next) {
                 std::vector<int> from = ancestors(model(), next.model, next.splits, splits().size());
                 next.solver->continue_from(solver()->whole_state(), map_of_particles(next.model, std::move(from)),
                                            solver()->pass_seconds());
                 for (ParticleHandle one : solver()->taken()) {
                   one.particle = after_tears(one.particle, model().render_mesh, next.model.render_mesh);
                   next.solver->take(one);
                 }
               }});
    });
  }

  /// Returns all that the next step depends on: the tears of a scene that can tear, and the solver's state.
  std::string save() const {
    if (!can_tear(model().scene)) return solver()->save();
    const std::vector<int> numbers = encode_splits(splits());
    const std::uint64_t count = numbers.size();
    std::string bytes(reinterpret_cast<const char*>(&count), sizeof count);
    if (count > 0) bytes.append(reinterpret_cast<const char*>(numbers.data()), count * sizeof(int));
    return bytes + solver()->save();
  }
  /// Restores a state. `file`: named in refusals.
  void restore(const std::string& bytes, const std::string& file) {
    if (!can_tear(model().scene)) return solver()->restore(bytes, file);
    std::uint64_t count = 0;
    if (bytes.size() < sizeof count) refuse(file, "state", counted(bytes.size(), "byte"), "a number of tears at least");
    std::memcpy(&count, bytes.data(), sizeof count);
    const std::size_t most = (bytes.size() - sizeof count) / sizeof(int);
    if (count > most) refuse(file, "tears", counted(count, "number"), "at most the " + std::to_string(most) + " there");
    std::vector<int> numbers(count);
    if (count > 0) std::memcpy(numbers.data(), bytes.data() + sizeof count, count * sizeof(int));
    const std::string state = bytes.substr(sizeof count + count * sizeof(int));
    if (numbers == encode_splits(splits())) {
      solver()->restore(state, file);
    } else {
      const std::vector<Split> all = decode_splits(numbers, model().scene, untorn, file);
      rebuild({torn_model(model().scene, all), all, [&](const Layout& next) { next.solver->restore(state, file); }});
    }
    tears_due = false;
  }
};

Simulation::Simulation(const Scene& scene, const SimulationOptions& options) : parts_(std::make_unique<Parts>()) {
  const bool serial = options.backend == Backend::Serial, on_device = options.backend == Backend::Cuda;
  parts_->options = options;
  if (options.memory != nullptr && on_device)
    refuse("simulation", "memory", "the backend \"cuda\" beside it",
           "memory of the host, for \"openmp\" and \"serial\"");
  if (on_device) require_cuda();
  if (options.parallel_for) {
    if (options.adaptive_threads || options.backend != Backend::OpenMP)
      refuse("simulation", "parallel_for",
             options.adaptive_threads ? "adaptive_threads beside it" : "another backend than OpenMP beside it",
             "threads of the program, or one of these");
    parts_->caller = caller_threads(parts_->options.parallel_for);
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    parts_->threads = options.threads > 0 ? options.threads : std::max(1, cores);
  } else {
    if (!kHasOpenMP && options.threads > 1)
      refuse("simulation", "threads", std::to_string(options.threads) + " in a build without OpenMP",
             "1, or parallel_for with threads of the program");
    parts_->threads = serial ? 1 : options.threads > 0 ? options.threads : available_threads();
    require_threads(parts_->threads);
    if ((options.threads <= 0 || options.adaptive_threads) && !on_device) parts_->choice.emplace(parts_->threads);
  }
  Model model;
  parts_->times.model_seconds = seconds([&] { model = parts_->read_model(scene); });
  parts_->times.solver_seconds = seconds([&] { parts_->swap_in(parts_->make_layout(std::move(model), {})); });
  if (can_tear(scene)) parts_->untorn = parts_->model().render_mesh;
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
    parts_->options.constraints.empty() ? parts_->solver()->step(after) : parts_->step_or_restore(after);
  };
  parts_->times.steps.add(seconds([&] {
    parts_->tear_if_due();
    parts_->choice ? parts_->choice->take(step) : step();
    parts_->tears_due = parts_->solver()->overstretched();
    parts_->tear_if_due();
    LargestStrains& strains = parts_->times.strains;
    if (strains.every > 0 && steps() % strains.every == 0) strains.take(parts_->solver()->strains(), steps());
  }));
  if (trace) parts_->times.launches = trace->list();
}

void Simulation::check_divergence() { parts_->solver()->check_divergence(); }

void Simulation::move_pin(int particle, const Vec3& to) { parts_->solver()->move_pins({particle}, {to}); }
void Simulation::move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to) {
  require_numbers("positions of pins", to, particles.size(), "one a pin");
  parts_->solver()->move_pins(particles, to);
}

void Simulation::set_positions(const std::vector<Vec3>& x) {
  require_numbers("positions", x, parts_->model().x.size(), "one a particle");
  std::vector<Vec3> v = velocities();
  for (Vec3& one : v)
    if (!finite(one)) one = {0, 0, 0};
  parts_->set_state(x, v);
}
void Simulation::set_velocities(const std::vector<Vec3>& v) {
  require_numbers("velocities", v, parts_->model().x.size(), "one a particle");
  const std::vector<Vec3> x = positions();
  if (!std::all_of(x.begin(), x.end(), finite))
    refuse("velocities", "", "positions that are not finite", "to set positions first");
  parts_->set_state(x, v);
}

void Simulation::set_forces(const std::vector<Vec3>& forces) {
  if (!forces.empty()) require_numbers("forces", forces, parts_->model().x.size(), "one a particle");
  parts_->solver()->set_forces(forces);
}

void Simulation::set_scene(const Scene& scene) {
  if (!parts_->splits().empty())
    refuse("set_scene", "", "a scene that has torn", "to set it before a vertex is torn or cut in two");
  const Parts::Layout& before = *parts_->layout;
  Model next = parts_->read_model(scene);
  if (!parts_->options.constraints.empty() && next.render_mesh.body_begin != before.model.render_mesh.body_begin)
    refuse("set_scene", "", "other bodies, or other numbers of particles",
           "the same ones, to which the constraints of the caller refer");
  for (EnvironmentMesh& object : next.environment)
    for (const EnvironmentMesh& then : before.model.environment)
      if (object.spec.name == then.spec.name && object.mesh.points.size() == then.mesh.points.size())
        object.set = then.set;
  if (parts_->is_present(next)) {
    Scene& now = parts_->model().scene;
    now.name = scene.name, now.duration = scene.duration, now.outputs = scene.outputs, now.expect = scene.expect;
    return;
  }
  const LayoutMap map = Parts::map_from(before, next);
  parts_->rebuild({std::move(next), {}, [&before, &map](const Parts::Layout& to) {
                     Parts::continue_from(before, map, to);
                     Parts::refuse_new_penetrations(before, to), Parts::refuse_new_crossings(before, to);
                     Parts::take_over_handles(to, before);
                   }});
  const Model& now = parts_->model();
  parts_->scene.reset(), parts_->pins_at_start.reset();
  parts_->times.strains = {}, parts_->times.strains.every = parts_->solver()->steps_to_sample();
  parts_->times.strains.runs.reserve(parts_->solver()->lengths().size());
  parts_->untorn = can_tear(now.scene) ? now.render_mesh : RenderMesh{};
}
const Scene& Simulation::scene() const { return parts_->model().scene; }

void Simulation::set_gravity(const Vec3& gravity) {
  require_numbers("gravity", {gravity}, 1, "one");
  if (gravity == parts_->model().scene.gravity) return;
  parts_->hash_of_scene();
  if (parts_->solver()->has_levels()) {  // whose lengths depend on gravity
    Scene scene = parts_->model().scene;
    scene.gravity = gravity;
    const bool torn = !parts_->splits().empty();
    return parts_->rebuild_with_same_particles(torn ? parts_->torn_model(scene, parts_->splits())
                                                    : parts_->read_model(scene));
  }
  parts_->model().scene.gravity = gravity;
  parts_->solver()->change_gravity();
}
void Simulation::set_wind(const Vec3& velocity) {
  require_numbers("wind", {velocity}, 1, "one");
  Scene& scene = parts_->model().scene;
  if (!scene.wind) refuse("set_wind", "", "a scene without wind", "one that names it: air is laid out at the start");
  if (velocity == scene.wind->velocity) return;
  parts_->hash_of_scene();
  scene.wind->velocity = velocity;
  parts_->solver()->change_wind();
}

void Simulation::set_pose(const std::string& object, const RigidPose& pose) {
  require_numbers("set_pose", {pose.translate, pose.axis, {pose.degrees, 0, 0}}, 3, "one pose");
  if (!(norm(pose.axis) > 0)) refuse("set_pose", "", "an axis of length zero", "a direction");
  const std::size_t index = parts_->index_of(object, "set_pose");
  const bool needs_layout = parts_->rests_in_layout(index);
  const NextMotion next = parts_->solver()->next_motion();
  if (needs_layout && next.in_step)
    refuse("set_pose", "", "the first motion of '" + object + "' in a callback",
           "a first call between two steps, because bodies are attached to it, or others with \"edges\" rest with it");
  parts_->hash_of_scene();
  const std::vector<Keyframe>& before = parts_->model().environment[index].spec.motion;
  const bool at_end = !before.empty() && next.start >= before.back().time;
  Keyframe from = at_end ? before.back() : keyframe_at(before, next.start);
  from.time = next.start;
  Keyframe to{next.end, pose.translate, pose.axis, pose.degrees};
  // About one axis the number of turns counts: the nearest one is the shortest way.
  to.degrees += 360 * std::round((from.degrees - pose.degrees) / 360);
  std::vector<Keyframe> motion{from, to};
  // What is attached to the object has its place by the pose at the start.
  if (next.start > 0) motion.insert(motion.begin(), keyframe_at(before, 0));
  if (needs_layout) return parts_->lay_out_with_motion(index, motion);
  parts_->set_motion(index, motion);
  parts_->solver()->change_environment();
}
void Simulation::set_vertices(const std::string& object, const std::vector<Vec3>& positions) {
  EnvironmentMesh& moved = parts_->model().environment[parts_->index_of(object, "set_vertices")];
  if (!moved.spec.animation || !moved.spec.animation->from_code)
    refuse("set_vertices", "", "the object '" + object + "', whose vertices the scene moves",
           "one with \"animation\": \"from_code\"");
  const std::vector<int> point = points_of_vertices(moved.mesh.vertices, static_cast<int>(moved.mesh.points.size()));
  require_numbers("set_vertices", positions, point.size(), "one a vertex of the object");
  const NextMotion motion = parts_->solver()->next_motion();
  SetVertices next{points_in_frame(moved, motion.start), moved.mesh.points, motion.start, motion.end};
  for (std::size_t v = 0; v < point.size(); ++v)
    if (point[v] >= 0) next.to[static_cast<std::size_t>(point[v])] = positions[v];
  moved.set = std::move(next);
  parts_->solver()->change_environment();
}

std::vector<int> Simulation::pins() const { return static_pins(parts_->model()); }
void Simulation::set_pins(std::vector<int> particles) {
  std::sort(particles.begin(), particles.end());
  particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
  const std::vector<int> before = pins();
  if (particles == before) return;
  if (!parts_->splits().empty())
    refuse("pins", "", "a scene that has torn", "to set them before a vertex is torn or cut in two");
  Model next = parts_->read_model(with_pins(parts_->model(), particles));
  if (static_pins(next) != particles)
    refuse("pins", "", "a particle left out that a rigid attachment holds", "all those that attachments hold");
  parts_->rebuild_with_same_particles(std::move(next));
  if (!parts_->pins_at_start) parts_->pins_at_start = before;
}

void Simulation::pull(int particle, const Vec3& to, double compliance) {
  if (compliance == 0)  // compliance 0 would hold the particle
    throw InputError("pull: found compliance 0; allowed: 1e-12 to 1e12 m/N");
  parts_->solver()->take({particle, to, compliance});
}
void Simulation::hold(int particle) {
  const std::vector<Vec3> x = positions();
  const bool there = particle >= 0 && static_cast<std::size_t>(particle) < x.size();
  hold(particle, there ? x[particle] : Vec3{});
}
void Simulation::hold(int particle, const Vec3& to) { parts_->solver()->take({particle, to}); }
void Simulation::release(int particle) { parts_->solver()->release(particle); }
std::vector<ParticleHandle> Simulation::handles() const { return parts_->solver()->taken(); }

int Simulation::cut(const std::vector<Edge>& edges) {
  const std::vector<Split> found = find_cuts(parts_->model(), edges, parts_->pinned());
  parts_->split(found);
  if (!found.empty()) parts_->solver()->wake();
  return static_cast<int>(found.size());
}

std::string Simulation::save_state() const {
  return with_state_header(parts_->save(), parts_->hash_of_scene_and_pins());
}
void Simulation::restore_state(const std::string& state) {
  parts_->restore(without_state_header(state, parts_->hash_of_scene_and_pins()), "state");
}

void Simulation::wake() { parts_->solver()->wake(); }

double Simulation::time() const { return parts_->solver()->time(); }
std::int64_t Simulation::steps() const { return parts_->solver()->steps(); }
int Simulation::threads() const { return parts_->threads; }
int Simulation::tears() const { return parts_->times.splits; }
std::vector<Vec3> Simulation::positions() const { return parts_->solver()->positions(); }
std::vector<Vec3> Simulation::velocities() const { return parts_->solver()->velocities(); }
void Simulation::copy_positions(float* to, std::size_t stride) const {
  require_stride(stride), parts_->solver()->copy_positions(to, stride);
}
void Simulation::copy_positions(double* to, std::size_t stride) const {
  require_stride(stride), parts_->solver()->copy_positions(to, stride);
}
void Simulation::copy_velocities(float* to, std::size_t stride) const {
  require_stride(stride), parts_->solver()->copy_velocities(to, stride);
}
void Simulation::copy_velocities(double* to, std::size_t stride) const {
  require_stride(stride), parts_->solver()->copy_velocities(to, stride);
}
void Simulation::copy_normals(float* to, std::size_t stride) const {
  require_stride(stride), parts_->copy_normals(to, stride);
}
void Simulation::copy_normals(double* to, std::size_t stride) const {
  require_stride(stride), parts_->copy_normals(to, stride);
}
std::vector<double> Simulation::inverse_masses() const { return parts_->solver()->inverse_masses(); }
std::vector<double> Simulation::constraint_values(std::size_t index) const {
  return parts_->solver()->values_of_user_constraint(index);
}
std::vector<int> Simulation::particles_of_vertices(std::size_t body) const {
  return malha::particles_of_vertices(parts_->model().render_mesh, body);
}
Measures Simulation::measure() const { return parts_->solver()->measure(); }
void Simulation::count_crossings() {
  const Scene& scene = parts_->model().scene;
  if (!scene.self_collision && !names_edges(scene)) return;
  RunTimes& times = parts_->times;
  times.most_crossings = std::max(times.most_crossings, parts_->solver()->crossings()), ++times.crossings_counted;
}
std::uint64_t Simulation::state_hash() const { return parts_->solver()->state_hash(); }

std::vector<std::string> Simulation::failed_expectations() const {
  const Model& model = parts_->model();
  std::vector<ParticlesOfBody> bodies;
  for (std::size_t b = 0; b < model.scene.bodies.size(); ++b)
    bodies.push_back({model.scene.bodies[b].name, static_cast<std::size_t>(model.render_mesh.body_begin[b]),
                      static_cast<std::size_t>(model.render_mesh.body_begin[b + 1]), model.render_mesh.vertices[b]});
  Measures measures = measure();
  measures.crossings = std::max(measures.crossings, parts_->times.most_crossings);
  return unmet_expectations(model.scene.expect, measures, positions(), bodies);
}

void Simulation::save_checkpoint(const std::string& path, std::int64_t frames) const {
  parts_->require_finite("checkpoint");
  write_checkpoint(path, parts_->hash_of_scene_and_pins(),
                   {parts_->save(), frames, parts_->times.most_crossings, parts_->times.crossings_counted});
}

std::int64_t Simulation::load_checkpoint(const std::string& path) {
  const Checkpoint checkpoint = read_checkpoint(path, parts_->hash_of_scene_and_pins());
  parts_->restore(checkpoint.state, path);
  parts_->times.most_crossings = checkpoint.crossings, parts_->times.crossings_counted = checkpoint.counted;
  return checkpoint.frames;
}

void Simulation::transfer_state_from(const Simulation& before) {
  const auto set_state = [&](const Parts::Layout& to) {
    const Parts::Layout& from = *before.parts_->layout;
    Parts::continue_from(from, Parts::map_from(from, to.model), to);
  };
  const ScopedValue<std::pmr::memory_resource*> memory(array_resource, parts_->options.memory);
  const std::vector<Split>& splits = before.parts_->splits();
  if (splits.empty() || !can_tear(model().scene)) return set_state(*parts_->layout);
  parts_->rebuild({parts_->torn_model(model().scene, splits), splits, set_state});
}

std::string Simulation::report(const std::string& status, const std::vector<std::string>& notes) const {
  return report_json(status, notes, parts_->model(), solver(), parts_->threads, parts_->times, ".");
}

const Model& Simulation::model() const { return parts_->model(); }
const Solver& Simulation::solver() const { return *parts_->layout->solver; }
const RunTimes& Simulation::times() const { return parts_->times; }

}  // namespace malha
