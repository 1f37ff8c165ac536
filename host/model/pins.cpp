// SPDX-License-Identifier: Apache-2.0
#include "host/model/pins.h"

#include <algorithm>

#include "host/base/spelling_suggestion.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "host/model/model.h"
#include "host/model/vertex_map.h"
#include "malha/error.h"

namespace malha {

namespace {

/// Finds the particles that a selector selects.
class ParticleFinder {
 public:
  /// `place`: of the selector in the scene, for messages.
  ParticleFinder(const Shape& shape, const Mesh& mesh, const MapPlace& place)
      : shape_(shape), mesh_(mesh), place_(place), n_(static_cast<int>(mesh.points.size())) {}

  std::vector<int> operator()(const RowPin& pin) const {
    int row = 0;
    if (const auto* grid = std::get_if<GridShape>(&shape_)) row = grid->cells[0] + 1;
    if (std::holds_alternative<ChainShape>(shape_)) row = 1;
    std::vector<int> found(row);
    for (int i = 0; i < row; ++i) found[i] = pin.last ? n_ - row + i : i;
    return found;
  }
  std::vector<int> operator()(const BoxPin& pin) const {
    return where([&pin](const Vec3& x) {
      bool inside = true;
      for (int k = 0; k < 3; ++k) inside = inside && pin.min[k] <= x[k] && x[k] <= pin.max[k];
      return inside;
    });
  }
  std::vector<int> operator()(const SpherePin& pin) const {
    return where([&pin](const Vec3& x) { return squared_distance(x, pin.center) <= pin.radius * pin.radius; });
  }
  std::vector<int> operator()(const NearestPin& pin) const {
    const auto nearer = [&pin](const Vec3& a, const Vec3& b) {
      return squared_distance(a, pin.point) < squared_distance(b, pin.point);
    };
    const auto& points = mesh_.points;
    return {static_cast<int>(std::ranges::min_element(points, nearer) - points.begin())};
  }
  std::vector<int> operator()(const MapPin& pin) const {
    const std::vector<double> values = values_at_points(shape_, mesh_, pin.map, place_);
    std::vector<int> found;
    for (int i = 0; i < n_; ++i)
      if (values[static_cast<std::size_t>(i)] > pin.above) found.push_back(i);
    return found;
  }
  /// The vertices in the numbering of the file.
  std::vector<int> operator()(const ListPin& pin) const { return pin.particles; }
  std::vector<int> operator()(const RimPin& pin) const {
    std::vector<Edge> rim;
    const auto visit = [this](const auto& add) { for_each_face_side(mesh_.faces, add); };
    for_each_edge(sorted_sides(mesh_.points.size(), visit), [&rim](auto first, auto last) {
      if (last - first == 1) rim.push_back({first->low, first->high});
    });
    std::vector<bool> at_rim(n_, false);
    for (const auto& [a, b] : rim) at_rim[a] = at_rim[b] = true;
    std::vector<int> found;
    for (int i = 0; i < n_; ++i)
      if (at_rim[i]) found.push_back(i);
    if (!pin.nearest || found.empty()) return found;
    int parts = 0;
    const std::vector<int> line = components(n_, rim, parts);
    const int nearest =
        *std::ranges::min_element(found, {}, [&](int i) { return squared_distance(mesh_.points[i], *pin.nearest); });
    std::erase_if(found, [&](int i) { return line[i] != line[nearest]; });
    return found;
  }

 private:
  template <class Test>
  std::vector<int> where(Test&& test) const {
    std::vector<int> found;
    for (int i = 0; i < n_; ++i)
      if (test(mesh_.points[i])) found.push_back(i);
    return found;
  }

  const Shape& shape_;
  const Mesh& mesh_;
  const MapPlace place_;
  int n_;
};

/// Builds the boundary conditions of one body.
class BoundaryConditionBuilder {
 public:
  BoundaryConditionBuilder(const Scene& scene, std::size_t body, const Mesh& mesh)
      : scene_(scene),
        number_(body),
        spec_(scene.bodies[body]),
        mesh_(mesh),
        body_("/bodies/" + std::to_string(body)) {}

  BoundaryConditions build() {
    const std::size_t n = mesh_.points.size();
    boundary_.pinned.assign(n, false), moved_.assign(n, false);
    for (std::size_t k = 0; k < spec_.pins.size(); ++k) {
      const Pin& pin = spec_.pins[k];
      const std::string here = body_ + "/pins/" + std::to_string(k);
      add_pin(here, {{}, pin.motion, ""}, pin.release_time, select(pin.at, here, "a pin that holds a particle"));
    }
    for (std::size_t k = 0; k < spec_.attachments.size(); ++k)
      add_attachment(spec_.attachments[k], body_ + "/attachments/" + std::to_string(k));
    return std::move(boundary_);
  }

 private:
  std::vector<int> select(const Selector& selector, const std::string& here, const std::string& allowed) const {
    return select_particles(scene_, number_, mesh_, selector, here, allowed);
  }

  void add_pin(const std::string& here, Target target, std::optional<double> release_time, std::vector<int> particles) {
    const bool moves = target.moves() || release_time;
    for (const int i : particles) {
      if (moved_[i] || (moves && boundary_.pinned[i]))
        refuse(scene_.file, here,
               "particle " + std::to_string(vertex_of(mesh_.vertices, i)) +
                   ", which another pin or rigid attachment holds too",
               "one for a particle that moves or is released");
      if (moves) moved_[i] = true;
      if (!release_time) boundary_.pinned[i] = true;
    }
    if (release_time && scene_.solver.type == "desbrun")
      refuse(scene_.file, here + "/release_time",
             "a release under Desbrun's method, whose filter is made for pins that stay",
             "one without it, or solver type pbd");
    if (moves) boundary_.moved.push_back({std::move(target), release_time, std::move(particles)});
  }

  void add_attachment(const Attachment& spec, const std::string& here) {
    Target target{spec.point, spec.motion, spec.environment};
    if (!spec.environment.empty()) {
      const EnvironmentSpec& object = environment(spec.environment, here + "/to/environment");
      target.motion = object.motion, target.deforms = object.animation.has_value();
    }
    std::vector<int> particles = select(spec.at, here + "/at", "an attachment of a particle");
    const bool rigid = spec.compliance.value_or(spec.stiffness == 1 ? 0 : 1) == 0;
    if (rigid) return add_pin(here, std::move(target), spec.release_time, std::move(particles));
    std::erase_if(particles, [this](int i) { return boundary_.pinned[i]; });
    if (particles.empty()) refuse(scene_.file, here + "/at", "pinned particles alone", "at least one that can move");
    boundary_.attached.push_back(
        {std::move(target), spec.stiffness, spec.compliance, spec.release_time, std::move(particles)});
  }

  const EnvironmentSpec& environment(const std::string& name, const std::string& here) const {
    std::vector<std::string> names;
    for (const EnvironmentSpec& object : scene_.environment) {
      if (object.name == name) return object;
      names.push_back(object.name);
    }
    refuse(scene_.file, here, "unknown environment object '" + name + "'" + did_you_mean(name, names),
           names.empty() ? "one of the scene's environment, which has none" : join(names));
  }

  const Scene& scene_;
  std::size_t number_;
  const BodySpec& spec_;
  const Mesh& mesh_;
  std::string body_;
  BoundaryConditions boundary_;
  std::vector<bool> moved_;  // whether each particle is in a pin that moves or is released
};

/// Tells whether each particle (the user's numbering) has a pin or a rigid attachment that moves or is released.
std::vector<bool> in_moved_pins(const Model& model) {
  std::vector<bool> moved(model.user_index.size(), false);
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) moved[model.user_index[i]] = true;
  return moved;
}

}  // namespace

std::vector<int> points_of(const Scene& scene, const Mesh& mesh, std::vector<int> vertices, const std::string& here) {
  const std::vector<int> points = points_of_vertices(mesh.vertices, static_cast<int>(mesh.points.size()));
  const int n = static_cast<int>(points.size());
  for (int& i : vertices) {
    const std::string found = "particle " + std::to_string(i);
    if (i < 0 || i >= n) refuse(scene.file, here, found, "0 to " + std::to_string(n - 1));
    if (points[i] < 0)
      refuse(scene.file, here, found + ", a vertex of no face, line or tetrahedron",
             "vertices of faces, lines or tetrahedra");
    i = points[i];
  }
  return vertices;
}

std::vector<int> select_particles(const Scene& scene, std::size_t body, const Mesh& mesh, const Selector& selector,
                                  const std::string& here, const std::string& allowed) {
  std::vector<int> found =
      std::visit(ParticleFinder(scene.bodies[body].shape, mesh, {scene.file, here + "/map"}), selector);
  if (found.empty())
    refuse(scene.file, here, "no particle there",
           allowed + " (rows are for grids and chains, rims for meshes that are not closed)");
  if (std::holds_alternative<ListPin>(selector)) found = points_of(scene, mesh, std::move(found), here);
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<bool> BoundaryConditions::at_start() const {
  std::vector<bool> all = pinned;
  for (const MovedPins& pins : moved)
    for (const int i : pins.particles) all[i] = true;
  return all;
}

void split_boundary_conditions(int vertex, BoundaryConditions& boundary) {
  const int duplicate = static_cast<int>(boundary.pinned.size());
  boundary.pinned.push_back(boundary.pinned[vertex]);
  const auto extend = [&](auto& sets) {
    for (auto& set : sets)
      if (std::ranges::binary_search(set.particles, vertex)) set.particles.push_back(duplicate);
  };
  extend(boundary.moved), extend(boundary.attached);
}

std::vector<bool> fixed_at_start(const Model& model, bool include_springs) {
  std::vector<bool> fixed(model.w.size());
  for (std::size_t i = 0; i < fixed.size(); ++i) fixed[i] = model.w[i] == 0;
  const auto fix = [&fixed](const auto& sets) {
    for (const auto& set : sets)
      for (const int i : set.particles) fixed[i] = true;
  };
  fix(model.moved);
  if (include_springs) fix(model.attached);
  return fixed;
}

BoundaryConditions find_boundary_conditions(const Scene& scene, std::size_t body, const Mesh& mesh) {
  return BoundaryConditionBuilder(scene, body, mesh).build();
}

std::vector<int> static_pins(const Model& model) {
  const std::vector<bool> moved = in_moved_pins(model);
  std::vector<int> list;
  for (int i = 0; i < model.count(); ++i)
    if (!(model.w[i] > 0) && !moved[model.user_index[i]]) list.push_back(model.user_index[i]);
  std::ranges::sort(list);
  return list;
}

std::vector<bool> has_keyframes(const Model& model) {
  std::vector<bool> moves(model.user_index.size(), false);
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) moves[model.user_index[i]] = pins.target.moves();
  return moves;
}

Scene with_pins(const Model& model, const std::vector<int>& particles) {
  const std::vector<bool> in_other_pin = in_moved_pins(model);
  for (const int i : particles) {
    if (i < 0 || i >= model.count())
      refuse("pins", "", "particle " + std::to_string(i), "0 to " + std::to_string(model.count() - 1));
    if (in_other_pin[i])
      refuse(
          "pins", "",
          particle_name(model, i) + ", which an attachment or a pin on keyframes or with a release holds or has held",
          "others");
  }
  const std::vector<int> before = static_pins(model);
  Scene scene = model.scene;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const auto of_body = [&](const std::vector<int>& all) {
      return std::vector<int>(std::lower_bound(all.begin(), all.end(), model.render_mesh.body_begin[b]),
                              std::lower_bound(all.begin(), all.end(), model.render_mesh.body_begin[b + 1]));
    };
    std::vector<int> list = of_body(particles);
    if (list == of_body(before)) continue;  // keep its selectors
    for (int& i : list) i = number_in_body(model, i);
    std::erase_if(scene.bodies[b].pins, [](const Pin& pin) { return pin.motion.empty() && !pin.release_time; });
    if (!list.empty()) scene.bodies[b].pins.push_back(ListPin{list});
  }
  return scene;
}

}  // namespace malha
