// SPDX-License-Identifier: Apache-2.0
// The list of a step's stages (host/solver/step_plan.h): of the shipped scenes, and the rules that it keeps.
#include "host/solver/step_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <tuple>

#include "host/solver/solver.h"
#include "malha/simulation.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"

namespace malha {
namespace {

template <class Stage>
std::string text_of(const std::vector<Stage>& stages) {
  std::string text;
  for (const Stage stage : stages) text += (text.empty() ? "" : " ") + std::string(name_of(stage));
  return text;
}

template <class Stage>
long index_of(const std::vector<Stage>& stages, Stage stage) {
  const auto at = std::ranges::find(stages, stage);
  return at == stages.end() ? -1 : at - stages.begin();
}
template <class Stage>
bool lists_stage(const std::vector<Stage>& stages, Stage stage) {
  return index_of(stages, stage) >= 0;
}
/// Any features, also those that no scene has together; each round has few or many.
StepFeatures random_features(Random& random) {
  const double share = random(0.02, 0.6);
  const auto toss = [&] { return random(0, 1) < share; };
  StepFeatures features;
  features.position_based = random(0, 1) < 0.7, features.filter = toss(), features.filtered_wind = toss();
  features.filtered_bending = toss();
  features.batches = random(0, 1) < 0.8, features.levels = toss(), features.pressure = toss();
  features.long_range = toss(), features.attachments = toss(), features.attachments_change = toss();
  features.pins_move = toss(), features.contacts = toss(), features.objects_move = toss(), features.edges = toss();
  features.self_collision = toss(), features.damping = toss(), features.wind = toss();
  features.closed_seams = toss(), features.shared_seams = features.closed_seams && toss();
  features.free_bodies = toss(), features.host_ends_iterations = toss(), features.forces = toss();
  return features;
}

TEST(StepPlan, IsLegalWhateverASceneHasAndAUserDoes) {
  using I = IterationStage;
  Random random(1);
  std::map<std::string, int> seen;
  for (int round = 0; round < 20000; ++round) {
    const StepFeatures features = random_features(random);
    const Interaction now{random(0, 1) < 0.1, random(0, 1) < 0.1, random(0, 1) < 0.1};
    const StepPlan plan = plan_step(features, now);
    const std::vector<Stage>& stages = plan.substep;
    SCOPED_TRACE(text_of(stages) + " / " + text_of(plan.iteration));
    ++seen[std::string(name_of(plan.solves))], seen["skips"] += plan.skips_contacts;
    ++seen[std::string(name_of(plan.recorded))];

    // Each stage comes once, in the order of the enumeration; wind and forces may follow the prediction, and are then
    // added to it.
    std::vector<Stage> sorted = stages;
    if (features.filter && !features.filtered_wind && lists_stage(stages, Stage::ApplyForces)) {
      ASSERT_GT(index_of(stages, Stage::ApplyForces), index_of(stages, Stage::Predict));
      std::erase(sorted, Stage::ApplyForces);
    }
    if (lists_stage(stages, Stage::PredictWind)) {
      ASSERT_TRUE(index_of(stages, Stage::Predict) + 1 == index_of(stages, Stage::Wind) &&
                  index_of(stages, Stage::Wind) + 1 == index_of(stages, Stage::PredictWind));
      std::erase(sorted, Stage::Wind);
    }
    ASSERT_TRUE(std::ranges::adjacent_find(sorted, std::ranges::greater_equal()) == sorted.end());
    ASSERT_TRUE(std::ranges::adjacent_find(plan.iteration, std::ranges::greater_equal()) == plan.iteration.end());

    // The state is predicted and updated once: by stages, or by the patch solves.
    ASSERT_EQ(lists_stage(stages, Stage::SolveSubstep), plan.fuses());
    for (const Stage stage : {Stage::Predict, Stage::Iterate, Stage::UpdateState})
      ASSERT_NE(lists_stage(stages, stage), plan.fuses()) << name_of(stage);
    if (plan.fuses()) {
      ASSERT_TRUE(plan.iteration.empty());
    }

    // Only patch solves that predict can apply forces, and momenta of free bodies are measured in between.
    const bool predicts = plan.fuses() || plan.skips_contacts;
    ASSERT_EQ(plan.solves_apply_forces, features.forces && predicts && !features.free_bodies);
    // What a scene has and a user does is in the list; patch solves do the work of a few stages themselves.
    const std::pair<bool, Stage> expected[]{
        {features.pins_move, Stage::MovePins},
        {features.pins_move, Stage::PlacePins},
        {features.attachments, Stage::ReleaseAttachments},
        {now.handles, Stage::MoveHandles},
        {now.handles, Stage::PlaceHandles},
        {features.damping, Stage::Damp},
        {features.wind, Stage::Wind},
        {(features.forces && !(plan.fuses() && plan.solves_apply_forces)) || now.callback, Stage::ApplyForces},
        {features.contacts, Stage::DetectContacts},
        {features.contacts, Stage::ClampTunnelling},
        {features.contacts, Stage::Restitute},
        {features.self_collision, Stage::StartSelfCollision},
        {features.self_collision, Stage::EndSelfCollision},
        {features.edges, Stage::DetectEdgeContacts},
        {features.edges, Stage::EndEdgeContacts},
        {features.self_collision || features.edges, Stage::TruncateMotion},
        {features.pressure, Stage::StartPressures},
        {now.callback, Stage::CallBack}};
    for (const auto& [named, stage] : expected) ASSERT_EQ(lists_stage(stages, stage), named) << name_of(stage);
    ASSERT_EQ(lists_stage(stages, Stage::FilterBending), features.filtered_bending);
    if (!plan.fuses()) {
      ASSERT_EQ(lists_stage(stages, Stage::CorrectCoarsely), features.levels);
    }
    const bool opens_seams = features.long_range || features.attachments || now.user_constraints || now.handles ||
                             features.self_collision || features.edges || features.shared_seams;
    const std::pair<bool, I> projected[]{{features.pressure, I::ProjectPressures},
                                         {features.long_range, I::ProjectLongRange},
                                         {features.attachments, I::ProjectAttachments},
                                         {now.user_constraints, I::ProjectUserConstraints},
                                         {now.handles, I::ProjectHandles},
                                         {features.self_collision, I::SolveSelfContacts},
                                         {features.edges, I::SolveEdgeContacts},
                                         {features.closed_seams && opens_seams, I::CloseSeams},
                                         {features.contacts, I::SolveContacts}};
    for (const auto& [named, stage] : projected) ASSERT_EQ(lists_stage(plan.iteration, stage), named) << name_of(stage);
    if (!plan.fuses()) {
      ASSERT_EQ(lists_stage(plan.iteration, I::SolvePatches), features.batches);
    }

    // All substeps in one region leave nothing to do between them.
    if (plan.solves == PatchSolves::ByStep) {
      ASSERT_EQ(text_of(stages), "solve_substep");
    }
    // A step without its contact tests is such a step.
    if (plan.skips_contacts) {
      StepFeatures without = features;
      without.contacts = false;
      ASSERT_EQ(plan_step(without, now).solves, PatchSolves::ByStep);
      ASSERT_FALSE(features.objects_move || features.free_bodies || features.levels);
    }
    // Momenta of free bodies are compared over one part of a step, whatever the user holds.
    ASSERT_EQ(plan.solves_alone, plan_step(features).solves);
    const int pairs = lists_stage(stages, Stage::MeasureMomenta) + lists_stage(plan.iteration, I::MeasureMomenta);
    ASSERT_EQ(pairs, features.free_bodies && !plan.fuses() ? 1 : 0);
    ASSERT_EQ(lists_stage(stages, Stage::MeasureMomenta), lists_stage(stages, Stage::CompareMomenta));
    ASSERT_EQ(lists_stage(plan.iteration, I::MeasureMomenta), lists_stage(plan.iteration, I::CompareMomenta));
    // No recorded step searches, asks the host, or depends on time or the user.
    if (plan.recorded == Recorded::Steps) {
      ASSERT_FALSE(features.contacts || features.self_collision || features.edges || features.pins_move ||
                   features.attachments_change || features.host_ends_iterations || now.acts() || now.callback);
    }
    // What cannot handle NaN makes the check come after each substep; patch solves that fuse check by themselves.
    ASSERT_EQ(plan.finite_each_substep,
              features.contacts || features.self_collision || features.edges || now.user_constraints || now.callback);
    ASSERT_FALSE(plan.fuses() && plan.finite_each_substep);
  }
  for (const char* kind : {"in_iterations", "by_substep", "by_step", "skips", "steps", "patch_solves"})
    EXPECT_GT(seen[kind], 40) << kind;
}

TEST(StepPlan, IsThatOfAFreeClothAgainOnceAHeldParticleIsReleased) {
  BodySpec chain = hung_chain({0, 1, 0}, {1, 1, 0}, 10);
  chain.constraints = {stiff("distance", {"edges"})};
  Simulation simulation(scene_of({chain}, kEarth, 0.01, 2), {.threads = 1, .interactive = true});
  const StepPlan& plan = simulation.solver().step_plan();
  EXPECT_EQ(plan.solves, PatchSolves::ByStep);
  simulation.hold(5), simulation.step();
  EXPECT_TRUE(lists_stage(plan.substep, Stage::MoveHandles) &&
              lists_stage(plan.iteration, IterationStage::ProjectHandles));
  EXPECT_TRUE(!plan.fuses() && plan.recorded == Recorded::PatchSolves);
  simulation.release(5), simulation.step();
  EXPECT_EQ(text_of(plan.substep), "solve_substep");
  EXPECT_EQ(plan.recorded, Recorded::Steps);
}

struct Listed {
  std::string substep, iteration;
  std::string solves = "in_iterations", notes = "";  // s: skips contacts, r: steps are recorded
};

TEST(StepPlan, OfShippedScenes) {
  const std::string contacts = "detect_contacts iterate clamp_tunnelling update_state restitute";
  const std::string pressed = "detect_contacts start_pressures iterate clamp_tunnelling update_state restitute";
  const std::string guarded =
      "detect_contacts start_self_collision iterate clamp_tunnelling truncate_motion "
      "update_state restitute end_self_collision";
  const std::string carried =
      "move_pins damp predict detect_contacts correct_coarsely iterate clamp_tunnelling "
      "update_state restitute place_pins";
  const Listed balloon{"damp predict " + pressed, "solve_patches project_pressures solve_contacts"};
  const Listed rests{"predict " + contacts, "solve_patches solve_contacts", "in_iterations", "s"};
  const Listed cloths{"wind predict " + guarded, "solve_patches solve_self_contacts solve_contacts"};
  const Listed bent{"wind predict filter_bending correct_coarsely iterate update_state", "solve_patches",
                    "in_iterations", "r"};
  const Listed in_wind{"wind solve_substep", "", "by_substep", "r"}, alone{"solve_substep", "", "by_step", "r"};
  const std::map<std::string, Listed> lists{
      {"at_rest", balloon},
      {"balloon", balloon},
      {"balloon_high", balloon},
      {"balloon_low", balloon},
      {"bullets", {"predict " + contacts, "solve_contacts", "in_iterations", "s"}},
      {"cantilever", in_wind},
      {"carried_sheet", {carried, "solve_patches solve_contacts"}},
      {"closed_soft", balloon},
      {"closed_stiff", balloon},
      {"crossed_sheets", cloths},
      {"crumpled_ball",
       {"release_attachments wind predict " + guarded,
        "solve_patches project_attachments solve_self_contacts solve_contacts"}},
      {"desbrun_closed", {"damp predict " + contacts, "solve_contacts"}},
      {"desbrun_sheet", {"wind predict iterate update_state", "", "in_iterations", "r"}},
      {"drape_bunny", {"wind predict filter_bending " + guarded, "solve_patches solve_self_contacts solve_contacts"}},
      {"dressed",
       {"release_attachments damp predict " + guarded,
        "solve_patches project_attachments solve_self_contacts close_seams solve_contacts"}},
      {"flag", bent},
      {"folded_sheet", cloths},
      {"long_cloth", {"predict iterate update_state", "solve_patches project_long_range", "in_iterations", "r"}},
      {"oscillator", alone},
      {"pendulum", alone},
      {"pillow",
       {"damp predict detect_contacts start_self_collision start_pressures iterate clamp_tunnelling truncate_motion "
        "update_state restitute end_self_collision",
        "solve_patches project_pressures solve_self_contacts close_seams solve_contacts"}},
      {"ramp", rests},
      {"rotating_sphere", {"predict " + contacts, "solve_patches solve_contacts"}},
      {"sailcloth", bent},
      {"sheet_no_shear", in_wind},
      {"sheet_shear", in_wind},
      {"soft_bunny", {"damp wind predict " + contacts, "solve_patches solve_contacts"}},
      {"thin_wall", rests},
      {"torn_sheet", {"move_pins damp solve_substep place_pins", "", "by_substep"}},
      {"turning_flag", {carried, "solve_patches solve_contacts"}},
      {"wrapped_balloon",
       {"wind predict detect_contacts start_self_collision start_pressures iterate clamp_tunnelling truncate_motion "
        "update_state restitute end_self_collision",
        "solve_patches project_pressures solve_self_contacts solve_contacts"}},
  };
  for (const std::string& name : shipped_scenes()) {
    ASSERT_TRUE(lists.contains(name)) << name;
    const Listed& listed = lists.at(name);
    const StepPlan plan = Simulation(load_shipped(name), {.threads = 1}).solver().step_plan();
    EXPECT_EQ(text_of(plan.substep), listed.substep) << name;
    EXPECT_EQ(text_of(plan.iteration), listed.iteration) << name;
    EXPECT_EQ(name_of(plan.solves), listed.solves) << name;
    EXPECT_EQ(plan.skips_contacts, listed.notes.find('s') != std::string::npos) << name;
    EXPECT_EQ(plan.recorded == Recorded::Steps, listed.notes.find('r') != std::string::npos) << name;
  }
}

}  // namespace
}  // namespace malha
