// SPDX-License-Identifier: Apache-2.0
#include "host/environment/start_behind_sheets.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "host/attachments/pose.h"
#include "host/environment/start_inside_solids.h"
#include "host/environment/surface.h"
#include "host/mesh/edge_sides.h"
#include "host/model/ordering/index_map.h"
#include "host/model/pins.h"
#include "malha/text.h"

namespace malha {

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

  /// One that contact would find behind the sheet in the first substep, and put before it (find_contact.h).
  void look(int i, const Vec3& x, const Vec3& v) {
    const Point a = local(x);
    const double reach = 2 * spec_.thickness + substep_ * std::hypot(v[0], v[1], v[2]);
    if (surface_.box_distance(a) > reach) return;
    const ClosestPoint near = surface_.closest(a, surface_.diagonal() + reach, near_);
    if (!near.found) return;
    near_ = near.triangle;  // a neighbour's is near, too
    if (!near.boundary && dot(near.normal, a - near.q) < 0) add(i, near.distance);
  }

  /// The end behind it of an edge that goes through it, so that from either end it is met from the same side.
  void look(int i, const Vec3& x, int j, const Vec3& y) {
    const Point a = local(x), b = local(y);
    if (surface_.box_distance((a + b) * 0.5) > norm(b - a) / 2) return;
    const Crossing first = surface_.crossing(a, b, 0, false), last = surface_.crossing(b, a, 0, false);
    if (!first.hit || !last.hit) return;
    const double before = dot(first.normal, a - first.q), behind = dot(last.normal, b - last.q);
    if (before > 0 && behind < 0) add(j, -behind);
    if (before < 0 && behind > 0) add(i, -before);
  }

  void tell(Model& model) const {
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
    if (depth > kSunk * spec_.thickness) behind_[i] = std::max(behind_[i], depth);
  }

  const EnvironmentSpec& spec_;
  Surface surface_;
  Pose pose_;
  double substep_;              // s
  int near_ = -1;               // the triangle next to the last particle
  std::vector<double> behind_;  // m, of each particle
};

}  // namespace

void note_starts_behind(Model& model) {
  const auto one_sided = [](const EnvironmentMesh& mesh) { return mesh.spec.sides == Sides::OneSided; };
  if (std::none_of(model.environment.begin(), model.environment.end(), one_sided)) return;
  const std::vector<bool> held = held_at_start(model, false);
  const std::vector<int> number = solver_of(model.user_index);
  const Device device;
  for (const EnvironmentMesh& mesh : model.environment) {
    if (!one_sided(mesh)) continue;
    Sheet sheet(device, mesh, model);
    for (int i = 0; i < model.count(); ++i)
      if (!held[i]) sheet.look(i, model.x[i], model.v[i]);
    const auto look = [&](int user, int other) {
      const int i = number[user], j = number[other];
      if (!held[i] || !held[j]) sheet.look(i, model.x[i], j, model.x[j]);
    };
    visit_face_sides(model.look.faces, look);
    for (const Edge& line : model.look.lines) look(line[0], line[1]);
    sheet.tell(model);
  }
}

}  // namespace malha
