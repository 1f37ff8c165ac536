#include "host/results/warnings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/shown.h"
#include "host/mesh/vectors.h"
#include "host/results/resolution.h"
#include "host/solver/stiffness.h"

namespace malha {

namespace {

// Near where the study's trials turn from stable to bounded but wrong. Sag is of a body at rest: one that swings
// stretches by up to three times as much, and is not warned of where it would hold at rest.
constexpr double kSag = 0.5;           // strain at rest
constexpr double kRounding = 0.05;     // of the energy of a fall through the scene's own size
constexpr double kPaperTorque = 0.01;  // k h^2 / m
constexpr double kOffTorque = 0.2;     // k h^2 / m, for each solve of a substep
constexpr double kPinnedFall = 0.4;    // g h^2 / l

double substep(const Model& model) { return model.scene.solver.dt / model.scene.solver.substeps; }

double gravity(const Model& model) {
  const Vec3& g = model.scene.gravity;
  return std::hypot(g[0], g[1], g[2]);
}

/// The body of each particle, in the solver's order.
std::vector<int> bodies_of(const Model& model) {
  std::vector<int> body(model.user_of.size());
  const std::vector<int>& begin = model.look.body_begin;
  for (std::size_t i = 0; i < body.size(); ++i)
    body[i] = static_cast<int>(std::upper_bound(begin.begin(), begin.end(), model.user_of[i]) - begin.begin()) - 1;
  return body;
}

/// Whether each particle is pinned at the start.
std::vector<bool> pinned_at_start(const Model& model) {
  std::vector<bool> pinned;
  for (const double w : model.w) pinned.push_back(w == 0);
  for (const MovedPins& pins : model.moved)
    for (const int i : pins.particles) pinned[i] = true;
  return pinned;
}

bool names(const BodySpec& body, const char* type) {
  return std::any_of(body.constraints.begin(), body.constraints.end(),
                     [type](const ConstraintSpec& spec) { return spec.type == type; });
}

double percent(double part) { return std::round(100 * part); }

/// "malha study stability" and its chart.
std::string shown_by(const char* chart) { return std::string(" (malha study stability, chart ") + chart + ")"; }

}  // namespace

Sag worst_sag(const Model& model) {
  struct Hung {
    double mass = 0, length = 0, end_mass = 0, stiffness = 0;  // of all movable particles; sums; the largest
    int paths = 0;                                             // constraints between a pinned and a movable particle
  };
  Sag worst;
  const SolverSpec& solver = model.scene.solver;
  if (solver.type != "pbd" || gravity(model) == 0) return worst;
  std::vector<Hung> hung(model.scene.bodies.size());
  const std::vector<int> body = bodies_of(model);
  const std::vector<bool> pinned = pinned_at_start(model);
  for (std::size_t i = 0; i < body.size(); ++i)
    if (!pinned[i]) hung[body[i]].mass += 1 / model.w[i];
  for (const ConstraintSet& set : model.sets) {
    if (set.type != "distance") continue;
    const double k =
        set.compliance ? 1 : stiffness_per_projection(set.stiffness, double(solver.substeps) * solver.iterations);
    for (int c = 0; c < set.count(); ++c) {
      int a = set.particles[2 * c], b = set.particles[2 * c + 1];
      if (pinned[a] == pinned[b]) continue;
      if (pinned[a]) std::swap(a, b);
      Hung& of = hung[body[a]];
      ++of.paths, of.length += distance(model.x[a], model.x[b]), of.end_mass += 1 / model.w[a];
      of.stiffness = std::max(of.stiffness, k);
    }
  }
  const double fall = gravity(model) * substep(model) * substep(model);
  for (std::size_t b = 0; b < hung.size(); ++b) {
    const Hung& of = hung[b];
    if (of.paths == 0 || of.stiffness == 0 || names(model.scene.bodies[b], "long_range")) continue;
    const double strain = 2 * of.mass / of.end_mass * fall / (of.length / of.paths * solver.iterations * of.stiffness);
    if (strain > worst.strain) worst = {strain, static_cast<int>(b), of.stiffness < 1};
  }
  return worst;
}

double rounding_energy(const Model& model) {
  const Scene& scene = model.scene;
  if (scene.solver.precision == Precision::Double || scene.solver.type != "pbd" || model.sets.empty()) return 0;
  const double h = substep(model), kick = resolution(model, model.look.points).spacing / h;
  return kick * kick / 12 * scene.duration / h / 2;  // a number rounded to a spacing is off by a root of 1/12 of it
}

double free_stiffness(const Model& model) {
  const std::vector<int> body = bodies_of(model);
  const std::vector<bool> pinned = pinned_at_start(model);
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

double pinned_fall(const Model& model) {
  const std::vector<bool> pinned = pinned_at_start(model);
  double shortest = std::numeric_limits<double>::infinity();
  for (const SpringSet& set : model.springs)
    for (std::size_t s = 0; s < set.ends.size(); ++s)
      if (const auto& [a, b] = set.ends[s]; pinned[a] != pinned[b] && set.rest[s] > 0)
        shortest = std::min(shortest, set.rest[s]);
  return gravity(model) * substep(model) * substep(model) / shortest;
}

std::vector<std::string> warnings(const Model& model) {
  std::vector<std::string> lines;
  const Scene& scene = model.scene;
  const SolverSpec& solver = scene.solver;
  if (const std::string coarse = coarse_resolution(model, model.look.points); !coarse.empty())
    lines.push_back(coarse + shown_by("distance"));
  if (const Sag sag = worst_sag(model); sag.strain > kSag)
    lines.push_back("body '" + scene.bodies[sag.body].name + "': with " + counted(solver.substeps, "substep") + " of " +
                    counted(solver.iterations, "iteration") + " what is next to its pins stretches by some " +
                    shown(percent(sag.strain)) + " % under its weight; take " +
                    (sag.soft ? "a \"compliance\" instead of its \"stiffness\"" + shown_by("stiffness")
                              : shown(std::ceil(solver.substeps * std::sqrt(sag.strain / kSag))) +
                                    " substeps or more, or \"long_range\"" + shown_by("masses")));
  Vec3 low = model.look.points.front(), high = low;
  for (const Vec3& x : model.look.points)
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
  const double fall = gravity(model) * distance(low, high);
  if (const double energy = rounding_energy(model); fall > 0 && energy > kRounding * fall)
    lines.push_back(counted(solver.substeps, "substep") + " in float: rounding adds some " +
                    shown(percent(energy / fall)) +
                    " % of the energy of a fall through the scene's size; take fewer, or \"precision\": \"double\"" +
                    shown_by("masses"));
  if (solver.type != "desbrun") return lines;
  const DesbrunSpec& spec = solver.desbrun;
  const Corrector corrector = spec.corrector.value_or(spec.refine > 0 ? Corrector::Off : Corrector::Inertia);
  const double most = corrector == Corrector::Paper ? kPaperTorque : kOffTorque * (1 + spec.refine);
  if (const double k = free_stiffness(model); corrector != Corrector::Inertia && k > most)
    lines.push_back(
        "k h^2 / m is up to " + shown(k) + " on free bodies, and above " + shown(most) + " corrector \"" +
        (corrector == Corrector::Paper ? "paper\" adds angular momentum" : "off\" takes their rotation away") +
        "; take \"corrector\": \"inertia\" or more substeps" + shown_by("torque"));
  if (const double fallen = pinned_fall(model); spec.internal_only && fallen > kPinnedFall)
    lines.push_back("\"filtered\": \"internal_only\" leaves springs next to pins some " + shown(percent(fallen)) +
                    " % too long; filter all, or take more substeps" + shown_by("weight"));
  return lines;
}

}  // namespace malha
