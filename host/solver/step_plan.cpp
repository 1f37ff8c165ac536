// SPDX-License-Identifier: Apache-2.0
#include "host/solver/step_plan.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

#include "host/attachments/object_motion.h"
#include "host/model/seams.h"

namespace malha {

std::string_view name_of(Stage stage) {
  static constexpr std::array names{"move_pins",
                                    "release_attachments",
                                    "move_handles",
                                    "damp",
                                    "wind",
                                    "apply_forces",
                                    "measure_momenta",
                                    "predict",
                                    "predict_wind",
                                    "filter_bending",
                                    "solve_substep",
                                    "detect_contacts",
                                    "start_self_collision",
                                    "detect_edge_contacts",
                                    "correct_coarsely",
                                    "start_pressures",
                                    "iterate",
                                    "clamp_tunnelling",
                                    "truncate_motion",
                                    "update_state",
                                    "restitute",
                                    "end_self_collision",
                                    "end_edge_contacts",
                                    "compare_momenta",
                                    "place_handles",
                                    "place_pins",
                                    "call_back"};
  static_assert(names.size() == static_cast<std::size_t>(Stage::CallBack) + 1);
  return names[static_cast<std::size_t>(stage)];
}
std::string_view name_of(IterationStage stage) {
  static constexpr std::array names{"measure_momenta",          "solve_patches",      "project_pressures",
                                    "compare_momenta",          "project_long_range", "project_attachments",
                                    "project_user_constraints", "project_handles",    "solve_self_contacts",
                                    "solve_edge_contacts",      "close_seams",        "solve_contacts"};
  static_assert(names.size() == static_cast<std::size_t>(IterationStage::SolveContacts) + 1);
  return names[static_cast<std::size_t>(stage)];
}
std::string_view name_of(PatchSolves solves) {
  static constexpr std::array names{"in_iterations", "by_substep", "by_step"};
  static_assert(names.size() == static_cast<std::size_t>(PatchSolves::ByStep) + 1);
  return names[static_cast<std::size_t>(solves)];
}
std::string_view name_of(Recorded recorded) { return recorded == Recorded::Steps ? "steps" : "patch_solves"; }

StepFeatures step_features(const Model& model, bool levels) {
  const Scene& scene = model.scene;
  const DesbrunSpec& desbrun = scene.solver.desbrun;
  const auto changes = [](const AttachmentSet& set) { return set.target.has_motion() || set.release_time; };
  StepFeatures has;
  has.position_based = scene.solver.type == "pbd";
  has.filter = !has.position_based && (!model.springs.empty() || !model.stencils.empty());
  has.filtered_bending = has.position_based && !model.stencils.empty();
  has.filtered_wind = has.filter && desbrun.filter_external_forces;
  has.batches = !model.sets.empty(), has.levels = levels;
  has.pressure = !model.pressures.empty(), has.long_range = model.long_range.items() > 0;
  has.attachments = !model.attached.empty(), has.attachments_change = std::ranges::any_of(model.attached, changes);
  has.closed_seams = has_closed_places(model), has.shared_seams = has_shared_places(model);
  has.pins_move = !model.moved.empty();
  has.contacts = !model.environment.empty(), has.objects_move = std::ranges::any_of(model.environment, moves);
  has.edges = names_edges(scene), has.self_collision = scene.self_collision.has_value();
  has.damping = !model.damped.empty(), has.wind = scene.wind.has_value(), has.free_bodies = !model.free.empty();
  has.host_ends_iterations = desbrun.tolerance || desbrun.time_budget;
  return has;
}

namespace {

struct Stages {
  std::vector<Stage> substep;
  std::vector<IterationStage> iteration;
};

template <class Stage>
std::vector<Stage> list(std::initializer_list<std::pair<bool, Stage>> all) {
  std::vector<Stage> chosen;
  for (const auto& [condition, stage] : all)
    if (condition) chosen.push_back(stage);
  return chosen;
}

/// The stages of a substep whose patch solves come between others. `compare_solves`: momenta of free bodies are
/// compared over patch solves and not over the projections of an iteration.
Stages stages_apart(const StepFeatures& has, const Interaction& now, bool compare_solves) {
  const bool forces = has.forces || now.callback;  // a callback may set them
  const bool first = !has.filter || has.filtered_wind, wind_first = has.wind && first, wind_later = has.wind && !first;
  const bool opens_seams = has.long_range || has.attachments || now.user_constraints || now.handles ||
                           has.self_collision || has.edges || has.shared_seams;
  const bool by_solve = has.free_bodies && compare_solves, by_projection = has.free_bodies && !compare_solves;
  return {list<Stage>({
              {has.pins_move, Stage::MovePins},
              {has.attachments, Stage::ReleaseAttachments},
              {now.handles, Stage::MoveHandles},
              {has.damping, Stage::Damp},
              {wind_first, Stage::Wind},
              {forces && first, Stage::ApplyForces},
              {by_solve, Stage::MeasureMomenta},
              {true, Stage::Predict},
              {wind_later, Stage::Wind},
              {wind_later, Stage::PredictWind},
              {forces && !first, Stage::ApplyForces},
              {has.filtered_bending, Stage::FilterBending},
              {has.contacts, Stage::DetectContacts},
              {has.self_collision, Stage::StartSelfCollision},
              {has.edges, Stage::DetectEdgeContacts},
              {has.levels, Stage::CorrectCoarsely},
              {has.pressure, Stage::StartPressures},
              {true, Stage::Iterate},
              {has.contacts, Stage::ClampTunnelling},
              {has.self_collision || has.edges, Stage::TruncateMotion},
              {true, Stage::UpdateState},
              {has.contacts, Stage::Restitute},
              {has.self_collision, Stage::EndSelfCollision},
              {has.edges, Stage::EndEdgeContacts},
              {by_solve, Stage::CompareMomenta},
              {now.handles, Stage::PlaceHandles},
              {has.pins_move, Stage::PlacePins},
              {now.callback, Stage::CallBack},
          }),
          list<IterationStage>({
              {by_projection, IterationStage::MeasureMomenta},
              {has.batches, IterationStage::SolvePatches},
              {has.pressure, IterationStage::ProjectPressures},
              {by_projection, IterationStage::CompareMomenta},
              {has.long_range, IterationStage::ProjectLongRange},
              {has.attachments, IterationStage::ProjectAttachments},
              {now.user_constraints, IterationStage::ProjectUserConstraints},
              {now.handles, IterationStage::ProjectHandles},
              {has.self_collision, IterationStage::SolveSelfContacts},
              {has.edges, IterationStage::SolveEdgeContacts},
              {has.closed_seams && opens_seams, IterationStage::CloseSeams},
              {has.contacts, IterationStage::SolveContacts},
          })};
}

/// Momenta of free bodies are measured between forces and prediction, which one pass therefore cannot apply together.
bool prediction_applies_forces(const StepFeatures& has) { return has.forces && !has.free_bodies; }

/// Patch solves with prediction and state update take the place of the stages from Predict to UpdateState, if these are
/// all of PBD and an iteration has nothing but patch solves. They measure momenta and apply forces themselves, where
/// they can. Otherwise returns no stages.
std::vector<Stage> stages_fused(const StepFeatures& all) {
  StepFeatures has = all;
  if (prediction_applies_forces(all)) has.forces = false;
  const Stages apart = stages_apart(has, {}, true);
  const auto is_solve = [](IterationStage stage) { return stage == IterationStage::SolvePatches; };
  if (!has.position_based || !std::ranges::all_of(apart.iteration, is_solve)) return {};
  std::vector<Stage> fused;
  bool inside = false;
  for (const Stage stage : apart.substep) {
    if (stage == Stage::Predict)
      fused.push_back(Stage::SolveSubstep), inside = true;
    else if (stage == Stage::UpdateState)
      inside = false;
    else if (inside && stage != Stage::CorrectCoarsely && stage != Stage::Iterate)
      return {};
    else if (!inside && stage != Stage::MeasureMomenta && stage != Stage::CompareMomenta)
      fused.push_back(stage);
  }
  return fused;
}

PatchSolves solves_of(const std::vector<Stage>& fused) {
  if (fused.empty()) return PatchSolves::InIterations;
  return fused.size() == 1 ? PatchSolves::ByStep : PatchSolves::BySubstep;  // nothing is between substeps
}

/// A step whose particles cannot reach an object needs no contact tests, if without contacts all its substeps would run
/// in one region, and objects stay.
bool can_skip_contacts(const StepFeatures& has) {
  StepFeatures without = has;
  without.contacts = false;
  return has.contacts && !has.objects_move && !has.levels && !has.free_bodies &&
         solves_of(stages_fused(without)) == PatchSolves::ByStep;
}

/// A device may record whole steps if all steps have the same launches: none searches for contacts, depends on time, or
/// lets the host decide within it.
bool can_record(const StepFeatures& has) {
  return !has.contacts && !has.edges && !has.self_collision && !has.pins_move && !has.attachments_change &&
         !has.host_ends_iterations;
}

}  // namespace

StepPlan plan_step(const StepFeatures& has, const Interaction& now) {
  const bool alone = now == Interaction{};
  const std::vector<Stage> fused = stages_fused(has);
  StepPlan plan;
  plan.solves_alone = solves_of(fused);
  plan.solves = alone ? plan.solves_alone : PatchSolves::InIterations;
  plan.skips_contacts = alone && can_skip_contacts(has);
  plan.solves_apply_forces = (plan.fuses() || plan.skips_contacts) && prediction_applies_forces(has);
  plan.recorded = alone && can_record(has) ? Recorded::Steps : Recorded::PatchSolves;
  plan.finite_each_substep = has.contacts || has.self_collision || has.edges || now.user_constraints || now.callback;
  Stages apart = stages_apart(has, now, !fused.empty());
  plan.substep = plan.fuses() ? fused : std::move(apart.substep);
  if (!plan.fuses()) plan.iteration = std::move(apart.iteration);
  return plan;
}

}  // namespace malha
