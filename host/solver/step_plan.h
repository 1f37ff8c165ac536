// SPDX-License-Identifier: Apache-2.0
// A step as a list: the stages of a substep in their order, how patches are solved in it, and whether a device may
// record it. The time stepper executes this list, and `malha plan` prints it. What a stage does with the state of the
// moment is its own: sleep skips a whole step, particles that are far from all objects skip the contact tests of one,
// iterations end at a tolerance, and levels act in every so many substeps.
#pragma once
#include <string_view>
#include <vector>

#include "host/model/model.h"

namespace malha {

/// A stage of a substep, in the order in which a substep may have them. (Wind and forces that the filter does not
/// have come after Predict.)
enum class Stage : unsigned char {
  MovePins,            // to where they are at the end of the substep; pins whose time is over are released
  ReleaseAttachments,  // whose time is over
  MoveHandles,         // those of the user
  Damp,                // before gravity, which is uniform: the rigid part of the motion has all of it
  Wind,                // changes v
  ApplyForces,         // those that a program sets: v, and p where the filter does not have them
  MeasureMomenta,      // of free bodies, before patch solves over which they are compared
  Predict,             // v and p from the forces: gravity, or Desbrun's filtered ones
  PredictWind,         // adds to p what the wind gave to v, where the filter does not have it
  FilterBending,       // p: backward Euler of bending that is not projected
  SolveSubstep,        // patch solves that predict, project and update the state
  DetectContacts,      // with environment meshes
  StartSelfCollision,  // self-collision detects in its first iteration
  DetectEdgeContacts,  // with edges of the environment
  CorrectCoarsely,     // the levels
  StartPressures,
  Iterate,
  ClampTunnelling,  // particles stay in front of the meshes that they would tunnel through
  TruncateMotion,   // no surface intersects another
  UpdateState,      // v and x from displacements
  Restitute,        // moves particles again, so that both guards follow once more
  EndSelfCollision,
  EndEdgeContacts,
  CompareMomenta,
  PlaceHandles,  // held particles have the position and velocity of their motion, exactly
  PlacePins,     // likewise
  CallBack,      // the user's function
};
/// A stage of an iteration, likewise. Contacts come last, so that particles are outside the environment after it.
enum class IterationStage : unsigned char {
  MeasureMomenta,  // momenta, before the projections
  SolvePatches,
  ProjectPressures,
  CompareMomenta,
  ProjectLongRange,
  ProjectAttachments,
  ProjectUserConstraints,
  ProjectHandles,
  SolveSelfContacts,
  SolveEdgeContacts,
  CloseSeams,  // which the stages after the patches' solves have opened
  SolveContacts,
};
std::string_view name_of(Stage stage);
std::string_view name_of(IterationStage stage);

/// This is what of a model decides how its steps run. Each member names what the scene has.
struct StepFeatures {
  bool filter = false;            // Desbrun's method with springs: forces are filtered
  bool filtered_wind = false;     // the wind's forces are filtered, too
  bool position_based = false;    // PBD: patch solves can predict and update the state
  bool filtered_bending = false;  // PBD: bending is filtered after the prediction
  bool batches = false;           // constraints that patch solves project
  bool levels = false;            // known when they are laid out
  bool pressure = false, long_range = false;
  bool closed_seams = false, shared_seams = false;  // without compliance, and with places of three particles or more
  bool attachments = false, attachments_change = false;  // one moves, or is released
  bool pins_move = false;
  bool contacts = false, objects_move = false, edges = false, self_collision = false;
  bool damping = false, wind = false, free_bodies = false;
  bool forces = false;                // that a program has set
  bool host_ends_iterations = false;  // by a tolerance or a time budget
};
/// `levels`: whether coarse levels were laid out.
StepFeatures step_features(const Model& model, bool levels);

/// This tells what a user holds or added, which the layout does not contain.
struct Interaction {
  bool handles = false, user_constraints = false, callback = false;
  /// Tells whether handles or user constraints act, which the layout does not contain.
  bool acts() const { return handles || user_constraints; }
  bool operator==(const Interaction&) const = default;
};

/// Patches are solved between the other stages of an iteration; with prediction and state update, one substep at a
/// time; or likewise, all substeps of a step in one parallel region.
enum class PatchSolves : unsigned char { InIterations, BySubstep, ByStep };
std::string_view name_of(PatchSolves solves);

/// The launches that a device records once, and replays whenever they come again. (Without contact tests a step is not
/// recorded, because the host reads after each substep whether a particle was too fast.)
enum class Recorded : unsigned char { PatchSolves, Steps };
std::string_view name_of(Recorded recorded);

struct StepPlan {
  /// Tells whether patch solves predict and update the state.
  bool fuses() const { return solves != PatchSolves::InIterations; }
  std::vector<Stage> substep;
  std::vector<IterationStage> iteration;  // empty without Stage::Iterate
  PatchSolves solves = PatchSolves::InIterations;
  /// This is how patches are solved while the user holds and adds nothing. Momenta of free bodies are compared over
  /// that part of a step in any case, so that bodies without handle keep their bits.
  PatchSolves solves_alone = PatchSolves::InIterations;
  bool solves_apply_forces = false;  // the predictions of patch solves apply the forces that a program has set
  bool skips_contacts = false;       // steps in which no particle can reach an object run as patch solves alone
  Recorded recorded = Recorded::PatchSolves;
  bool finite_each_substep = false;  // positions must be finite before the next substep, otherwise before the next step

  /// Tells whether momenta of free bodies are compared over substeps, not over the projections of each iteration.
  bool compares_substeps() const { return solves_alone != PatchSolves::InIterations; }
  /// Number of substeps, of those of a step, over which they are compared at once.
  int substeps_compared(int substeps) const { return solves_alone == PatchSolves::ByStep ? substeps : 1; }
};

/// Returns how a step runs. Pure: the same arguments give the same list.
StepPlan plan_step(const StepFeatures& features, const Interaction& interaction = {});

}  // namespace malha
