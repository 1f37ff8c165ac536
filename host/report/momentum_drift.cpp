// SPDX-License-Identifier: Apache-2.0
#include "host/report/momentum_drift.h"

#include <algorithm>
#include <cmath>

#include "host/mesh/vectors.h"
#include "host/model/model.h"
#include "host/model/tear.h"
#include "kernels/forces/angular_velocity.h"
#include "malha/text.h"

namespace malha {

namespace {

double length(const Vec3& a) { return std::hypot(a[0], a[1], a[2]); }

bool corrects_angular_momentum(const SolverSpec& solver) {
  return solver.type == "pbd" ? solver.keeps_momenta : solver.desbrun.corrects() == Corrector::Inertia;
}

bool can_change_angular_momentum(const Scene& scene, const BodySpec& body) {
  const auto sews = [&](const SeamSpec& seam) { return seam.from.body == body.name || seam.to.body == body.name; };
  return corrects_angular_momentum(scene.solver) || scene.wind || scene.sleep || scene.self_collision ||
         !scene.environment.empty() || can_tear(scene) || !body.pins.empty() || !body.attachments.empty() ||
         std::ranges::any_of(scene.seams, sews);
}

BodyRotation rotation_of(const std::vector<Vec3>& x, const std::vector<Vec3>& v, const std::vector<double>& m,
                         int begin, int end) {
  BodyRotation now;
  double mass = 0;
  Vec3 centre{};
  for (int i = begin; i < end; ++i) {
    mass += m[i];
    for (int k = 0; k < 3; ++k) centre[k] += m[i] * x[i][k];
  }
  for (double& c : centre) c /= mass;
  for (int i = begin; i < end; ++i) {
    const Vec3 r = minus(x[i], centre), L = cross(r, v[i]);
    now.radius = std::max(now.radius, length(r));
    for (int k = 0; k < 3; ++k) {
      now.spin[k] += m[i] * L[k];
      now.inertia[k] += m[i] * (dot(r, r) - r[k] * r[k]);
    }
    now.inertia[3] -= m[i] * r[0] * r[1], now.inertia[4] -= m[i] * r[0] * r[2], now.inertia[5] -= m[i] * r[1] * r[2];
  }
  return now;
}

/// Returns the speed (m/s) of the outermost particle of a body that rotates with this angular momentum.
double edge_speed(const BodyRotation& body, const Vec3& spin) {
  SpinSum sum;
  std::copy_n(spin.begin(), 3, sum.L), std::copy_n(body.inertia, 6, sum.I);
  const Vector3<double> omega = angular_velocity(sum);
  return body.radius * std::sqrt(dot(omega, omega));
}

/// Returns the rotation of every body whose angular momentum nothing can change.
std::vector<std::optional<BodyRotation>> free_bodies(const Simulation& simulation) {
  const Model& model = simulation.model();
  const Scene& scene = model.scene;
  std::vector<std::optional<BodyRotation>> all(scene.bodies.size());
  std::vector<Vec3> x, v;
  std::vector<double> m;
  for (std::size_t b = 0; b < all.size(); ++b) {
    if (can_change_angular_momentum(scene, scene.bodies[b])) continue;
    if (x.empty()) {
      x = simulation.positions(), v = simulation.velocities(), m.resize(x.size());
      for (std::size_t i = 0; i < m.size(); ++i) m[model.user_index[i]] = model.w[i] > 0 ? 1 / model.w[i] : 0;
    }
    all[b] = rotation_of(x, v, m, model.render_mesh.body_begin[b], model.render_mesh.body_begin[b + 1]);
  }
  return all;
}

}  // namespace

MomentumDrift::MomentumDrift(const Simulation& simulation)
    : time_(simulation.time()), start_(free_bodies(simulation)) {}

std::vector<std::string> MomentumDrift::warnings(const Simulation& simulation) const {
  constexpr double max_angle = 0.1, max_share = 0.1;
  std::vector<std::string> lines;
  const Scene& scene = simulation.model().scene;
  const double time = simulation.time() - time_;
  if (!(time > 0)) return lines;
  const std::vector<std::optional<BodyRotation>> now = free_bodies(simulation);
  for (std::size_t b = 0; b < now.size(); ++b) {
    if (!now[b] || !start_[b]) continue;
    const BodyRotation &before = *start_[b], &after = *now[b];
    const double by = edge_speed(after, minus(after.spin, before.spin)), had = edge_speed(after, before.spin);
    if (by > max_share * had + max_angle * after.radius / time)
      lines.push_back("body '" + scene.bodies[b].name +
                      "': " + (scene.solver.type == "pbd" ? "projections" : "the filter") +
                      " changed its angular momentum from " + shown(length(before.spin), 2) + " to " +
                      shown(length(after.spin), 2) +
                      " kg m^2/s, though no torque acted on it, and the speed of its outermost particle by " +
                      shown(by, 2) + " m/s; take \"corrector\": \"inertia\" (scenes/README.md, Momenta)");
  }
  return lines;
}

}  // namespace malha
