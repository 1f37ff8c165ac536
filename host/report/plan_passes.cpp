// SPDX-License-Identifier: Apache-2.0
#include "host/report/plan_passes.h"

#include <algorithm>
#include <functional>

#include "host/model/tear.h"
#include "host/patch/patch_plan.h"

namespace malha {

namespace {

/// Returns the launches of restrictions to all levels in a step, and of the sweeps over them.
std::size_t launches_of_levels(const Model& model, const SolverStats& facts, const StepPlan& plan) {
  if (facts.level_layouts == 0) return 0;
  const int substeps = model.scene.solver.substeps, every = facts.levels_interval;
  const std::size_t uses = (substeps + every - 1) / every;
  const std::size_t origins = facts.level_layouts;  // passes that set the origin of a step's positions
  if (facts.levels.empty()) return origins;
  std::size_t each =
      2 * (facts.levels.size() -
           1);  // for the coarser levels: means, and the sums of means whose parts lie in several patches
  for (const LevelStats& level : facts.levels) each += sweep_order(level.patches.colours).size();
  // For the finest level: in later substeps of a step the patch solves compute the means, and where they predict they
  // prolongate, too.
  return origins + uses * each + uses + (plan.solves == PatchSolves::ByStep ? 1 : uses) + (plan.fuses() ? 0 : uses);
}

/// Lists the launches of the passes that filter forces.
void list_filter_passes(const Model& model, const SolverStats& facts,
                        const std::function<void(const char*, std::size_t)>& line) {
  if (!facts.filter) return;
  const std::size_t substeps = model.scene.solver.substeps, refine = model.scene.solver.desbrun.refinement_iterations;
  line("forces", facts.force_launches * substeps * (1 + refine));
  line("filter", substeps * (1 + refine) * facts.filter->launches);
  line("momentum_correction", substeps * facts.free_bodies * (3 * refine + (facts.corrects ? 5 : 3)));
}

}  // namespace

std::size_t pinned_at_start(const Model& model) {
  std::size_t pinned = std::count(model.w.begin(), model.w.end(), 0.0);
  for (const MovedPins& pins : model.moved) pinned += pins.release_time ? pins.particles.size() : 0;
  return pinned;
}

std::vector<StepPass> step_passes(const Model& model, const Solver& of_scene) {
  std::vector<StepPass> all;
  const SolverStats& facts = of_scene.facts();
  const StepPlan& plan = of_scene.step_plan();
  const SolverSpec& solver = model.scene.solver;
  const std::size_t substeps = solver.substeps, iterations = substeps * solver.iterations;
  const auto line = [&all](const std::string& pass, std::size_t launches) {
    if (launches == 0) return;
    const auto same = std::find_if(all.begin(), all.end(), [&](const StepPass& had) { return had.name == pass; });
    if (same != all.end())  // Desbrun's method has two corrections
      same->launches += launches;
    else
      all.push_back({pass, launches});
  };
  const std::size_t visits = iterations * sweep_order(facts.patches.colours).size();
  const std::size_t obstacles = model.environment.size();
  std::size_t moving = 0;
  for (const MovedPins& pins : model.moved)
    moving += pins.target.moves() ? 2 : 0;  // one for their positions, one for their velocities
  line("pins", substeps * moving);
  line("damping", model.damped.empty() ? 0 : 4 * substeps);
  line("air", facts.air_particles > 0 ? 2 * substeps : 0);
  list_filter_passes(model, facts, line);
  // Momenta are measured before and after the fused patch solves, or each iteration's projections, and then restored.
  const bool alone = plan.solves_alone != PatchSolves::InIterations;
  const std::size_t measured = plan.solves_alone == PatchSolves::ByStep ? 1 : alone ? substeps : iterations;
  line("momentum_correction", model.free.empty() ? 0 : 4 * measured + (alone ? 2 : 4));
  const bool drags = model.scene.wind && model.scene.wind->drag > 0;
  const bool twice =
      model.scene.wind && facts.filter && !solver.desbrun.filter_external_forces;  // another prediction after the wind
  line("prediction", substeps * ((drags ? 1 : 0) + (plan.fuses() ? 0 : 1) + (twice ? 1 : 0)));
  line("levels", launches_of_levels(model, facts, plan));
  // Contacts are detected before the iterations and tunnelling is clamped after them, each after a broad phase. There
  // are none without an environment. Contact-free steps compute the clearance to each object, and to all.
  line("collision", (obstacles > 0 ? substeps * (5 * obstacles + 2) : 0) + (plan.skips_contacts ? obstacles + 1 : 0));
  line("fused_solve", plan.fuses() ? visits : 0);
  line("projection", plan.fuses() || facts.sets.empty() ? 0 : visits);
  line("pressure", substeps * facts.pressure_starts + iterations * facts.pressure_launches);
  line("long_range", facts.long_range > 0 ? iterations : 0);
  line("attachments", iterations * model.attached.size());
  // Contacts are solved in each iteration and restitution acts in each substep; a restitution of 0 still stops the
  // approach. Motion by restitution is clamped against tunnelling, too.
  const bool bounces =
      std::ranges::any_of(model.environment, [](const EnvironmentMesh& mesh) { return mesh.spec.restitution > 0; });
  line("contact", (iterations + substeps) * obstacles + (bounces ? 3 * substeps : 0));
  std::size_t own_launches = 0;  // one gather at the start of a substep, batches in a symmetric sweep, and a scatter
  for (const UserConstraintStats& user_constraints : facts.user_constraints)
    own_launches += substeps + 2 * iterations * static_cast<std::size_t>(std::max(2 * user_constraints.batches - 2, 1));
  line("user_constraints", own_launches);
  if (facts.self)
    all.push_back(
        {"self-collision", 9 * substeps + 2 * iterations, "at least; more where pairs are near or searched for"});
  if (facts.edges) all.push_back({"edges", 10 * substeps, "at least; more where pairs are near"});
  line("state",
       (plan.fuses() ? 0 : substeps) + (bounces ? substeps : 0));  // restitution moves particles after the update
  line("tearing", can_tear(model.scene) ? 1 : 0);
  line("sleep", model.scene.sleep ? 1 : 0);  // a sleeping scene launches none of these
  if (plan.skips_contacts)
    all.push_back(
        {"while nothing comes near the environment", 2 * obstacles + 1 + visits, "collision and patch solves alone"});
  return all;
}

}  // namespace malha
