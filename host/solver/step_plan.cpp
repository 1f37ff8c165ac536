// SPDX-License-Identifier: Apache-2.0
#include "host/solver/step_plan.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

#include "host/model/validate_outputs.h"

namespace malha {

std::string_view name_of(Stage stage) {
  static constexpr std::array names{"move_pins",
                                    "release_attachments",
                                    "move_handles",
                                    "damp",
                                    "wind",
                                    "measure_momenta",
                                    "predict",
                                    "predict_wind",
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
                                    "solve_edge_contacts",      "solve_contacts"};
  static_assert(names.size() == static_cast<std::size_t>(IterationStage::SolveContacts) + 1);
  return names[static_cast<std::size_t>(stage)];
}
std::string_view name_of(PatchSolves solves) {
  static constexpr std::array names{"in_iterations", "by_substep", "by_step"};
  return names[static_cast<std::size_t>(solves)];
}

StepFeatures step_features(const Model& model, bool levels) {
  const Scene& scene = model.scene;
  const DesbrunSpec& desbrun = scene.solver.desbrun;
  const auto changes = [](const AttachmentSet& set) { return !set.target.motion.empty() || set.release_time; };
  const auto moves = [](const EnvironmentMesh& mesh) { return !mesh.spec.motion.empty(); };
  StepFeatures has;
  has.position_based = scene.solver.type == "pbd";
  has.filter = !model.springs.empty() || !model.stencils.empty();
  has.filtered_wind = has.filter && desbrun.filter_external_forces;
  has.batches = !model.sets.empty(), has.levels = levels;
  has.pressure = !model.pressures.empty(), has.long_range = model.long_range.items() > 0;
  has.attachments = !model.attached.empty(), has.attachments_change = std::ranges::any_of(model.attached, changes);
  has.pins_move = !model.moved.empty();
  has.contacts = !model.environment.empty(), has.objects_move = std::ranges::any_of(model.environment, moves);
  has.edges = names_edges(scene), has.self_collision = scene.self_collision.has_value();
  has.damping = !model.damped.empty(), has.wind = scene.wind.has_value(), has.free_bodies = !model.free.empty();
  has.host_ends_iterations = desbrun.tolerance || desbrun.time_budget;
  return has;
}

namespace {

/// Patch solves predict and update the state where nothing else acts on particles between these two. Desbrun's filter
/// is a prediction of its own.
bool can_fuse(const StepFeatures& has) {
  return has.position_based && !has.contacts && !has.self_collision && !has.pressure && !has.long_range &&
         !has.attachments;
}

/// Nothing happens between the substeps of a step.
bool is_steady(const StepFeatures& has) { return !has.damping && !has.pins_move && !has.wind; }

/// A step whose particles cannot reach an object needs no contact tests, if contacts are all that stands between
/// prediction and state update, and objects stay.
bool can_skip_contacts(const StepFeatures& has) {
  StepFeatures without = has;
  without.contacts = false;
  return has.contacts && !has.objects_move && !has.edges && !has.levels && !has.free_bodies && can_fuse(without) &&
         is_steady(has);
}

/// A device may record a step if all steps have the same launches: none searches for contacts, depends on time, or lets
/// the host decide within it.
bool can_record(const StepFeatures& has) {
  return !has.contacts && !has.self_collision && !has.pins_move && !has.attachments_change && !has.host_ends_iterations;
}

template <class Stage>
std::vector<Stage> list(std::initializer_list<std::pair<bool, Stage>> all) {
  std::vector<Stage> chosen;
  for (const auto& [condition, stage] : all)
    if (condition) chosen.push_back(stage);
  return chosen;
}

}  // namespace

StepPlan plan_step(const StepFeatures& has, const Interaction& now) {
  const bool fuses = can_fuse(has), alone = !now.acts() && !now.callback;
  StepPlan plan;
  plan.momenta = !fuses ? PatchSolves::InIterations : is_steady(has) ? PatchSolves::ByStep : PatchSolves::BySubstep;
  plan.solves = alone ? plan.momenta : PatchSolves::InIterations;
  plan.skips_contacts = alone && can_skip_contacts(has);
  plan.overlaps_queries = has.contacts && has.batches && !has.levels && !has.filter && !has.edges && !has.free_bodies;
  plan.recorded = alone && can_record(has);
  plan.finite_each_substep = has.contacts || has.self_collision || has.edges || now.user_constraints || now.callback;

  const bool fused = plan.solves != PatchSolves::InIterations, apart = !fused,
             wind_later = has.filter && !has.filtered_wind;
  const bool per_solve = apart && has.free_bodies && fuses, per_projection = apart && has.free_bodies && !fuses;
  plan.substep = list<Stage>({
      {has.pins_move, Stage::MovePins},
      {has.attachments, Stage::ReleaseAttachments},
      {now.handles, Stage::MoveHandles},
      {has.damping, Stage::Damp},
      {has.wind && !wind_later, Stage::Wind},
      {per_solve, Stage::MeasureMomenta},
      {apart, Stage::Predict},
      {has.wind && wind_later, Stage::Wind},
      {has.wind && wind_later, Stage::PredictWind},
      {fused, Stage::SolveSubstep},
      {has.contacts, Stage::DetectContacts},
      {has.self_collision, Stage::StartSelfCollision},
      {has.edges, Stage::DetectEdgeContacts},
      {apart && has.levels, Stage::CorrectCoarsely},
      {has.pressure, Stage::StartPressures},
      {apart, Stage::Iterate},
      {has.contacts, Stage::ClampTunnelling},
      {has.self_collision || has.edges, Stage::TruncateMotion},
      {apart, Stage::UpdateState},
      {has.contacts, Stage::Restitute},
      {has.self_collision, Stage::EndSelfCollision},
      {has.edges, Stage::EndEdgeContacts},
      {per_solve, Stage::CompareMomenta},
      {now.handles, Stage::PlaceHandles},
      {has.pins_move, Stage::PlacePins},
      {now.callback, Stage::CallBack},
  });
  if (fused) return plan;
  plan.iteration = list<IterationStage>({
      {per_projection, IterationStage::MeasureMomenta},
      {has.batches, IterationStage::SolvePatches},
      {has.pressure, IterationStage::ProjectPressures},
      {per_projection, IterationStage::CompareMomenta},
      {has.long_range, IterationStage::ProjectLongRange},
      {has.attachments, IterationStage::ProjectAttachments},
      {now.user_constraints, IterationStage::ProjectUserConstraints},
      {now.handles, IterationStage::ProjectHandles},
      {has.self_collision, IterationStage::SolveSelfContacts},
      {has.edges, IterationStage::SolveEdgeContacts},
      {has.contacts, IterationStage::SolveContacts},
  });
  return plan;
}

}  // namespace malha
