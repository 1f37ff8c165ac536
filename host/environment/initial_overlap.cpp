// SPDX-License-Identifier: Apache-2.0
#include "host/environment/initial_overlap.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "host/attachments/pose.h"
#include "host/environment/closest_point_index.h"
#include "host/environment/moving_shape.h"
#include "host/mesh/bounding_box.h"
#include "host/mesh/edge_sides.h"
#include "host/model/ordering/index_map.h"
#include "host/model/pins.h"
#include "host/model/self_surface.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

constexpr int kMaxMoves = 100;

struct Inside {
  int deepest = -1;  // particle, solver's number
  int particles = 0;
  double depth = 0;  // m
  Point out{};       // unit, in the world
};

/// A solid at time 0. The Embree scene of a mesh is built when a particle lies in its box.
class Solid {
 public:
  Solid(const Device& device, const EnvironmentMesh& mesh)
      : device_(device), mesh_(mesh), pose_(pose_at(mesh.spec.motion, 0)), box_(bounds_of(mesh.mesh.points)) {}

  const EnvironmentSpec& spec() const { return mesh_.spec; }

  /// Finds the particles inside the solid.
  Inside find(const std::vector<Vec3>& x, const std::vector<int>& particles) {
    Inside found;
    const double least = 1e-6 * mesh_.spec.thickness;
    if (mesh_.exact) return find_in(moving_shape(*mesh_.exact, mesh_.spec, 0, 0), least, x, particles);
    for (const int i : particles) {
      const Point a = to_local(pose_, Point{x[i][0], x[i][1], x[i][2]});
      const auto& [low, high] = box_;
      if (!(a.x > low[0] && a.x < high[0] && a.y > low[1] && a.y < high[1] && a.z > low[2] && a.z < high[2])) continue;
      if (!surface_) surface_.emplace(device_, mesh_.mesh);
      const ClosestPoint near = surface_->closest(a, surface_->diagonal(), near_);
      if (!near.found) continue;
      near_ = near.triangle;
      if (!(dot(near.normal, a - near.q) < 0) || !(near.distance > least)) continue;
      ++found.particles;
      if (near.distance <= found.depth) continue;
      found.deepest = i, found.depth = near.distance;
      found.out = rotate(pose_, (near.q - a) * (1 / near.distance));
    }
    return found;
  }

 private:
  static Inside find_in(const MovingShape& shape, double least, const std::vector<Vec3>& x,
                        const std::vector<int>& particles) {
    Inside found;
    for (const int i : particles) {
      const Point a = to_local(shape.before, Point{x[i][0], x[i][1], x[i][2]});
      const SurfaceDistance<double> at = distance_to(shape.shape, a);
      if (!(-at.distance > least)) continue;
      ++found.particles;
      if (-at.distance <= found.depth) continue;
      found.deepest = i, found.depth = -at.distance, found.out = rotate(shape.before, at.normal);
    }
    return found;
  }

  const Device& device_;
  const EnvironmentMesh& mesh_;
  Pose pose_;
  BoundingBox box_;
  std::optional<ClosestPointIndex> surface_;
  int near_ = -1;
};

std::string metres(double value) { return shown(value) + " m"; }

/// Moves bodies out of solids, or refuses them.
class InitialOverlaps {
 public:
  explicit InitialOverlaps(Model& model) : model_(model), held_(fixed_at_start(model, true)) {
    for (std::size_t e = 0; e < model.environment.size(); ++e)
      if (model.environment[e].spec.sides == Sides::Solid)
        solids_.emplace_back(device_, model.environment[e]), number_.push_back(e);
  }

  void check() {
    std::vector<std::vector<int>> bodies(model_.scene.bodies.size());
    for (int i = 0; i < model_.count(); ++i) bodies[body_of(model_, model_.user_index[i])].push_back(i);
    for (std::size_t b = 0; b < bodies.size(); ++b) check(b, bodies[b]);
  }

 private:
  void check(std::size_t b, const std::vector<int>& all) {
    std::vector<int> movable_particles;
    for (const int i : all)
      if (!held_[i]) movable_particles.push_back(i);
    const bool movable = movable_particles.size() == all.size();
    Vec3 moved{};
    std::string from;
    std::vector<std::string> notes;
    for (int moves = 0;; ++moves) {
      bool inside = false;
      notes.clear();
      for (std::size_t s = 0; s < solids_.size(); ++s) {
        const Inside found = solids_[s].find(model_.x, movable_particles);
        if (found.deepest < 0) continue;
        if (found.depth <= solids_[s].spec().thickness && !(movable && solids_[s].spec().push_out)) {
          if (found.depth > kNegligibleDepth * solids_[s].spec().thickness)
            notes.push_back(stays(b, s, found, movable));
          continue;
        }
        if (!solids_[s].spec().push_out) refuse_inside(s, found, "");
        if (!movable) refuse_inside(s, found, ", and has pins or attachments, so that it cannot be moved");
        if (moves == kMaxMoves)
          refuse_inside(s, found, ", after " + std::to_string(moves) + " moves towards the nearest surface");
        inside = true;
        if (from.empty()) from = solids_[s].spec().name;
        const double by = found.depth + solids_[s].spec().thickness;
        const double step[3] = {by * found.out.x, by * found.out.y, by * found.out.z};
        for (int k = 0; k < 3; ++k) {
          moved[k] += step[k];
          for (const int i : all) model_.x[i][k] += step[k];
        }
      }
      if (!inside) break;
    }
    model_.notes.insert(model_.notes.end(), notes.begin(), notes.end());
    if (from.empty()) return;
    for (const int i : all) model_.render_mesh.points[model_.user_index[i]] = model_.x[i];
    for (Vec3& unused : model_.render_mesh.vertices[b].position)
      for (int k = 0; k < 3; ++k) unused[k] += moved[k];
    model_.notes.push_back("body '" + model_.scene.bodies[b].name + "' started inside '" + from +
                           "' and was moved out of it as it is, by (" + shown(moved[0]) + ", " + shown(moved[1]) +
                           ", " + shown(moved[2]) + ") m");
  }

  /// The note on a body that is inside by no more than the thickness and stays so (contact_query.h): moving single
  /// particles out would stretch it.
  std::string stays(std::size_t b, std::size_t s, const Inside& found, bool movable) const {
    return "body '" + model_.scene.bodies[b].name + "' starts up to " + metres(found.depth) + " inside '" +
           solids_[s].spec().name + "' (" + counted(found.particles, "particle") +
           "), less than its thickness, and stays as deep until it comes out by itself; take a start outside of it" +
           (movable ? ", or \"start_inside\": \"push_out\"" : "");
  }

  [[noreturn]] void refuse_inside(std::size_t s, const Inside& found, const std::string& more) const {
    const EnvironmentSpec& spec = solids_[s].spec();
    refuse(
        model_.scene.file, "/environment/" + std::to_string(number_[s]),
        particle_name(model_, model_.user_index[found.deepest]) + ", which starts " + metres(found.depth) +
            " inside '" + spec.name + "' (" + counted(found.particles, "particle") + " of that body inside it)" + more,
        "bodies that start outside of solids, or in them by no more than their thickness (here " +
            metres(spec.thickness) + "); with \"start_inside\": \"push_out\" bodies that nothing holds are moved out");
  }

  Device device_;
  Model& model_;
  std::vector<Solid> solids_;
  std::vector<std::size_t> number_;  // in the scene
  std::vector<bool> held_;
};

}  // namespace

void start_outside(Model& model) {
  bool any = false;
  for (const EnvironmentMesh& mesh : model.environment) any = any || mesh.spec.sides == Sides::Solid;
  if (!any) return;
  const std::size_t notes = model.notes.size();
  InitialOverlaps(model).check();
  if (model.notes.size() > notes && model.scene.self_collision) check_crossings(model, self_surface(model));
}

namespace {

/// A one-sided sheet at time 0, and the particles that start behind it.
class Sheet {
 public:
  Sheet(const Device& device, const EnvironmentMesh& mesh, const Model& model)
      : spec_(mesh.spec),
        surface_(device, mesh.mesh),
        pose_(pose_at(mesh.spec.motion, 0)),
        substep_(model.scene.solver.dt / model.scene.solver.substeps),
        behind_(model.x.size()) {}

  /// Adds a particle that contact would find behind the sheet in the first substep and move in front of it
  /// (find_contact.h).
  void check(int i, const Vec3& x, const Vec3& v) {
    const Point a = local(x);
    const double contact_range = 2 * spec_.thickness + substep_ * std::hypot(v[0], v[1], v[2]);
    if (surface_.box_distance(a) > contact_range) return;
    const ClosestPoint near = surface_.closest(a, surface_.diagonal() + contact_range, near_);
    if (!near.found) return;
    near_ = near.triangle;  // a hint for the next particle, a neighbour
    if (!near.boundary && dot(near.normal, a - near.q) < 0) add(i, near.distance);
  }

  /// Adds the end behind the sheet of an edge that goes through it, if both ends meet the sheet consistently.
  void check(int i, const Vec3& x, int j, const Vec3& y) {
    const Point a = local(x), b = local(y);
    if (surface_.box_distance((a + b) * 0.5) > norm(b - a) / 2) return;
    const Crossing first = surface_.crossing(a, b, 0, false), last = surface_.crossing(b, a, 0, false);
    if (!first.hit || !last.hit) return;
    const double before = dot(first.normal, a - first.q), behind = dot(last.normal, b - last.q);
    if (before > 0 && behind < 0) add(j, -behind);
    if (before < 0 && behind > 0) add(i, -before);
  }

  void add_notes(Model& model) const {
    std::map<int, std::vector<std::pair<double, int>>> bodies;
    for (int i = 0; i < model.count(); ++i)
      if (behind_[i] > 0) bodies[body_of(model, model.user_index[i])].push_back({behind_[i], i});
    for (const auto& [b, all] : bodies) {
      const auto& [depth, i] = *std::max_element(all.begin(), all.end());
      if (depth <= spec_.thickness) {
        model.notes.push_back("body '" + model.scene.bodies[b].name + "' starts up to " + shown(depth) +
                              " m behind the one-sided sheet '" + spec_.name + "' (" + counted(all.size(), "particle") +
                              "), less than its thickness, and stays as deep until it comes out by itself; take a " +
                              "start before it");
        continue;
      }
      std::vector<std::pair<double, int>> particles;
      std::copy_if(all.begin(), all.end(), std::back_inserter(particles),
                   [this](const auto& one) { return one.first > spec_.thickness; });
      model.notes.push_back("body '" + model.scene.bodies[b].name + "': " + counted(particles.size(), "particle") +
                            (particles.size() == 1 ? " starts" : " start") + " behind the one-sided sheet '" +
                            spec_.name + "' (" + std::to_string(number_in_body(model, model.user_index[i])) + " by " +
                            shown(depth) + " m), and will be put before it or be kept from the rest; its normals " +
                            "say which side is the front");
    }
  }

 private:
  Point local(const Vec3& x) const { return to_local(pose_, Point{x[0], x[1], x[2]}); }
  void add(int i, double depth) {
    if (depth > kNegligibleDepth * spec_.thickness) behind_[i] = std::max(behind_[i], depth);
  }

  const EnvironmentSpec& spec_;
  ClosestPointIndex surface_;
  Pose pose_;
  double substep_;              // s
  int near_ = -1;               // the closest triangle of the last particle
  std::vector<double> behind_;  // m, of each particle
};

}  // namespace

void note_starts_behind(Model& model) {
  const auto one_sided = [](const EnvironmentMesh& mesh) { return mesh.spec.sides == Sides::OneSided; };
  if (std::none_of(model.environment.begin(), model.environment.end(), one_sided)) return;
  const std::vector<bool> held = fixed_at_start(model, false);
  const std::vector<int> number = solver_of(model.user_index);
  const Device device;
  for (const EnvironmentMesh& mesh : model.environment) {
    if (!one_sided(mesh)) continue;
    Sheet sheet(device, mesh, model);
    for (int i = 0; i < model.count(); ++i)
      if (!held[i]) sheet.check(i, model.x[i], model.v[i]);
    const auto check = [&](int user, int other) {
      const int i = number[user], j = number[other];
      if (!held[i] || !held[j]) sheet.check(i, model.x[i], j, model.x[j]);
    };
    for_each_face_side(model.render_mesh.faces, check);
    for (const Edge& line : model.render_mesh.lines) check(line[0], line[1]);
    sheet.add_notes(model);
  }
}

}  // namespace malha
