// SPDX-License-Identifier: Apache-2.0
#include "host/fields/fields.h"

#include <algorithm>
#include <cmath>

#include "kernels/constraints/constraint_registry.h"
#include "kernels/parallel/compute.h"
#include "kernels/projection/rest.h"

namespace malha {

namespace {

void raise_to(float& to, double value) { to = std::max(to, static_cast<float>(value)); }

/// Share of C^2 at rest below which the energy U of a material is rounding error; it corresponds to strains of 3e-7.
constexpr double kRounding = 1e-13;

/// Returns |C| / |grad C| of one constraint, m.
template <class Kind>
double residual(const Vec3* x, const int* particles, const double* rest, double rest_C2) {
  Vector3<double> q[Kind::particles], grad[Kind::particles];
  corners<Kind>(x, particles, q);
  double scale, sum = 0;
  const double C = Kind::evaluate(q, rest, true, grad, scale);  // both times scale
  for (const auto& g : grad) sum += dot(g, g);
  if (Kind::inequality && C >= 0) return 0;
  if (!(sum > tiny<double>())) {  // coincident particles have no direction, but the same residual in each
    constexpr bool length = Kind::particles == 2 && !Kind::inequality;
    return length && !(scale > 0) ? rest[0] / std::sqrt(2.0) : 0;
  }
  const double way = std::abs(C) / std::sqrt(sum);
  if constexpr (multipliers<Kind>() > 1)  // U ~ C^2 - ground
    return C * C - rest_C2 > kRounding * rest_C2 ? way * (1 - rest_C2 / (C * C)) : 0;
  return way;
}

}  // namespace

Strains::Strains(const Model& model) : particles_(model.x.size()) {
  const auto add = [&](int i, int j, double rest) {
    const int a = model.user_index[i], b = model.user_index[j];
    lengths_.push_back({std::min(a, b), std::max(a, b), rest, rest > 0 ? 1 / rest : 0});
  };
  for (const ConstraintSet& set : model.sets)
    if (set.type == Distance::name)
      for (int c = 0; c < set.count(); ++c) {
        const int* const ends = &set.particles[std::size_t(c) * 2];
        add(ends[0], ends[1], rest_value<Distance>(rest_positions(model, set), c, material_of<Distance>(set, c)));
      }
  for (const SpringSet& set : model.springs)
    if (set.type == Distance::name)
      for (std::size_t s = 0; s < set.ends.size(); ++s) add(set.ends[s][0], set.ends[s][1], set.rest[s]);
  // Sorted, so that neighbours in memory are read together.
  std::sort(lengths_.begin(), lengths_.end(),
            [](const Length& one, const Length& two) { return one.a != two.a ? one.a < two.a : one.b < two.b; });
  lengths_.shrink_to_fit();
}

std::vector<float> Strains::operator()(const std::vector<Vec3>& x) const {
  require_particles(x.size(), particles_);
  std::vector<float> most(particles_, 0.0f);
  for (const Length& of : lengths_) {
    const double strain = std::abs(norm(vector(x[of.a]) - vector(x[of.b])) - of.rest) * of.per_rest;
    raise_to(most[of.a], strain), raise_to(most[of.b], strain);
  }
  return most;
}

Residuals::Residuals(const Model& model, int threads) : particles_(model.x.size()), threads_(threads) {
  for (const auto* sets : {&model.sets, &model.stencils})
    for (const ConstraintSet& set : *sets) add(model, set);
  for (const SpringSet& set : model.springs) {
    Set& own = sets_.emplace_back(Set{set.type, 2, {}, set.rest, {}});
    for (const Edge& ends : set.ends)
      for (const int i : ends) own.particles.push_back(model.user_index[i]);
  }
  for (const PressureSet& set : model.pressures) pressures_.emplace_back(model, set);
}

void Residuals::add(const Model& model, const ConstraintSet& set) {
  Set& own = sets_.emplace_back(
      Set{set.type, set.arity, to_user_indices(model, set.particles.data(), set.particles.size()), {}, {}});
  with_kind(set.type, [&]<class Kind>(Kind) {
    own.rest.reserve(std::size_t(set.count()) * Kind::rest_values);
    for (int c = 0; c < set.count(); ++c) {
      double rest[Kind::rest_values];
      closed_rest_values<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c), set.per_closing, rest);
      own.rest.insert(own.rest.end(), rest, rest + Kind::rest_values);
      if constexpr (multipliers<Kind>() > 1) {
        Vector3<double> q[Kind::particles], grad[Kind::particles];
        rest_positions(model, set).corners<Kind>(c, q);
        double scale;
        const double C = Kind::evaluate(q, rest, true, grad, scale);
        own.rest_C2.push_back(C * C);
      }
    }
  });
}

std::vector<float> Residuals::operator()(const std::vector<Vec3>& x) const {
  require_particles(x.size(), particles_);
  std::vector<float> most(particles_, 0.0f);
  std::vector<double> residuals;
  for (const Set& set : sets_) {
    residuals.assign(set.particles.size() / set.arity, 0);
    with_kind(set.type, [&]<class Kind>(Kind) {
      const double* const rest_C2 = set.rest_C2.empty() ? nullptr : set.rest_C2.data();
      const auto measure = [&](int c) {
        residuals[c] = residual<Kind>(x.data(), &set.particles[std::size_t(c) * Kind::particles],
                                      &set.rest[std::size_t(c) * Kind::rest_values], rest_C2 ? rest_C2[c] : 0);
      };
      parallel_for(OpenMP{threads_}, static_cast<int>(residuals.size()), measure);
    });
    for (std::size_t k = 0; k < set.particles.size(); ++k)
      raise_to(most[set.particles[k]], residuals[k / static_cast<std::size_t>(set.arity)]);
  }
  std::vector<Vector3<double>> grad;
  for (const ClosedSurface& surface : pressures_) {
    const double C = surface.evaluate(x, grad);
    double sum = 0;
    for (const auto& g : grad) sum += dot(g, g);
    const double way = sum > tiny<double>() ? std::abs(C) / std::sqrt(sum) : 0;
    for (const int i : surface.particles) raise_to(most[i], way);
  }
  return most;
}

}  // namespace malha
