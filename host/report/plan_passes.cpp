// SPDX-License-Identifier: Apache-2.0
#include "host/report/plan_passes.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>

#include "host/model/tear.h"
#include "host/patch/patch_plan.h"

namespace malha {

namespace {

/// The launches that a step has for one of its stages.
template <class Stage>
struct StageLaunches {
  Stage stage;
  Pass pass;
  std::size_t launches;
  const char* remark = "";
};

}  // namespace

std::size_t pinned_at_start(const Model& model) {
  std::size_t pinned = std::count(model.w.begin(), model.w.end(), 0.0);
  for (const MovedPins& pins : model.moved) pinned += pins.release_time ? pins.particles.size() : 0;
  return pinned;
}

std::vector<StepPass> step_passes(const Model& model, const Solver& solver) {
  const SolverStats& facts = solver.facts();
  const StepPlan& plan = solver.step_plan();
  const SolverSpec& spec = model.scene.solver;
  const std::size_t substeps = spec.substeps, iterations = substeps * spec.iterations;
  const std::size_t solves = iterations * sweep_order(facts.patches.colours).size(), meshes = mesh_count(model);
  // Exact shapes have one launch for all of them.
  const std::size_t shapes = meshes < model.environment.size() ? 1 : 0;
  const std::size_t free = model.free.empty() ? 0 : 1, refine = spec.desbrun.refinement_iterations;
  const std::size_t comparisons = spec.substeps / plan.substeps_compared(spec.substeps);  // of momenta
  const std::size_t drags = model.scene.wind && model.scene.wind->drag > 0 ? substeps : 0;
  const bool bounces =
      std::ranges::any_of(model.environment, [](const EnvironmentMesh& mesh) { return mesh.spec.restitution > 0; });
  std::size_t moved = 0, user = 0;
  for (const MovedPins& pins : model.moved) moved += pins.target.moves() ? substeps : 0;
  // One gather at the start of a substep, batches in a symmetric sweep, and a scatter.
  for (const UserConstraintStats& of : facts.user_constraints)
    user += substeps + 2 * iterations * static_cast<std::size_t>(std::max(2 * of.batches - 2, 1));
  // The substeps of a step that use levels, and the launches of each: sums of means whose parts lie in several patches,
  // restrictions to the coarser levels, and sweeps over all of them. By patch solves, the finest level is restricted
  // in a pass for the first substep alone, and prolongated in none.
  std::size_t uses = 0, cycle = 0;
  if (!facts.levels.empty()) {
    uses = (substeps + facts.levels_interval - 1) / facts.levels_interval;
    cycle = 2 * facts.levels.size() - 1;
    for (const LevelStats& level : facts.levels) cycle += sweep_order(level.patches.colours).size();
  }
  const std::size_t restrictions = plan.solves == PatchSolves::ByStep ? std::min<std::size_t>(uses, 1) : uses;
  const bool desbrun = facts.filter && facts.bending_launches == 0;
  const std::size_t filter = desbrun ? facts.filter->launches : 0;
  const std::size_t corrections = desbrun ? facts.free_bodies * (3 * refine + (facts.corrects ? 5 : 3)) : 0;

  const StageLaunches<Stage> of_stages[]{
      {Stage::MovePins, Pass::Pins, moved},
      {Stage::PlacePins, Pass::Pins, moved},
      {Stage::Damp, Pass::Damping, 4 * substeps},
      {Stage::Wind, Pass::Air, facts.air_particles > 0 ? 2 * substeps : 0},
      {Stage::Wind, Pass::Prediction, drags},
      {Stage::MeasureMomenta, Pass::MomentumCorrection, 2 * comparisons},
      {Stage::CompareMomenta, Pass::MomentumCorrection, 2 * comparisons},
      {Stage::Predict, Pass::Forces, facts.force_launches * substeps * (1 + refine)},
      {Stage::Predict, Pass::Filter, filter * substeps * (1 + refine)},
      {Stage::Predict, Pass::MomentumCorrection, substeps * corrections},
      {Stage::Predict, Pass::Prediction, substeps},
      {Stage::PredictWind, Pass::Prediction, substeps},
      {Stage::FilterBending, Pass::Filter, facts.bending_launches * substeps},
      {Stage::SolveSubstep, Pass::MomentumCorrection, 4 * comparisons * free},
      {Stage::SolveSubstep, Pass::Levels, uses * cycle + restrictions},
      {Stage::SolveSubstep, Pass::FusedSolve, solves},
      {Stage::DetectContacts, Pass::Collision, (4 * meshes + shapes) * substeps},
      {Stage::CorrectCoarsely, Pass::Levels, uses * (cycle + 2)},
      {Stage::StartPressures, Pass::Pressure, substeps * facts.pressure_starts},
      {Stage::ClampTunnelling, Pass::Collision, (meshes > 0 ? meshes + 2 : 1) * substeps},
      {Stage::UpdateState, Pass::State, substeps},
      {Stage::Restitute, Pass::Contact,
       substeps * (meshes + shapes + (bounces ? (meshes > 0 ? 3 : 0) + shapes : 0))},  // 0 still stops the approach
      {Stage::Restitute, Pass::State, bounces ? substeps : 0},
      {Stage::EndSelfCollision, Pass::SelfCollision, 9 * substeps,
       "at least; more where pairs are near or searched for"},
      {Stage::EndEdgeContacts, Pass::Edges, 10 * substeps, "at least; more where pairs are near"},
  };
  const StageLaunches<IterationStage> of_iteration_stages[]{
      {IterationStage::MeasureMomenta, Pass::MomentumCorrection, 2 * iterations},
      {IterationStage::CompareMomenta, Pass::MomentumCorrection, 2 * iterations},
      {IterationStage::SolvePatches, Pass::Projection, solves},
      {IterationStage::ProjectPressures, Pass::Pressure, iterations * facts.pressure_launches},
      {IterationStage::ProjectLongRange, Pass::LongRange, iterations},
      {IterationStage::ProjectAttachments, Pass::Attachments, iterations * model.attached.size()},
      {IterationStage::ProjectUserConstraints, Pass::UserConstraints, user},
      {IterationStage::SolveSelfContacts, Pass::SelfCollision, 2 * iterations},
      {IterationStage::SolveContacts, Pass::Contact, iterations * (meshes + shapes)},
  };

  std::array<StepPass, kPassNames.size()> passes;
  const auto add = [&](Pass pass, std::size_t launches, const char* remark = "") {
    StepPass& to = passes[static_cast<std::size_t>(pass)];
    to.name = kPassNames[static_cast<std::size_t>(pass)], to.launches += launches, to.remark += remark;
  };
  for (const Stage stage : plan.substep)
    for (const auto& of : of_stages)
      if (of.stage == stage) add(of.pass, of.launches, of.remark);
  for (const IterationStage stage : plan.iteration)
    for (const auto& of : of_iteration_stages)
      if (of.stage == stage) add(of.pass, of.launches, of.remark);
  const std::size_t clearances = (meshes > 0 ? meshes + 1 : 0) + 2 * shapes;
  // Once a step: momenta are restored, after a measurement unless a comparison was the last one; levels have an origin
  // for its positions; the clearance to each object and to all; and what watches whole steps. A sleeping scene launches
  // none of all these.
  add(Pass::MomentumCorrection, free * (plan.compares_substeps() ? 2 : 4));
  add(Pass::Levels, facts.level_layouts), add(Pass::Collision, plan.skips_contacts ? clearances : 0);
  add(Pass::Tearing, can_tear(model.scene)), add(Pass::Sleep, model.scene.sleep.has_value());

  std::vector<StepPass> all;
  std::ranges::copy_if(passes, std::back_inserter(all), [](const StepPass& pass) { return pass.launches > 0; });
  if (plan.skips_contacts)
    all.push_back(
        {"while nothing comes near the environment", clearances + meshes + solves, "collision and patch solves alone"});
  return all;
}

}  // namespace malha
