// SPDX-License-Identifier: Apache-2.0
#include "host/report/failure_boundaries.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host/mesh/tetrahedra.h"
#include "host/mesh/vectors.h"
#include "host/model/levels.h"
#include "host/projection/stiffness.h"

namespace malha {

namespace {

double substep(const Model& model) { return model.scene.solver.dt / model.scene.solver.substeps; }

double gravity(const Model& model) {
  const Vec3& g = model.scene.gravity;
  return std::hypot(g[0], g[1], g[2]);
}

bool has_constraint(const BodySpec& body, const char* type) {
  return std::any_of(body.constraints.begin(), body.constraints.end(),
                     [type](const ConstraintSpec& spec) { return spec.type == type; });
}

/// Returns the distance of the ends of a `distance` constraint at rest, m.
double rest_length(const Model& model, const ConstraintSet& set, int c) {
  if (!set.rest_corners.empty()) return distance(set.rest_corners[2 * c], set.rest_corners[2 * c + 1]);
  return distance(model.x[set.particles[2 * c]], model.x[set.particles[2 * c + 1]]);
}

/// Returns for each particle the length (m) of the path of fewest springs to a pinned particle; infinite if there is
/// none.
std::vector<double> distances_to_pins(const std::vector<bool>& pinned, const std::vector<SpringSet>& springs) {
  const std::size_t count = pinned.size();
  std::vector<int> begin(count + 1);
  for (const SpringSet& set : springs)
    for (const Edge& ends : set.ends) ++begin[ends[0]], ++begin[ends[1]];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::pair<int, double>> next(begin[count]);
  for (const SpringSet& set : springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s) {
      const auto& [a, b] = set.ends[s];
      next[--begin[a]] = {b, set.rest[s]}, next[--begin[b]] = {a, set.rest[s]};
    }
  std::vector<double> distance_to_pin(count, std::numeric_limits<double>::infinity());
  std::vector<int> front;
  for (std::size_t i = 0; i < count; ++i)
    if (pinned[i]) distance_to_pin[i] = 0, front.push_back(static_cast<int>(i));
  for (std::size_t k = 0; k < front.size(); ++k)
    for (int n = begin[front[k]]; n < begin[front[k] + 1]; ++n)
      if (const auto& [j, length] = next[n]; std::isinf(distance_to_pin[j]))
        distance_to_pin[j] = distance_to_pin[front[k]] + length, front.push_back(j);
  return distance_to_pin;
}

/// Returns for each body whether "auto" levels carry corrections from its pins.
std::vector<bool> bodies_with_auto_levels(const Model& model, const std::vector<int>& body) {
  SolverSpec solver = model.scene.solver;
  solver.levels = kAutoLevels;
  std::vector<double> w = model.w;
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) w[i] = 0;
  const CoarseningGraph linkage = coarsening_graph(model, w);
  std::vector<bool> result(model.scene.bodies.size(), false);
  for (int i = 0; i < model.count(); ++i)
    if (should_use_levels(linkage.parts[linkage.part[model.user_index[i]]], solver)) result[body[i]] = true;
  return result;
}

/// Returns the share of a body's sag that levels leave.
double share_left_by_levels(int levels, bool auto_levels_act) {
  if (levels == kAutoLevels) return auto_levels_act ? 0 : 1;
  return std::pow(0.25, levels);
}

/// The stiffest place of a body's material by its maps: its modulus over that of the scene, and its Poisson's ratio.
struct StiffestPlace {
  double modulus = 0, poisson_ratio = 0;
};
std::vector<StiffestPlace> stiffest_places(const Model& model) {
  std::vector<StiffestPlace> places(model.scene.bodies.size());
  for (const ConstraintSet& set : model.sets)
    for (int c = 0; set.type == "neo_hookean" && c < set.count(); ++c) {
      StiffestPlace& of = places[body_of(model, model.user_index[set.particles[std::size_t(c) * set.arity]])];
      of.modulus = std::max(of.modulus, 1 / set.softness_of(c));
      of.poisson_ratio = std::max(of.poisson_ratio, set.parameters.empty() ? set.parameter : set.parameters[c]);
    }
  return places;
}

/// Calls f(body, Poisson's ratio, cells that its shear wave travels in a substep over the root of the iterations).
template <class F>
void for_each_wave(const Model& model, F&& f) {
  const std::vector<StiffestPlace> stiffest = stiffest_places(model);
  for (std::size_t b = 0; b < model.tetrahedra.size(); ++b) {
    const BodySpec& body = model.scene.bodies[b];
    for (const ConstraintSpec& spec : body.constraints) {
      if (spec.type != "neo_hookean" || model.tetrahedra[b].empty()) continue;
      double space = 0;
      for (const Tetrahedron& t : model.tetrahedra[b]) space += volume(model.at_rest(), t);
      const double density = body.density ? *body.density : body.mass.value_or(0) / space;
      const bool has_map = spec.map || spec.parameter_map;
      const double modulus = spec.young_modulus.value() * (has_map ? stiffest[b].modulus : 1);
      const double speed = std::sqrt(modulus / density / 3 / model.scene.solver.iterations);
      const double cell = std::cbrt(6 * space / static_cast<double>(model.tetrahedra[b].size()));
      f(b, has_map ? stiffest[b].poisson_ratio : spec.parameter, speed * substep(model) / cell);
    }
  }
}

}  // namespace

PinStrain worst_pin_strain(const Model& model) {
  struct SuspendedBody {
    double mass = 0, end_mass = 0,
           stiffness = 0;  // of all movable particles; of those next to pins; the largest stiffness a projection
    double length = std::numeric_limits<double>::infinity();  // the shortest constraint next to pins, m
    bool attached = false;                                    // hangs by springs to attachments
    int paths = 0;                                            // constraints between a pinned and a movable particle
  };
  PinStrain worst;
  const SolverSpec& solver = model.scene.solver;
  if (solver.type != "pbd" || gravity(model) == 0) return worst;
  std::vector<SuspendedBody> suspended(model.scene.bodies.size());
  const std::vector<int> body = bodies_of(model);
  const std::vector<bool> pinned = fixed_at_start(model, true);
  for (std::size_t i = 0; i < body.size(); ++i)
    if (!pinned[i]) suspended[body[i]].mass += 1 / model.w[i];
  for (const ConstraintSet& set : model.sets) {
    if (set.type != "distance") continue;
    const double k = set.compliance ? 1 : stiffness_per_projection(set.stiffness, solver, kSweepsPerIteration);
    for (int c = 0; c < set.count(); ++c) {
      int a = set.particles[2 * c], b = set.particles[2 * c + 1];
      if (pinned[a] == pinned[b]) continue;
      if (pinned[a]) std::swap(a, b);
      SuspendedBody& of = suspended[body[a]];
      const double length = rest_length(model, set, c);
      ++of.paths, of.length = length > 0 ? std::min(of.length, length) : of.length, of.end_mass += 1 / model.w[a];
      of.stiffness = std::max(of.stiffness, k);
    }
  }
  for (const AttachmentSet& set : model.attached)
    for (const int i : set.particles) suspended[body[i]].attached = suspended[body[i]].attached || model.w[i] > 0;
  const double fall = gravity(model) * substep(model) * substep(model);
  const std::vector<int>& faces = model.render_mesh.face_begin;
  std::vector<bool> auto_levels_act;
  for (std::size_t b = 0; b < suspended.size(); ++b) {
    const SuspendedBody& of = suspended[b];
    if (of.paths == 0 || of.stiffness == 0 || has_constraint(model.scene.bodies[b], "long_range")) continue;
    if (auto_levels_act.empty()) auto_levels_act = bodies_with_auto_levels(model, body);
    const double left = of.attached ? 1 : share_left_by_levels(solver.levels, auto_levels_act[b]);
    const double strain = left * 2 * of.mass / of.end_mass * fall / (of.length * solver.iterations * of.stiffness);
    const double swinging = strain * std::max(5.0, std::sqrt(of.paths / 2.0)) * (of.attached ? 7 : 1);
    const bool of_faces = faces[b + 1] != faces[b];
    if (swinging > worst.swinging)
      worst = {strain, swinging, of.stiffness, static_cast<int>(b), of_faces, auto_levels_act[b] && !of.attached};
  }
  return worst;
}

ShearWave fastest_shear_wave(const Model& model) {
  ShearWave fastest;
  for_each_wave(model, [&](std::size_t body, double, double cells) {
    if (cells > fastest.cells) fastest = {cells, static_cast<int>(body)};
  });
  return fastest;
}

VolumeSoftening worst_volume_softening(const Model& model) {
  VolumeSoftening most;
  for_each_wave(model, [&](std::size_t body, double nu, double cells) {
    if (std::holds_alternative<TetBoxShape>(model.scene.bodies[body].shape)) return;
    const double s = cells * cells * 2 * nu / (1 - 2 * nu);
    if (const double share = s / (1 + s / 4); share > most.share) most = {share, nu, static_cast<int>(body)};
  });
  return most;
}

double max_free_stiffness(const Model& model) {
  const std::vector<int> body = bodies_of(model);
  const std::vector<bool> pinned = fixed_at_start(model, true);
  std::vector<bool> held(model.scene.bodies.size());
  for (std::size_t i = 0; i < body.size(); ++i)
    if (pinned[i]) held[body[i]] = true;
  double most = 0;
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s) {
      const auto& [a, b] = set.ends[s];
      if (!held[body[a]]) most = std::max(most, set.stiffness[s] * (model.w[a] + model.w[b]) / 2);
    }
  return most * substep(model) * substep(model);
}

double pinned_spring_strain(const Model& model) {
  const std::vector<bool> pinned = fixed_at_start(model, true);
  double shortest = std::numeric_limits<double>::infinity();
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s)
      if (const auto& [a, b] = set.ends[s]; pinned[a] != pinned[b] && set.rest[s] > 0)
        shortest = std::min(shortest, set.rest[s]);
  return gravity(model) * substep(model) * substep(model) / shortest;
}

FilterDamping worst_filter_damping(const Model& model) {
  struct SuspendedBody {
    double mass = 0, length = 0, inertia = 0;  // sums of m, m d, m d^2
    double turned = 0, held = 0;               // sums of k (d_i - d_j)^2, and of k at pins
  };
  FilterDamping worst;
  if (gravity(model) == 0 || model.springs.empty()) return worst;
  const std::vector<int> body = bodies_of(model);
  const std::vector<bool> pinned = fixed_at_start(model, true);
  const std::vector<double> distance_to_pin = distances_to_pins(pinned, model.springs);
  std::vector<SuspendedBody> suspended(model.scene.bodies.size());
  for (std::size_t i = 0; i < body.size(); ++i) {
    if (pinned[i] || std::isinf(distance_to_pin[i])) continue;
    SuspendedBody& of = suspended[body[i]];
    const double m = 1 / model.w[i], d = distance_to_pin[i];
    of.mass += m, of.length += m * d, of.inertia += m * d * d;
  }
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s) {
      const auto& [a, b] = set.ends[s];
      if (std::isinf(distance_to_pin[a]) || std::isinf(distance_to_pin[b])) continue;
      SuspendedBody& of = suspended[body[a]];
      of.turned +=
          set.stiffness[s] * (distance_to_pin[a] - distance_to_pin[b]) * (distance_to_pin[a] - distance_to_pin[b]);
      if (pinned[a] != pinned[b]) of.held += set.stiffness[s];
    }
  const double h = substep(model);
  for (std::size_t b = 0; b < suspended.size(); ++b) {
    const SuspendedBody& of = suspended[b];
    if (of.inertia == 0) continue;
    const double back = h * h * of.held / of.mass, decay = h * of.turned / of.inertia, kept = back / (1 + back);
    const double damping = decay / (2 * std::sqrt(gravity(model) * of.length / of.inertia)) *
                           std::pow(kept, model.scene.solver.desbrun.refinement_iterations);
    if (damping > worst.damping) worst = {damping, static_cast<int>(b), kept};
  }
  return worst;
}

}  // namespace malha
