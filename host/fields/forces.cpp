// SPDX-License-Identifier: Apache-2.0
#include "host/fields/forces.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "kernels/constraints/constraint_registry.h"
#include "kernels/projection/rest.h"

namespace malha {

namespace {

constexpr double kResolved =
    0.1;  // ratio of stiffness in substeps to compliance, above which a constraint is too stiff
constexpr double kNever = std::numeric_limits<double>::infinity();

void accumulate(Vec3& sum, const Vector3<double>& force) { sum[0] += force.x, sum[1] += force.y, sum[2] += force.z; }

/// Returns the factor of C^2 / (2 compliance) in the energy: the volume for neo_hookean, whose C does not contain it,
/// otherwise 1.
template <class Kind>
double energy_per_C2(const double* rest) {
  if constexpr (requires { Kind::volume(rest); }) return Kind::volume(rest);
  return 1;
}

/// Adds -C grad C / compliance of one constraint to the forces on its particles.
template <class Kind>
void add_constraint_force(const std::vector<Vec3>& x, const int* particles, const double* rest, double stiffness,
                          std::vector<Vec3>& forces) {
  Vector3<double> q[Kind::particles], grad[Kind::particles];
  corners<Kind>(x.data(), particles, q);
  double scale;
  const double C = Kind::evaluate(q, rest, true, grad, scale);  // both times scale
  if (!(scale > 0) || (Kind::inequality && C >= 0)) return;
  for (int j = 0; j < Kind::particles; ++j)
    accumulate(forces[particles[j]], grad[j] * (-stiffness * C / (scale * scale)));
}

/// Returns sum w |grad C|^2 h^2 at rest, m/N, to be compared with a compliance; 0 by Desbrun's method, which is
/// implicit.
template <class Kind>
double stiffness_in_substeps(const Model& model, const ConstraintSet& set, int c, const double* rest) {
  if (model.scene.solver.type != "pbd") return 0;
  Vector3<double> q[Kind::particles], grad[Kind::particles];
  rest_positions(model, set).corners<Kind>(c, q);
  double scale, sum = 0;
  Kind::evaluate(q, rest, true, grad, scale);
  const int* const particles = &set.particles[std::size_t(c) * Kind::particles];
  for (int j = 0; j < Kind::particles; ++j) sum += model.w[particles[j]] * dot(grad[j], grad[j]);
  const double h = model.scene.solver.dt / model.scene.solver.substeps;
  return scale > 0 ? sum * h * h * energy_per_C2<Kind>(rest) / (scale * scale) : 0;
}

/// Returns the time (s) at which each particle is released; infinity for permanent pins, 0 for particles that are not
/// pinned.
std::vector<double> release_times(const Model& model) {
  std::vector<double> release_time(model.x.size(), 0);
  for (std::size_t i = 0; i < release_time.size(); ++i)
    if (!(model.w[i] > 0)) release_time[model.user_index[i]] = kNever;
  for (const MovedPins& moved : model.moved)
    for (const int i : moved.particles) release_time[model.user_index[i]] = moved.release_time.value_or(kNever);
  return release_time;
}

bool has_pin(const std::vector<int>& user, const std::vector<double>& release_time) {
  return std::any_of(user.begin(), user.end(), [&](int i) { return release_time[i] > 0; });
}

}  // namespace

PinForces::PinForces(const Model& model) : particles_(model.x.size()) {
  const std::vector<double> release_time = release_times(model);
  for (const auto* sets : {&model.sets, &model.stencils})
    for (const ConstraintSet& set : *sets) add(model, set, release_time);
  for (const SpringSet& set : model.springs) add(model, set, release_time);
  for (const PressureSet& set : model.pressures) add(model, set, release_time);
  std::set<int> pulled;
  for (const Set& set : sets_) pulled.insert(set.particles.begin(), set.particles.end());
  for (const PressureForce& one : pressures_) pulled.insert(one.surface.particles.begin(), one.surface.particles.end());
  for (const int i : pulled)
    if (release_time[i] > 0) pins_.push_back({i, release_time[i]});
}

void PinForces::add(const Model& model, const ConstraintSet& set, const std::vector<double>& release_time) {
  Set own{set.type, {}, {}, {}};
  with_kind(set.type, [&]<class Kind>(Kind) {
    for (int c = 0; c < set.count(); ++c) {
      const int* const particles = &set.particles[std::size_t(c) * Kind::particles];
      const auto user = to_user_indices(model, particles, Kind::particles);
      if (!has_pin(user, release_time)) continue;
      double rest[Kind::rest_values];
      closed_rest_values<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c), set.per_closing, rest);
      if (!(set.alpha(c) > 0) || stiffness_in_substeps<Kind>(model, set, c, rest) > kResolved * set.alpha(c)) {
        ++left_out_;
        continue;
      }
      own.particles.insert(own.particles.end(), user.begin(), user.end());
      own.rest.insert(own.rest.end(), rest, rest + Kind::rest_values);
      own.stiffness.push_back(energy_per_C2<Kind>(rest) / set.alpha(c));
    }
  });
  if (!own.stiffness.empty()) sets_.push_back(std::move(own));
}

void PinForces::add(const Model& model, const SpringSet& set, const std::vector<double>& release_time) {
  Set own{Distance::name, {}, {}, {}};
  for (std::size_t s = 0; s < set.ends.size(); ++s) {
    const std::vector<int> user = to_user_indices(model, set.ends[s].data(), 2);
    if (!has_pin(user, release_time)) continue;
    own.particles.insert(own.particles.end(), user.begin(), user.end());
    own.rest.push_back(set.rest[s]), own.stiffness.push_back(set.stiffness[s]);
  }
  if (!own.stiffness.empty()) sets_.push_back(std::move(own));
}

void PinForces::add(const Model& model, const PressureSet& set, const std::vector<double>& release_time) {
  ClosedSurface surface(model, set);
  if (!has_pin(surface.particles, release_time)) return;
  if (!(set.compliance.value_or(0) > 0)) return void(++left_out_);
  pressures_.push_back({std::move(surface), 1 / *set.compliance});
}

std::vector<PinForce> PinForces::operator()(const std::vector<Vec3>& x, double time) const {
  require_particles(x.size(), particles_);
  std::vector<Vec3> forces(particles_, Vec3{0, 0, 0});
  for (const Set& set : sets_)
    with_kind(set.type, [&]<class Kind>(Kind) {
      for (std::size_t c = 0; c < set.stiffness.size(); ++c)
        add_constraint_force<Kind>(x, &set.particles[c * Kind::particles], &set.rest[c * Kind::rest_values],
                                   set.stiffness[c], forces);
    });
  std::vector<Vector3<double>> gradient;
  for (const auto& [surface, stiffness] : pressures_) {
    const double C = surface.evaluate(x, gradient);
    for (std::size_t i = 0; i < gradient.size(); ++i)
      accumulate(forces[surface.particles[i]], gradient[i] * (-stiffness * C));
  }
  std::vector<PinForce> all;
  for (const Pin& pin : pins_)
    if (time < pin.release_time) all.push_back({pin.particle, forces[pin.particle]});
  return all;
}

}  // namespace malha
