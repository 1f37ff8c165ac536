// SPDX-License-Identifier: Apache-2.0
#include "host/model/model.h"

#include <algorithm>
#include <map>

#include "host/base/build_info.h"
#include "host/base/stopwatch.h"
#include "host/mesh/bounding_box.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "host/model/body.h"
#include "host/model/build_constraints.h"
#include "host/model/memory_estimate.h"
#include "host/model/ordering/index_map.h"
#include "host/model/ordering/order.h"
#include "host/model/seams.h"
#include "host/model/self_surface.h"
#include "host/model/tear.h"
#include "host/model/unlikely.h"
#include "host/scene/check_scene.h"
#include "host/scene/error_list.h"
#include "kernels/constraints/constraint_registry.h"
#include "malha/error.h"

namespace malha {

namespace {

/// Reorders the particles (particle order[i] becomes i) and updates all indices of particles, except in the patches and
/// the lists of components, whose ranges of particles must stay the same.
void renumber(Model& model, const std::vector<int>& order) {
  const std::vector<int> now = solver_of(order);
  const auto reorder = [&](auto& values) { values = in_solver_order(values, order); };
  reorder(model.user_index), reorder(model.x), reorder(model.v), reorder(model.w), reorder(model.mass);
  for (std::vector<double>* factor : {&model.friction_factor, &model.thickness_factor})
    if (!factor->empty()) reorder(*factor);
  if (!model.rest_x.empty()) reorder(model.rest_x);
  const auto remap = [&](int& i) { i = now[i]; };
  for (ConstraintSet& set : model.sets) std::ranges::for_each(set.particles, remap);
  for (ConstraintSet& set : model.stencils) std::ranges::for_each(set.particles, remap);
  for (SpringSet& set : model.springs)
    for (Edge& e : set.ends) std::ranges::for_each(e, remap);
  for (auto& body : model.tetrahedra)
    for (Tetrahedron& t : body) std::ranges::for_each(t, remap);
  for (PressureSet& set : model.pressures) {
    for (Triangle& t : set.triangles) std::ranges::for_each(t, remap);
    std::ranges::for_each(set.particles, remap);
    std::ranges::sort(set.particles);
    for (Edge& e : set.followers) std::ranges::for_each(e, remap);
  }
  for (std::vector<int>* list : {&model.long_range.particle, &model.long_range.anchor, &model.air.particle})
    std::for_each(list->begin(), list->end(), remap);
  for (Quad& face : model.air.faces)
    for (int& corner : face)
      if (corner >= 0) remap(corner);
  for (MovedPins& pins : model.moved) std::ranges::for_each(pins.particles, remap);
  for (AttachmentSet& set : model.attached) std::ranges::for_each(set.particles, remap);
}

/// Throws InputError for an expectation about something that the scene does not have, since it would always be met.
/// `tetrahedra`: whether its meshes have any.
void check_expectations(const Scene& scene, bool tetrahedra) {
  const auto needs = [&scene](bool expected, bool present, const std::string& key, const std::string& what) {
    if (expected && !present)
      refuse(scene.file, "/expect/" + key, "an expectation about " + what, "one where there is any");
  };
  bool distance = false, pressure = false, inside = false;
  for (const BodySpec& body : scene.bodies)
    for (const ConstraintSpec& constraint : body.constraints) {
      distance = distance || constraint.type == Distance::name;
      pressure = pressure || constraint.type == "pressure";
    }
  for (const EnvironmentSpec& environment : scene.environment) inside = inside || environment.sides != Sides::TwoSided;
  const Expect& expect = scene.expect;
  needs(bool(expect.max_strain), distance, "max_strain", "strain in a scene without distance constraints");
  needs(bool(expect.rms_strain), distance, "rms_strain", "strain in a scene without distance constraints");
  needs(expect.volume_ratio.has_value(), pressure || tetrahedra, "volume_ratio",
        "volume in a scene without pressure and without tetrahedra");
  needs(bool(expect.max_seam_gap), !scene.seams.empty(), "max_seam_gap", "seams in a scene without any");
  needs(bool(expect.inverted_tetrahedra), tetrahedra, "inverted_tetrahedra", "tetrahedra in a scene without any");
  needs(bool(expect.max_crossings), scene.self_collision.has_value() || names_edges(scene), "max_crossings",
        "crossings in a scene without self_collision and without objects that name \"edges\"");
  needs(bool(expect.max_penetration), inside, "max_penetration",
        "penetration in a scene without solids or one-sided sheets");
}

/// Throws InputError for a scene that may tear with a format that stores a single mesh for all frames, and for outputs
/// that this build does not support.
void check_outputs(const Scene& scene) {
  const std::string key = "/outputs/frames/formats";
  for (const std::string& format : scene.outputs.formats) {
    if (can_tear(scene) && (format == "pc2" || format == "glb" || format == "usda"))
      refuse(scene.file, key, format + ", which holds one mesh for all frames, of a scene that tears", "vtp, ply, obj");
    if (format == "glb" && !has_gltf())
      refuse(scene.file, key, "glb, and this malha was built without tinygltf (Debian: libtinygltf-dev)",
             "vtp, pc2, ply, obj, usda");
  }
  if (scene.outputs.page && !has_pages())
    refuse(scene.file, "/outputs/page", "a page, and this malha was built with MALHA_PAGES=OFF",
           "no page (malha run --no-page)");
  if (scene.outputs.picture && !has_pictures())
    refuse(scene.file, "/outputs/pictures", "pictures, and this malha was built with MALHA_PICTURES=OFF",
           "no pictures (malha run --no-picture)");
}

class Builder {
 public:
  Builder(const Scene& scene, const OpenMP& threads, const PatchBounds& bounds, const TearState* torn = nullptr)
      : threads_(threads), bounds_(bounds), torn_(torn) {
    model_.scene = scene;
  }

  Model build() {
    const Scene& scene = model_.scene;
    if (!torn_) check_scene(scene);
    check_outputs(scene);
    if (scene.self_collision && can_tear(scene))
      refuse(scene.file, "/self_collision", "self_collision in a scene with a body that tears", "one of them");
    model_.render_mesh.body_begin = model_.render_mesh.face_begin = model_.render_mesh.line_begin = {0};
    ModelSeconds& took = model_.seconds;
    took.load = seconds([&] {
      ErrorList errors;
      for (std::size_t b = 0; b < scene.bodies.size(); ++b)
        errors.collect([&] { add_body(make_body(scene, b, meshes_of(b), torn_)); });
      if (torn_)
        model_.environment = *torn_->environment, model_.zero_area_faces = torn_->zero_area_faces;
      else
        for (std::size_t e = 0; e < scene.environment.size(); ++e)
          errors.collect([&] { model_.environment.push_back(load_environment(scene, e, model_.zero_area_faces)); });
      errors.throw_all();
      if (!torn_) place_exact_shapes();
    });
    if (!torn_) set_default_thickness();
    check_expectations(scene,
                       std::ranges::any_of(bodies_, [](const Body& body) { return !body.mesh.tetrahedra.empty(); }));
    joints_ = find_joints(scene, bodies_, model_.render_mesh.body_begin);
    took.order = seconds([this] { order_particles(); });
    took.build_constraints =
        seconds([this] { build_constraints(model_, bodies_, joints_, solver_of_, torn_ != nullptr); });
    if (corrects_momenta()) find_free_islands();
    took.patches = seconds([this] { cut(); });
    if (torn_)
      model_.notes = *torn_->notes;
    else
      for (std::string& line : unlikely_settings(model_, bodies_)) model_.notes.push_back(std::move(line));
    if (!torn_) note_unlikely_seams(model_);
    if (scene.self_collision) {
      const SelfSurface surface = self_surface(model_);
      check_pairs(model_, surface), check_crossings(model_, surface);
    }
    return std::move(model_);
  }

 private:
  void place_exact_shapes() {
    std::vector<Vec3> points;  // of the bodies
    for (EnvironmentMesh& object : model_.environment) {
      if (!is_exact(object.spec.shape)) continue;
      if (points.empty())
        for (const Body& body : bodies_) points.insert(points.end(), body.mesh.points.begin(), body.mesh.points.end());
      object.exact = place(object.spec.shape, object.spec.transform);
      object.mesh = drawing_of(object.spec.shape, object.spec.transform, points);
    }
  }

  void set_default_thickness() {
    const double thickness = model_.environment.empty() ? 0 : default_thickness(finest_edge(bodies_));
    for (std::size_t e = 0; e < model_.environment.size(); ++e) {
      EnvironmentSpec& object = model_.scene.environment[e];
      if (object.thickness == 0) object.thickness = model_.environment[e].spec.thickness = thickness;
    }
  }

  BodyMeshes meshes_of(std::size_t b) {
    if (!torn_) return load_body(model_.scene, b, model_.zero_area_faces, model_.notes);
    BodyMeshes meshes{body_mesh(*torn_->intact, b), {}};
    if (model_.scene.bodies[b].rest) meshes.rest = torn_->intact->rest[b];
    return meshes;
  }

  void add_body(Body body) {
    RenderMesh& render_mesh = model_.render_mesh;
    const int first = static_cast<int>(render_mesh.points.size());
    render_mesh.points.insert(render_mesh.points.end(), body.mesh.points.begin(), body.mesh.points.end());
    for (Quad face : body.mesh.faces) {
      for (int& corner : face)
        if (corner >= 0) corner += first;
      render_mesh.faces.push_back(face);
    }
    for (const Edge& line : body.mesh.lines) render_mesh.lines.push_back({line[0] + first, line[1] + first});
    render_mesh.body_begin.push_back(static_cast<int>(render_mesh.points.size()));
    render_mesh.face_begin.push_back(static_cast<int>(render_mesh.faces.size()));
    render_mesh.line_begin.push_back(static_cast<int>(render_mesh.lines.size()));
    render_mesh.vertices.push_back(body.mesh.vertices);
    if (body.rest) {
      render_mesh.rest.resize(bodies_.size());
      render_mesh.rest.push_back(*body.rest);
    }
    bodies_.push_back(std::move(body));
  }

  /// Computes the solver's order and fills the particles and the lists of components.
  void order_particles() {
    const RenderMesh& render_mesh = model_.render_mesh;
    const int n = static_cast<int>(render_mesh.points.size());
    std::vector<Edge> all;
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      for (const Edge& e : bodies_[b].edges)
        all.push_back({e[0] + render_mesh.body_begin[b], e[1] + render_mesh.body_begin[b]});
    const std::vector<Edge> sewn = edges_of(joints_);
    all.insert(all.end(), sewn.begin(), sewn.end());
    int count = 0;
    const std::vector<int> component = components(n, all, count);
    model_.user_index = solver_order(render_mesh.points, component, count, all);
    for (const int user : model_.user_index) component_.push_back(component[user]);
    solver_of_ = solver_of(model_.user_index);
    for (const Edge& e : all) edges_.push_back({solver_of_[e[0]], solver_of_[e[1]]});

    model_.x.resize(n), model_.v.resize(n), model_.w.resize(n), model_.mass.resize(n);
    for (std::size_t b = 0; b < bodies_.size(); ++b) fill_particles(b);
    if (!model_.render_mesh.rest.empty()) fill_places_at_rest();

    for (int i = 0, end; i < n; i = end) {
      for (end = i; end < n && component_[end] == component_[i];) ++end;
      const double damping = model_.scene.bodies[body_of(model_, model_.user_index[i])].damping;
      if (damping > 0 && end - i > 1) model_.damped.push_back({i, end - i, damping});
    }
  }

  /// True if the momenta of free bodies are restored after projections. Desbrun's filter conserves them, but not the
  /// projections after it.
  bool corrects_momenta() const {
    const SolverSpec& solver = model_.scene.solver;
    if (solver.type == "pbd") return solver.keeps_momenta;
    const bool projects = !model_.sets.empty() || !model_.pressures.empty();
    return projects && solver.desbrun.corrects() == Corrector::Inertia;
  }

  void find_free_islands() {
    const int n = static_cast<int>(component_.size());
    const std::vector<bool> fixed = fixed_at_start(model_, true);
    for (int i = 0, end; i < n; i = end) {
      bool free = true;
      for (end = i; end < n && component_[end] == component_[i]; ++end) free = free && !fixed[end];
      if (free && end - i > 1) model_.free.push_back({i, end - i});
    }
  }

  void fill_particles(std::size_t b) {
    const BodySpec& spec = model_.scene.bodies[b];
    const Body& body = bodies_[b];
    const std::vector<bool> pinned = body.boundary.at_start();
    Vec3 centre{0, 0, 0};
    double total = 0;
    for (std::size_t i = 0; i < body.mass.size(); ++i) {
      total += body.mass[i];
      for (int k = 0; k < 3; ++k) centre[k] += body.mass[i] * body.mesh.points[i][k];
    }
    for (double& number : centre) number /= total;
    for (std::size_t i = 0; i < body.mass.size(); ++i) {
      const int at = solver_of_[model_.render_mesh.body_begin[b] + i];
      const Vec3& x = body.mesh.points[i];
      const Vec3 turn = cross(spec.spin, minus(x, centre));
      model_.x[at] = x;
      model_.mass[at] = body.mass[i];
      model_.w[at] = body.boundary.pinned[i] ? 0 : 1 / body.mass[i];
      for (int k = 0; k < 3; ++k) model_.v[at][k] = pinned[i] ? 0 : spec.velocity[k] + turn[k];
    }
    fill_factors(b, body.friction_map, model_.friction_factor);
    fill_factors(b, body.thickness_map, model_.thickness_factor);
    add_boundary_conditions(b);
  }

  /// Factors are 1 for bodies without a map.
  void fill_factors(std::size_t b, const std::vector<double>& map, std::vector<double>& to) const {
    if (map.empty()) return;
    to.resize(model_.x.size(), 1);
    for (std::size_t i = 0; i < map.size(); ++i) to[solver_of_[model_.render_mesh.body_begin[b] + i]] = map[i];
  }

  /// Components of a body stand side by side in them, because a pattern may have its pieces over each other.
  void fill_places_at_rest() {
    model_.render_mesh.rest.resize(bodies_.size());
    const auto& self = model_.scene.self_collision;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const std::vector<Vec3>* const places = places_at_rest(model_.scene.bodies[b], bodies_[b]);
      if (!places) continue;
      if (model_.rest_x.empty()) model_.rest_x = model_.x;
      const int first = model_.render_mesh.body_begin[b];
      const auto [low, high] = bounds_of(*places);
      const double beside = high[0] - low[0] + (self ? 4 * self->thickness : 0);
      std::map<int, int> number;  // of each component
      for (std::size_t i = 0; i < places->size(); ++i) {
        const int at = solver_of_[first + i];
        const int component = number.try_emplace(component_[at], static_cast<int>(number.size())).first->second;
        model_.rest_x[at] = (*places)[i];
        model_.rest_x[at][0] += component * beside;
      }
    }
  }

  void add_boundary_conditions(std::size_t b) {
    const auto add = [&](auto sets, auto& all) {
      for (auto& set : sets) {
        for (int& i : set.particles) i = solver_of_[model_.render_mesh.body_begin[b] + i];
        all.push_back(std::move(set));
      }
    };
    add(bodies_[b].boundary.moved, model_.moved), add(bodies_[b].boundary.attached, model_.attached);
  }

  /// Cuts the particles into patches and reorders the model accordingly. The cuts depend on the constraints, which are
  /// listed in the first order; the reordering takes 2 to 4 % of the set-up of a million particles.
  void cut() {
    Cut cut = cut_into_patches(model_.sets, edges_, component_, threads_, bounds_);
    renumber(model_, cut.order);
    model_.patches = std::move(cut.patches);
  }

  OpenMP threads_;
  PatchBounds bounds_;
  const TearState* torn_;
  Model model_;
  std::vector<Body> bodies_;
  std::vector<int> solver_of_;
  std::vector<int> component_;  // component of each particle; the cut into patches does not change it
  std::vector<Joints> joints_;  // of the scene's seams
  std::vector<Edge> edges_;     // of all bodies and joints, in the order before the cut
};

}  // namespace

Model build_model(const Scene& scene, const OpenMP& threads, const PatchBounds& bounds) {
  require_memory(scene);
  return Builder(scene, threads, bounds).build();
}

Model build_torn_model(const Scene& scene, const TearState& torn, const OpenMP& threads, const PatchBounds& bounds) {
  return Builder(scene, threads, bounds, &torn).build();
}

int number_in_body(const Model& model, int user_index) {
  const int body = body_of(model, user_index);
  return vertex_of(model.render_mesh.vertices[body], user_index - model.render_mesh.body_begin[body]);
}

std::string particle_name(const Model& model, int user_index) {
  return "particle " + std::to_string(number_in_body(model, user_index)) + " of body '" +
         model.scene.bodies[body_of(model, user_index)].name + "'";
}

std::vector<int> particles_of_vertices(const RenderMesh& render_mesh, std::size_t body) {
  const FileVertices& file = render_mesh.vertices.at(body);
  const int first = render_mesh.body_begin[body];
  std::vector<int> all = points_of_vertices(file, render_mesh.body_begin[body + 1] - first);
  for (int& particle : all)
    if (particle >= 0) particle += first;
  return all;
}

int body_of(const Model& model, int user_index) {
  const std::vector<int>& begin = model.render_mesh.body_begin;
  return static_cast<int>(std::upper_bound(begin.begin(), begin.end(), user_index) - begin.begin()) - 1;
}

std::vector<int> bodies_of(const Model& model) {
  std::vector<int> body(model.user_index.size());
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = body_of(model, model.user_index[i]);
  return body;
}

std::size_t mesh_count(const Model& model) {
  return static_cast<std::size_t>(std::ranges::count_if(model.environment, is_rigid_mesh));
}
std::size_t shape_count(const Model& model) {
  const auto is_exact = [](const EnvironmentMesh& object) { return object.exact.has_value(); };
  return static_cast<std::size_t>(std::ranges::count_if(model.environment, is_exact));
}

bool names_edges(const Scene& scene) {
  return std::ranges::any_of(scene.environment, [](const EnvironmentSpec& object) { return object.edges; });
}

bool guards_run_in_turns(const Model& model) {
  const std::size_t all = model.environment.size(), meshes = mesh_count(model), shapes = shape_count(model);
  const int kinds = int(meshes > 0) + int(shapes > 0) + int(all > meshes + shapes);
  return model.scene.self_collision || names_edges(model.scene) || kinds > 1;
}

}  // namespace malha
