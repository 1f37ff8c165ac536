#include "host/model/model.h"

#include <algorithm>
#include <cmath>

#include "host/base/shown.h"
#include "host/base/stopwatch.h"
#include "host/error.h"
#include "host/mesh/check_mesh.h"
#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/mesh/weld.h"
#include "host/model/elements.h"
#include "host/model/footprint.h"
#include "host/model/order.h"
#include "host/model/self_surface.h"
#include "host/model/tear.h"
#include "kernels/constraints.h"

namespace malha {

namespace {

/// A body's mesh with what hangs on it, in the body's own numbering.
struct Body {
  Mesh mesh;
  std::vector<Edge> edges;
  Holds holds;
  std::vector<double> mass;
};

/// Where a body's or environment's shape is written, for messages: the mesh file, or the scene.
std::string origin(const Scene& scene, const Shape& shape) {
  const auto* file = std::get_if<MeshFile>(&shape);
  return file ? file->path : scene.file;
}

std::string pointer(const char* list, std::size_t index, const char* key) {
  return "/" + std::string(list) + "/" + std::to_string(index) + "/" + key;
}

/// An expectation about something that the scene does not have would always be met. `tetrahedra`: its meshes have any.
void check_expectations(const Scene& scene, bool tetrahedra) {
  const auto needs = [&scene](bool asked, bool there, const std::string& key, const std::string& what) {
    if (asked && !there) refuse(scene.file, "/expect/" + key, "an expectation about " + what, "one where there is any");
  };
  bool distance = false, pressure = false, inside = false;
  for (const BodySpec& body : scene.bodies)
    for (const ConstraintSpec& constraint : body.constraints) {
      distance = distance || constraint.type == Distance::name;
      pressure = pressure || constraint.type == "pressure";
    }
  for (const EnvironmentSpec& environment : scene.environment) inside = inside || environment.sides != Sides::TwoSided;
  const Expect& expect = scene.expect;
  needs(expect.max_strain.has_value(), distance, "max_strain", "strain in a scene without distance constraints");
  needs(expect.rms_strain.has_value(), distance, "rms_strain", "strain in a scene without distance constraints");
  needs(expect.volume_ratio.has_value(), pressure || tetrahedra, "volume_ratio",
        "volume in a scene without pressure and without tetrahedra");
  needs(expect.inverted_tetrahedra.has_value(), tetrahedra, "inverted_tetrahedra", "tetrahedra in a scene without any");
  needs(expect.max_crossings.has_value(), scene.self_collision.has_value(), "max_crossings",
        "crossings in a scene without self_collision");
  needs(expect.max_penetration.has_value(), inside, "max_penetration",
        "penetration in a scene without solids or one-sided sheets");
}

/// A mesh that changes has no place in a format that writes it once.
void check_outputs(const Scene& scene) {
  const auto& formats = scene.outputs.formats;
  if (tears(scene) && std::find(formats.begin(), formats.end(), "pc2") != formats.end())
    refuse(scene.file, "/outputs/frames/formats", "pc2, which holds one mesh for all frames, of a scene that tears",
           "vtp, ply, obj");
}

Mesh load_body(const Scene& scene, std::size_t index, int& zero_area_faces, std::vector<std::string>& notes) {
  const BodySpec& spec = scene.bodies[index];
  Mesh mesh = make_mesh(spec.shape);
  if (const auto* file = std::get_if<MeshFile>(&spec.shape)) {
    const std::string body = "body '" + spec.name + "': ";
    if (file->weld) {
      const auto [merged, gone] = weld(mesh, *file->weld, file->path);
      notes.push_back(body + "welded " + counted(merged, "vertex", "vertices") + " to others" +
                      (gone > 0 ? ", by which " + counted(gone, "face or line", "faces or lines") + " went" : ""));
    }
    if (const int unused = drop_unused_points(mesh); unused > 0)
      notes.push_back(body + "left out " + counted(unused, "vertex", "vertices") +
                      " of no face, line or tetrahedron; particles are numbered without them");
  }
  const bool loose = std::holds_alternative<CloudShape>(spec.shape);
  zero_area_faces += check_mesh(mesh, origin(scene, spec.shape), loose).zero_area_faces;
  apply(spec.transform, mesh);
  return mesh;
}

Body make_body(const Scene& scene, std::size_t index, Mesh mesh, const Torn* torn) {
  const BodySpec& spec = scene.bodies[index];
  Body body;
  body.mesh = std::move(mesh);
  body.holds = find_holds(scene, index, body.mesh);
  if (tears(scene) && !body.mesh.tetrahedra.empty())
    refuse(scene.file, pointer("bodies", index, "shape"), "tetrahedra in a scene with a body that tears",
           "bodies of faces and lines there");
  if (torn)
    for (const Split& split : *torn->done)
      if (split.body == static_cast<int>(index)) apply(split, body.mesh), split_holds(split.vertex, body.holds);
  body.edges = edges(body.mesh);
  body.mass = spec.mass ? masses_by_total(body.mesh, *spec.mass) : masses_by_density(body.mesh, *spec.density);
  for (std::size_t i = 0; i < body.mass.size(); ++i)
    if (!(body.mass[i] > 0))
      refuse(scene.file, pointer("bodies", index, spec.mass ? "mass" : "density"),
             "no mass for particle " + std::to_string(i), "a mass or density that leaves no particle massless");
  return body;
}

class Builder {
 public:
  Builder(const Scene& scene, int threads, const Torn* torn = nullptr) : threads_(threads), torn_(torn) {
    model_.scene = scene;
  }

  Model build() {
    const Scene& scene = model_.scene;
    if (!torn_) parse_scene(to_json(scene), scene.file, "");  // a scene made in code is held to what a file is held to
    check_outputs(scene);
    if (scene.self_collision && tears(scene))
      refuse(scene.file, "/self_collision", "self_collision in a scene with a body that tears", "one of them");
    model_.look.body_begin = model_.look.face_begin = model_.look.line_begin = {0};
    ModelSeconds& took = model_.seconds;
    took.load = seconds([&] {
      for (std::size_t b = 0; b < scene.bodies.size(); ++b) add_body(make_body(scene, b, mesh_of(b), torn_));
    });
    check_expectations(scene, std::any_of(bodies_.begin(), bodies_.end(),
                                          [](const Body& body) { return !body.mesh.tetrahedra.empty(); }));
    took.order = seconds([this] { arrange(); });
    took.connect = seconds([this] { add_constraints(); });
    took.patches = seconds([this] { cut(); });
    took.load += seconds([&] {
      if (torn_) model_.environment = *torn_->environment, model_.zero_area_faces = torn_->zero_area_faces;
      if (torn_) model_.notes = *torn_->notes;
      for (std::size_t e = 0; e < scene.environment.size() && !torn_; ++e) add_environment(e);
    });
    if (scene.self_collision) look_at_crossings();
    return std::move(model_);
  }

 private:
  void look_at_crossings() {
    const SelfSurface surface = self_surface(model_);
    check_pairs(model_, surface);
    refuse_crossings(model_, surface);
  }

  Mesh mesh_of(std::size_t b) {
    return torn_ ? body_mesh(*torn_->whole, b) : load_body(model_.scene, b, model_.zero_area_faces, model_.notes);
  }

  void add_body(Body body) {
    Appearance& look = model_.look;
    const int first = static_cast<int>(look.points.size());
    look.points.insert(look.points.end(), body.mesh.points.begin(), body.mesh.points.end());
    for (Quad face : body.mesh.faces) {
      for (int& corner : face)
        if (corner >= 0) corner += first;
      look.faces.push_back(face);
    }
    for (const Edge& line : body.mesh.lines) look.lines.push_back({line[0] + first, line[1] + first});
    look.body_begin.push_back(static_cast<int>(look.points.size()));
    look.face_begin.push_back(static_cast<int>(look.faces.size()));
    look.line_begin.push_back(static_cast<int>(look.lines.size()));
    bodies_.push_back(std::move(body));
  }

  /// Fixes the solver's order and fills the particles and the damped islands.
  void arrange() {
    const Appearance& look = model_.look;
    const int n = static_cast<int>(look.points.size());
    std::vector<Edge> all;
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      for (const Edge& e : bodies_[b].edges) all.push_back({e[0] + look.body_begin[b], e[1] + look.body_begin[b]});
    int islands = 0;
    const std::vector<int> island = components(n, all, islands);
    model_.user_of = solver_order(look.points, island, islands, all);
    for (const int user : model_.user_of) island_.push_back(island[user]);
    solver_of_.resize(n);
    for (int i = 0; i < n; ++i) solver_of_[model_.user_of[i]] = i;
    for (const Edge& e : all) edges_.push_back({solver_of_[e[0]], solver_of_[e[1]]});

    model_.x.resize(n), model_.v.resize(n), model_.w.resize(n), model_.mass.resize(n);
    for (std::size_t b = 0; b < bodies_.size(); ++b) place(b);

    for (int i = 0, end; i < n; i = end) {
      for (end = i; end < n && island_[end] == island_[i];) ++end;
      const double damping = model_.scene.bodies[body_of(model_, model_.user_of[i])].damping;
      if (damping > 0 && end - i > 1) model_.damped.push_back({i, end - i, damping});
    }
    if (model_.scene.solver.type == "pbd" && model_.scene.solver.keeps_momenta) find_free_islands();
  }

  void find_free_islands() {
    const int n = static_cast<int>(island_.size());
    std::vector<bool> held(n);
    for (int i = 0; i < n; ++i) held[i] = model_.w[i] == 0;
    const auto hold = [&held](const auto& sets) {
      for (const auto& set : sets)
        for (const int i : set.particles) held[i] = true;
    };
    hold(model_.moved), hold(model_.attached);
    for (int i = 0, end; i < n; i = end) {
      bool free = true;
      for (end = i; end < n && island_[end] == island_[i]; ++end) free = free && !held[end];
      if (free && end - i > 1) model_.free.push_back({i, end - i});
    }
  }

  void place(std::size_t b) {
    const BodySpec& spec = model_.scene.bodies[b];
    const Body& body = bodies_[b];
    const std::vector<bool> held = body.holds.at_start();
    Vec3 centre{0, 0, 0};
    double total = 0;
    for (std::size_t i = 0; i < body.mass.size(); ++i) {
      total += body.mass[i];
      for (int k = 0; k < 3; ++k) centre[k] += body.mass[i] * body.mesh.points[i][k];
    }
    for (std::size_t i = 0; i < body.mass.size(); ++i) {
      const int at = solver_of_[model_.look.body_begin[b] + i];
      const Vec3& x = body.mesh.points[i];
      const Vec3 r{x[0] - centre[0] / total, x[1] - centre[1] / total, x[2] - centre[2] / total};
      const Vec3& s = spec.spin;
      const Vec3 turn{s[1] * r[2] - s[2] * r[1], s[2] * r[0] - s[0] * r[2], s[0] * r[1] - s[1] * r[0]};
      model_.x[at] = x;
      model_.mass[at] = body.mass[i];
      model_.w[at] = body.holds.pinned[i] ? 0 : 1 / body.mass[i];
      for (int k = 0; k < 3; ++k) model_.v[at][k] = held[i] ? 0 : spec.velocity[k] + turn[k];
    }
    add_holds(b);
  }

  void add_holds(std::size_t b) {
    const auto add = [&](auto sets, auto& all) {
      for (auto& set : sets) {
        for (int& i : set.particles) i = solver_of_[model_.look.body_begin[b] + i];
        all.push_back(std::move(set));
      }
    };
    add(bodies_[b].holds.moved, model_.moved), add(bodies_[b].holds.attached, model_.attached);
  }

  /// Kind by kind in the registry's order, whatever the order in the scene, so that a sweep is the same.
  void add_constraints() {
    for_each_constraint([this]<class Kind>(Kind) {
      each_spec(Kind::name, [this](std::size_t b, const ConstraintSpec& spec, const std::string& place) {
        add_set<Kind>(b, spec, place);
      });
    });
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (bodies_[b].mesh.tetrahedra.empty()) continue;
      model_.tetrahedra.push_back(std::move(bodies_[b].mesh.tetrahedra));
      for (Tetrahedron& t : model_.tetrahedra.back())
        for (int& corner : t) corner = solver_of_[model_.look.body_begin[b] + corner];
    }
    each_spec("pressure",
              [this](std::size_t b, const ConstraintSpec& spec, const std::string&) { add_pressure(b, spec); });
    each_spec("long_range", [this](std::size_t b, const ConstraintSpec& spec, const std::string& place) {
      add_long_range(b, spec, place);
    });
    if (model_.scene.wind && model_.scene.wind->density > 0) add_air();
  }

  template <class F>
  void each_spec(const std::string& type, F&& f) {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const auto& specs = model_.scene.bodies[b].constraints;
      for (std::size_t c = 0; c < specs.size(); ++c)
        if (specs[c].type == type) f(b, specs[c], pointer("bodies", b, "constraints/") + std::to_string(c));
    }
  }

  template <class Kind>
  void add_set(std::size_t b, const ConstraintSpec& spec, const std::string& place) {
    auto [all, remainder, crowded] = list_elements(Kind::element, bodies_[b].mesh, bodies_[b].edges, spec);
    if (crowded > 0) note_crowded(b, Kind::name, crowded);
    if (all.particles.empty() && remainder.particles.empty()) {
      if (torn_) return;  // to pieces
      refuse(model_.scene.file, place, "a mesh that offers " + std::string(Kind::name) + " nothing to act on",
             facts_of(Kind::element).needed);
    }
    add_elements<Kind>(b, spec, std::move(all));
    if constexpr (requires { typename Kind::Remainder; }) {
      ConstraintSpec other = spec;
      other.type = Kind::Remainder::name, other.parameter = Kind::Remainder::parameter.standard;
      add_elements<typename Kind::Remainder>(b, other, std::move(remainder));
    }
  }

  void note_crowded(std::size_t b, const std::string& kind, int edges) {
    model_.notes.push_back("body '" + model_.scene.bodies[b].name + "': \"" + kind + "\" does not act at " +
                           counted(edges, "edge") + " with more than two faces, about which the sheet turns freely");
  }

  template <class Kind>
  void add_elements(std::size_t b, const ConstraintSpec& spec, Elements all) {
    if (all.particles.empty()) return;
    drop_what_is_pinned(all, Kind::particles, bodies_[b].holds.pinned);
    for (int& i : all.particles) i = solver_of_[model_.look.body_begin[b] + i];
    const SolverSpec& solver = model_.scene.solver;
    const std::optional<double> compliance = compliance_of<Kind>(spec);
    if (solver.type == "desbrun" && Kind::filtered == Filtered::Spring) {
      SpringSet springs = springs_of(spec, solver.desbrun.spring_constant, all.particles, all.softness, model_.x);
      if (!springs.ends.empty()) model_.springs.push_back(std::move(springs));
      return;
    }
    if (solver.type == "desbrun" && Kind::filtered == Filtered::Stencil) {
      ConstraintSet set{spec.type,      Kind::particles,          spec.stiffness,         compliance,
                        spec.parameter, std::move(all.particles), std::move(all.softness)};
      if (!(compliance.value_or(0) > 0)) soften_by_levers(set, solver.desbrun.spring_constant, model_.x);
      if (set.count() > 0) model_.stencils.push_back(std::move(set));
      return;
    }
    ConstraintSet& set = find_set(spec, Kind::particles, compliance, !all.softness.empty());
    set.particles.insert(set.particles.end(), all.particles.begin(), all.particles.end());
    set.softness.insert(set.softness.end(), all.softness.begin(), all.softness.end());
  }

  /// Constraints that could move nothing.
  static void drop_what_is_pinned(Elements& all, int arity, const std::vector<bool>& pinned) {
    std::size_t kept = 0;
    for (std::size_t c = 0; c < all.particles.size() / arity; ++c) {
      const int* of = &all.particles[c * arity];
      if (std::all_of(of, of + arity, [&](int i) { return pinned[i]; })) continue;
      std::copy_n(of, arity, &all.particles[kept * arity]);
      if (!all.softness.empty()) all.softness[kept] = all.softness[c];
      ++kept;
    }
    all.particles.resize(kept * arity);
    if (!all.softness.empty()) all.softness.resize(kept);
  }

  /// By itself or from a material's modulus.
  template <class Kind>
  static std::optional<double> compliance_of(const ConstraintSpec& spec) {
    if constexpr (!Kind::strength.free)
      return Kind::compliance(spec.rigidity ? *spec.rigidity : spec.young_modulus.value(), spec.parameter);
    return spec.rigidity ? std::optional<double>(1 / *spec.rigidity) : spec.compliance;
  }

  ConstraintSet& find_set(const ConstraintSpec& spec, int arity, std::optional<double> compliance, bool softened) {
    for (ConstraintSet& set : model_.sets)
      if (set.type == spec.type && set.stiffness == spec.stiffness && set.compliance == compliance &&
          set.parameter == spec.parameter && set.softness.empty() != softened)
        return set;
    return model_.sets.emplace_back(
        ConstraintSet{spec.type, arity, spec.stiffness, compliance, spec.parameter, {}, {}});
  }

  void add_pressure(std::size_t b, const ConstraintSpec& spec) {
    const Mesh& mesh = bodies_[b].mesh;
    require_closed(mesh, origin(model_.scene, model_.scene.bodies[b].shape),
                   "pressure needs a closed mesh (body '" + model_.scene.bodies[b].name + "')");
    PressureSet set{spec.parameter, spec.stiffness, spec.compliance, {}, triangles(mesh)};
    for (Triangle& t : set.triangles)
      for (int& corner : t) corner = solver_of_[model_.look.body_begin[b] + corner];
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      set.particles.push_back(solver_of_[model_.look.body_begin[b] + i]);
    model_.pressures.push_back(std::move(set));
  }

  /// The solver's particles of a body.
  std::vector<int> names(std::size_t b) const {
    const auto first = solver_of_.begin() + model_.look.body_begin[b];
    return {first, first + static_cast<std::ptrdiff_t>(bodies_[b].mesh.points.size())};
  }

  void add_long_range(std::size_t b, const ConstraintSpec& spec, const std::string& place) {
    const Body& body = bodies_[b];
    const int before = model_.long_range.items();
    attach_long_range(body.mesh, body.edges, body.holds.pinned, spec.parameter, names(b), model_.long_range);
    if (model_.long_range.items() > before) return;
    const auto& pinned = body.holds.pinned;
    const bool stays = std::find(pinned.begin(), pinned.end(), true) != pinned.end();
    const bool goes =
        std::any_of(body.holds.moved.begin(), body.holds.moved.end(), [](const auto& m) { return m.until; });
    refuse(model_.scene.file, place,
           stays  ? "no particle that is connected with a pin"
           : goes ? "no pin but those that are let go, at their \"until\""
                  : "no pin",
           "long-range attachments on a body with pins that are never let go");
  }

  void add_air() {
    for (std::size_t b = 0; b < bodies_.size(); ++b) add_air_faces(bodies_[b].mesh, names(b), model_.air);
    if (model_.air.particle.empty())
      refuse(model_.scene.file, "/wind/density", "air on the faces of bodies without faces",
             "a body with faces, or 'drag' alone");
  }

  /// Cuts the particles into patches and renumbers everything accordingly.
  void cut() {
    Cut cut = cut_into_patches(model_.sets, edges_, island_, threads_);
    std::vector<int> now(cut.order.size());
    for (std::size_t i = 0; i < now.size(); ++i) now[cut.order[i]] = static_cast<int>(i);
    const auto reorder = [&](auto& values) {
      auto sorted = values;
      for (std::size_t i = 0; i < now.size(); ++i) sorted[i] = values[cut.order[i]];
      values = std::move(sorted);
    };
    reorder(model_.user_of), reorder(model_.x), reorder(model_.v), reorder(model_.w), reorder(model_.mass);
    const auto renumber = [&](int& i) { i = now[i]; };
    for (ConstraintSet& set : model_.sets) std::for_each(set.particles.begin(), set.particles.end(), renumber);
    for (ConstraintSet& set : model_.stencils) std::for_each(set.particles.begin(), set.particles.end(), renumber);
    for (SpringSet& set : model_.springs)
      for (Edge& e : set.ends) std::for_each(e.begin(), e.end(), renumber);
    for (auto& body : model_.tetrahedra)
      for (Tetrahedron& t : body) std::for_each(t.begin(), t.end(), renumber);
    for (PressureSet& set : model_.pressures) {
      for (Triangle& t : set.triangles) std::for_each(t.begin(), t.end(), renumber);
      std::for_each(set.particles.begin(), set.particles.end(), renumber);
      std::sort(set.particles.begin(), set.particles.end());
    }
    for (std::vector<int>* list : {&model_.long_range.particle, &model_.long_range.anchor, &model_.air.particle})
      std::for_each(list->begin(), list->end(), renumber);
    for (Quad& face : model_.air.faces)
      for (int& corner : face)
        if (corner >= 0) renumber(corner);
    for (MovedPins& pins : model_.moved) std::for_each(pins.particles.begin(), pins.particles.end(), renumber);
    for (AttachmentSet& set : model_.attached) std::for_each(set.particles.begin(), set.particles.end(), renumber);
    model_.patches = std::move(cut.patches);
  }

  void add_environment(std::size_t e) {
    const EnvironmentSpec& spec = model_.scene.environment[e];
    const std::string file = origin(model_.scene, spec.shape);
    EnvironmentMesh mesh{spec, make_mesh(spec.shape)};
    // Its vertices are nobody's particles: those in one place are one, and those of no face do not matter.
    if (const auto* of = std::get_if<MeshFile>(&spec.shape)) weld(mesh.mesh, of->weld.value_or(0), file);
    model_.zero_area_faces += check_mesh(mesh.mesh, file, true).zero_area_faces;
    if (mesh.mesh.faces.empty())
      refuse(model_.scene.file, pointer("environment", e, "shape"), "a shape without faces", "a shape with faces");
    apply(spec.transform, mesh.mesh);
    if (spec.sides == Sides::Solid)
      require_closed(mesh.mesh, file, "a solid needs a closed mesh (object '" + spec.name + "')");
    model_.environment.push_back(std::move(mesh));
  }

  int threads_;
  const Torn* torn_;
  Model model_;
  std::vector<Body> bodies_;
  std::vector<int> solver_of_;
  std::vector<int> island_;  // of each particle, before they are cut into patches and after
  std::vector<Edge> edges_;  // of all bodies, before
};

}  // namespace

Model build_model(const Scene& scene, int threads) {
  require_memory(scene);
  return Builder(scene, threads).build();
}

Model build_torn_model(const Scene& scene, const Torn& torn, int threads) {
  return Builder(scene, threads, &torn).build();
}

std::string particle_name(const Model& model, int user_index) {
  const int body = body_of(model, user_index);
  return "particle " + std::to_string(user_index - model.look.body_begin[body]) + " of body '" +
         model.scene.bodies[body].name + "'";
}

int body_of(const Model& model, int user_index) {
  const std::vector<int>& begin = model.look.body_begin;
  return static_cast<int>(std::upper_bound(begin.begin(), begin.end(), user_index) - begin.begin()) - 1;
}

std::vector<int> bodies_of(const Model& model) {
  std::vector<int> body(model.user_of.size());
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = body_of(model, model.user_of[i]);
  return body;
}

}  // namespace malha
