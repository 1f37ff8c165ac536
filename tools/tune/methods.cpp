// SPDX-License-Identifier: Apache-2.0
#include "tools/tune/methods.h"

#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "malha/text.h"

namespace malha::tuning {

namespace {

bool is_bending(const std::string& type) { return type == "bending" || type == "isometric_bending"; }

/// Returns whether Desbrun's method has constraints to project, for which alone it has iterations.
bool projects(const Scene& scene) {
  if (!scene.environment.empty() || scene.self_collision) return true;
  for (const BodySpec& body : scene.bodies) {
    if (!body.attachments.empty()) return true;
    for (const ConstraintSpec& spec : body.constraints)
      if (spec.type != "distance" && !is_bending(spec.type)) return true;
  }
  return false;
}

bool has_springs(const Scene& scene) {
  for (const BodySpec& body : scene.bodies)
    for (const ConstraintSpec& spec : body.constraints)
      if (spec.type == "distance" || is_bending(spec.type)) return true;
  return false;
}

void add_pbd(std::vector<Scene>& methods, Scene scene) {
  scene.solver.precision = Precision::Float;
  for (const int iterations : {1, 2, 4, 8}) {
    scene.solver.iterations = iterations;
    methods.push_back(scene);
  }
}

void add_desbrun(std::vector<Scene>& methods, Scene scene) {
  scene.solver.precision = Precision::Float;
  scene.solver.desbrun.storage.reset(), scene.solver.desbrun.filter = FilterKind::Auto;
  for (const int refine : {0, 1, 4, 16})
    for (const int most : projects(scene) ? std::vector<int>{1, 4, 10} : std::vector<int>{1}) {
      scene.solver.iterations = most, scene.solver.desbrun.refinement_iterations = refine;
      methods.push_back(scene);
    }
}

bool has_compliance(const Scene& scene) {
  for (const BodySpec& body : scene.bodies)
    for (const ConstraintSpec& spec : body.constraints)
      if (spec.compliance || spec.rigidity || spec.young_modulus) return true;
  return false;
}

/// Returns whether levels act on any body with the fewest sweeps.
bool can_use_levels(Scene scene) {
  if (scene.solver.type != "pbd" || scene.solver.levels == 0) return false;
  scene.solver.substeps = scene.solver.iterations = 1;
  return !Simulation(scene, {.threads = 1}).solver().facts().levels.empty();
}

/// Returns whether bending may be filtered, or projected.
bool can_filter_bending(Scene scene) {
  scene.solver.bending = BendingMethod::Filtered;
  return !Simulation(scene, {.threads = 1}).model().stencils.empty();
}

/// Adds PBD without levels, and with those of the scene, or with automatic levels if it has none.
void add_pbd_and_levels(std::vector<Scene>& methods, const Scene& scene) {
  Scene with = scene, without = scene;
  if (with.solver.levels == 0) with.solver.levels = kAutoLevels;
  without.solver.levels = 0;
  add_pbd(methods, without);
  if (can_use_levels(with)) add_pbd(methods, with);
}

}  // namespace

std::string method_name(const Scene& scene) {
  const SolverSpec& solver = scene.solver;
  const std::string precision = solver.precision == Precision::Double ? ", double" : ", float";
  const std::string iterations = ", " + counted(solver.iterations, "iteration");
  if (solver.type == "pbd") {
    const bool filters = solver.bending == BendingMethod::Filtered && can_filter_bending(scene);
    return (has_compliance(scene) ? "XPBD" : "PBD") + iterations + (can_use_levels(scene) ? ", levels" : "") +
           (filters ? ", filtered bending" : "") + precision;
  }
  const FilterKind filter = solver.desbrun.filter;
  const std::string refine = solver.desbrun.refinement_iterations > 0
                                 ? ", refine " + std::to_string(solver.desbrun.refinement_iterations)
                                 : "";
  return std::string("Desbrun, ") +
         (filter == FilterKind::Dense    ? "dense"
          : filter == FilterKind::Sparse ? "sparse"
                                         : "auto") +
         refine + (projects(scene) ? iterations : "") + precision;
}

Scene to_pbd(const Scene& scene, std::string& why) {
  Scene other = scene;
  other.solver.type = "pbd", other.solver.desbrun = {};
  if (scene.solver.type == "pbd") return other;
  for (BodySpec& body : other.bodies)
    for (ConstraintSpec& spec : body.constraints) {
      if (spec.rigidity || spec.compliance.value_or(0) > 0) continue;
      const double stiffness = scene.solver.desbrun.spring_constant * (spec.compliance ? 1 : spec.stiffness);
      if (spec.type == "distance" && stiffness > 0) spec.compliance = 1 / stiffness;
      if (is_bending(spec.type) && stiffness > 0)
        why = "the hinges of '" + body.name + "' (" + spec.type + ") have no one compliance, but each one its own";
    }
  return other;
}

std::vector<Scene> tune_methods(const Scene& scene, std::vector<std::string>& left_out) {
  std::vector<Scene> methods;
  std::string why;
  const Scene pbd = to_pbd(scene, why);
  if (why.empty() && can_filter_bending(pbd))
    for (const BendingMethod bending : {BendingMethod::Projected, BendingMethod::Filtered}) {
      Scene by_bending = pbd;
      by_bending.solver.bending = bending;
      add_pbd_and_levels(methods, by_bending);
    }
  else if (why.empty())
    add_pbd_and_levels(methods, pbd);
  else
    left_out.push_back("PBD or XPBD: " + why);
  if (!has_springs(scene)) {
    left_out.push_back("Desbrun: the scene has no springs");
    return methods;
  }
  Scene desbrun = scene;
  desbrun.solver.type = "desbrun";
  try {
    Simulation(desbrun, {.threads = 1});
    add_desbrun(methods, desbrun);
  } catch (const InputError& error) {
    left_out.push_back(std::string("Desbrun: ") + error.what());
  }
  return methods;
}

}  // namespace malha::tuning
