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

constexpr double kResolved = 0.1;  // of a compliance: more is too stiff for the substeps
constexpr double kForEver = std::numeric_limits<double>::infinity();

void push(Vec3& sum, const Vector3<double>& force) { sum[0] += force.x, sum[1] += force.y, sum[2] += force.z; }

/// An energy is so much times C^2 / 2 over the compliance: neo_hookean's C has no volume in it.
template <class Kind>
double energy_per_C2(const double* rest) {
  if constexpr (requires { Kind::volume(rest); }) return Kind::volume(rest);
  return 1;
}

/// -C grad C / compliance of one constraint, added to the forces on its particles.
template <class Kind>
void pull(const std::vector<Vec3>& x, const int* particles, const double* rest, double stiffness,
          std::vector<Vec3>& forces) {
  Vector3<double> q[Kind::particles], grad[Kind::particles];
  corners<Kind>(x.data(), particles, q);
  double scale;
  const double C = Kind::evaluate(q, rest, true, grad, scale);  // both times scale
  if (!(scale > 0) || (Kind::inequality && C >= 0)) return;
  for (int j = 0; j < Kind::particles; ++j) push(forces[particles[j]], grad[j] * (-stiffness * C / (scale * scale)));
}

/// sum w |grad C|^2 h^2 at rest, m/N: what a compliance is compared with. 0 of Desbrun's method, which is implicit.
template <class Kind>
double stiffness_in_substeps(const Model& model, const int* particles, const double* rest) {
  if (model.scene.solver.type != "pbd") return 0;
  Vector3<double> q[Kind::particles], grad[Kind::particles];
  corners<Kind>(model.x.data(), particles, q);
  double scale, sum = 0;
  Kind::evaluate(q, rest, true, grad, scale);
  for (int j = 0; j < Kind::particles; ++j) sum += model.w[particles[j]] * dot(grad[j], grad[j]);
  const double h = model.scene.solver.dt / model.scene.solver.substeps;
  return scale > 0 ? sum * h * h * energy_per_C2<Kind>(rest) / (scale * scale) : 0;
}

/// Until when each particle is held, s; 0: it never is.
std::vector<double> held_until(const Model& model) {
  std::vector<double> release_time(model.x.size(), 0);
  for (std::size_t i = 0; i < release_time.size(); ++i)
    if (!(model.w[i] > 0)) release_time[model.user_index[i]] = kForEver;
  for (const MovedPins& moved : model.moved)
    for (const int i : moved.particles) release_time[model.user_index[i]] = moved.release_time.value_or(kForEver);
  return release_time;
}

bool at_a_pin(const std::vector<int>& user, const std::vector<double>& release_time) {
  return std::any_of(user.begin(), user.end(), [&](int i) { return release_time[i] > 0; });
}

}  // namespace

PinForces::PinForces(const Model& model) : particles_(model.x.size()) {
  const std::vector<double> release_time = held_until(model);
  for (const auto* sets : {&model.sets, &model.stencils})
    for (const ConstraintSet& set : *sets) add(model, set, release_time);
  for (const SpringSet& set : model.springs) add(model, set, release_time);
  for (const PressureSet& set : model.pressures) add(model, set, release_time);
  std::set<int> pulled;
  for (const Set& set : sets_) pulled.insert(set.particles.begin(), set.particles.end());
  for (const Pressed& one : pressed_) pulled.insert(one.shell.particles.begin(), one.shell.particles.end());
  for (const int i : pulled)
    if (release_time[i] > 0) pins_.push_back({i, release_time[i]});
}

void PinForces::add(const Model& model, const ConstraintSet& set, const std::vector<double>& release_time) {
  Set own{set.type, {}, {}, {}};
  with_kind(set.type, [&]<class Kind>(Kind) {
    for (int c = 0; c < set.count(); ++c) {
      const int* const particles = &set.particles[std::size_t(c) * Kind::particles];
      const auto user = in_user_numbers(model, particles, Kind::particles);
      if (!at_a_pin(user, release_time)) continue;
      double rest[Kind::numbers];
      rest_values<Kind>(model.x.data(), particles, set.parameter, rest);
      if (!(set.alpha(c) > 0) || stiffness_in_substeps<Kind>(model, particles, rest) > kResolved * set.alpha(c)) {
        ++left_out_;
        continue;
      }
      own.particles.insert(own.particles.end(), user.begin(), user.end());
      own.rest.insert(own.rest.end(), rest, rest + Kind::numbers);
      own.stiffness.push_back(energy_per_C2<Kind>(rest) / set.alpha(c));
    }
  });
  if (!own.stiffness.empty()) sets_.push_back(std::move(own));
}

void PinForces::add(const Model& model, const SpringSet& set, const std::vector<double>& release_time) {
  Set own{Distance::name, {}, {}, {}};
  for (std::size_t s = 0; s < set.ends.size(); ++s) {
    const std::vector<int> user = in_user_numbers(model, set.ends[s].data(), 2);
    if (!at_a_pin(user, release_time)) continue;
    own.particles.insert(own.particles.end(), user.begin(), user.end());
    own.rest.push_back(set.rest[s]), own.stiffness.push_back(set.stiffness[s]);
  }
  if (!own.stiffness.empty()) sets_.push_back(std::move(own));
}

void PinForces::add(const Model& model, const PressureSet& set, const std::vector<double>& release_time) {
  Shell shell(model, set);
  if (!at_a_pin(shell.particles, release_time)) return;
  if (!(set.compliance.value_or(0) > 0)) return void(++left_out_);
  pressed_.push_back({std::move(shell), 1 / *set.compliance});
}

std::vector<PinForce> PinForces::operator()(const std::vector<Vec3>& x, double time) const {
  require_particles(x.size(), particles_);
  std::vector<Vec3> forces(particles_, Vec3{0, 0, 0});
  for (const Set& set : sets_)
    with_kind(set.type, [&]<class Kind>(Kind) {
      for (std::size_t c = 0; c < set.stiffness.size(); ++c)
        pull<Kind>(x, &set.particles[c * Kind::particles], &set.rest[c * Kind::numbers], set.stiffness[c], forces);
    });
  std::vector<Vector3<double>> gradient;
  for (const auto& [shell, stiffness] : pressed_) {
    const double C = shell.evaluate(x, gradient);
    for (std::size_t i = 0; i < gradient.size(); ++i) push(forces[shell.particles[i]], gradient[i] * (-stiffness * C));
  }
  std::vector<PinForce> all;
  for (const Pin& pin : pins_)
    if (time < pin.release_time) all.push_back({pin.particle, forces[pin.particle]});
  return all;
}

}  // namespace malha
