// SPDX-License-Identifier: Apache-2.0
// The list of a step's stages (host/solver/step_plan.h): of the shipped scenes, and the rules that it keeps.
#include "host/solver/step_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
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
long find(const std::vector<Stage>& stages, Stage stage) {
  const auto at = std::ranges::find(stages, stage);
  return at == stages.end() ? -1 : at - stages.begin();
}
template <class Stage>
bool has(const std::vector<Stage>& stages, Stage stage) {
  return find(stages, stage) >= 0;
}
template <class Stage>
bool is_ordered(const std::vector<Stage>& stages, Stage first, Stage then) {
  return !has(stages, first) || !has(stages, then) || find(stages, first) < find(stages, then);
}

StepFeatures random_features(Random& random) {
  StepFeatures features;
  const auto toss = [&] { return random(0, 1) < 0.4; };
  features.position_based = toss(), features.filter = !features.position_based && toss();
  features.filtered_wind = features.filter && toss();
  features.batches = toss(), features.levels = features.position_based && toss();
  features.pressure = toss(), features.long_range = toss(), features.attachments = toss();
  features.attachments_change = features.attachments && toss(), features.pins_move = toss();
  features.contacts = toss(), features.objects_move = features.contacts && toss();
  features.edges = features.contacts && toss(), features.self_collision = toss();
  features.damping = toss(), features.wind = toss(), features.free_bodies = toss();
  features.host_ends_iterations = !features.position_based && toss();
  return features;
}

TEST(StepPlan, IsLegalWhateverASceneHasAndAUserDoes) {
  using I = IterationStage;
  Random random(1);
  std::map<PatchSolves, int> seen;
  for (int round = 0; round < 20000; ++round) {
    const StepFeatures features = random_features(random);
    const Interaction now{random(0, 1) < 0.2, random(0, 1) < 0.2, random(0, 1) < 0.2};
    const StepPlan plan = plan_step(features, now);
    const std::string what = text_of(plan.substep) + " / " + text_of(plan.iteration);
    ++seen[plan.solves];
    // Each stage comes once, in the one order.
    ASSERT_TRUE(std::ranges::is_sorted(plan.iteration)) << what;
    for (std::size_t i = 1; i < plan.substep.size(); ++i) ASSERT_NE(plan.substep[i], plan.substep[i - 1]) << what;
    // The state is predicted and updated once: by stages, or by the patch solves.
    ASSERT_NE(has(plan.substep, Stage::SolveSubstep), has(plan.substep, Stage::Predict)) << what;
    ASSERT_EQ(has(plan.substep, Stage::SolveSubstep), plan.fuses()) << what;
    for (const Stage stage : {Stage::Iterate, Stage::UpdateState})
      ASSERT_EQ(has(plan.substep, stage), has(plan.substep, Stage::Predict)) << what;
    ASSERT_TRUE(has(plan.substep, Stage::Iterate) || plan.iteration.empty()) << what;
    // Where patch solves do it all, nothing else moves particles between prediction and update.
    if (plan.fuses()) {
      for (const Stage stage : plan.substep)
        ASSERT_TRUE(stage < Stage::Predict || stage == Stage::SolveSubstep || stage > Stage::CompareMomenta) << what;
      ASSERT_FALSE(now.acts() || now.callback) << what;
    }
    // All substeps in one region leave nothing to do between them, and a region without contact tests likewise.
    if (plan.solves == PatchSolves::ByStep) {
      ASSERT_EQ(text_of(plan.substep), "solve_substep");
    }
    if (plan.skips_contacts) {
      ASSERT_EQ(text_of(plan.substep), "predict detect_contacts iterate clamp_tunnelling update_state restitute");
      ASSERT_TRUE(
          std::ranges::all_of(plan.iteration, [](I s) { return s == I::SolvePatches || s == I::SolveContacts; }));
    }
    // Contacts are found before they are solved, and guarded after that; each is there or not as a whole.
    for (const auto& [detect, solve, guard] :
         {std::tuple{Stage::DetectContacts, I::SolveContacts, Stage::ClampTunnelling},
          {Stage::StartSelfCollision, I::SolveSelfContacts, Stage::TruncateMotion},
          {Stage::DetectEdgeContacts, I::SolveEdgeContacts, Stage::TruncateMotion}}) {
      ASSERT_EQ(has(plan.substep, detect), has(plan.iteration, solve)) << what;
      if (has(plan.substep, detect)) {
        ASSERT_TRUE(has(plan.substep, guard)) << what;
      }
      ASSERT_TRUE(is_ordered(plan.substep, detect, Stage::Iterate) && is_ordered(plan.substep, Stage::Iterate, guard));
    }
    // The iteration ends with contacts, and of those meshes come last.
    if (features.contacts) {
      ASSERT_EQ(plan.iteration.back(), I::SolveContacts) << what;
    }
    // Momenta are compared over the same part of a step whether a user holds something or not.
    ASSERT_EQ(plan.momenta, plan_step(features).momenta) << what;
    ASSERT_EQ(has(plan.substep, Stage::MeasureMomenta), has(plan.substep, Stage::CompareMomenta)) << what;
    ASSERT_EQ(has(plan.iteration, I::MeasureMomenta), has(plan.iteration, I::CompareMomenta)) << what;
    // All of the wind acts in the prediction.
    if (features.wind) {
      ASSERT_TRUE(is_ordered(plan.substep, Stage::Wind, Stage::Predict) || has(plan.substep, Stage::PredictWind))
          << what;
    }
    // No recorded step asks the host, or depends on time.
    if (plan.recorded) {
      for (const Stage stage : {Stage::DetectContacts, Stage::StartSelfCollision, Stage::DetectEdgeContacts,
                                Stage::MovePins, Stage::MoveHandles, Stage::CallBack})
        ASSERT_FALSE(has(plan.substep, stage)) << what;
    }
    // A pass that cannot handle NaN makes the check come after each substep.
    if (has(plan.substep, Stage::DetectContacts) || has(plan.substep, Stage::StartSelfCollision) || now.callback) {
      ASSERT_TRUE(plan.finite_each_substep) << what;
    }
  }
  for (const PatchSolves solves : {PatchSolves::InIterations, PatchSolves::BySubstep, PatchSolves::ByStep})
    EXPECT_GT(seen[solves], 50) << name_of(solves);
}

TEST(StepPlan, OfAHeldParticleReturnsToTheOldOneOnRelease) {
  Random random(2);
  for (int round = 0; round < 1000; ++round) {
    const StepFeatures features = random_features(random);
    const StepPlan held = plan_step(features, {.handles = true}), free = plan_step(features);
    EXPECT_TRUE(has(held.substep, Stage::MoveHandles) && has(held.iteration, IterationStage::ProjectHandles));
    EXPECT_FALSE(has(free.substep, Stage::MoveHandles));
    EXPECT_FALSE(held.fuses() || held.recorded || held.skips_contacts);
  }
}

struct Listed {
  std::string substep, iteration;
  std::string solves = "in_iterations", notes = "";  // s: skips contacts, o: overlaps queries, r: recorded
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
  const Listed balloon{"damp predict " + pressed, "solve_patches project_pressures solve_contacts", "in_iterations",
                       "o"};
  const Listed rests{"predict " + contacts, "solve_patches solve_contacts", "in_iterations", "so"};
  const Listed cloths{"wind predict " + guarded, "solve_patches solve_self_contacts solve_contacts", "in_iterations",
                      "o"};
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
        "solve_patches project_attachments solve_self_contacts solve_contacts", "in_iterations", "o"}},
      {"desbrun_closed", {"damp predict " + contacts, "solve_contacts"}},
      {"desbrun_sheet", {"wind predict iterate update_state", "", "in_iterations", "r"}},
      {"drape_bunny", cloths},
      {"flag", in_wind},
      {"folded_sheet", cloths},
      {"long_cloth", {"predict iterate update_state", "solve_patches project_long_range", "in_iterations", "r"}},
      {"oscillator", alone},
      {"pendulum", alone},
      {"ramp", rests},
      {"rotating_sphere", {"predict " + contacts, "solve_patches solve_contacts", "in_iterations", "o"}},
      {"sheet_no_shear", in_wind},
      {"sheet_shear", in_wind},
      {"soft_bunny", {"damp wind predict " + contacts, "solve_patches solve_contacts", "in_iterations", "o"}},
      {"thin_wall", rests},
      {"torn_sheet", {"move_pins damp solve_substep place_pins", "", "by_substep"}},
      {"turning_flag", {carried, "solve_patches solve_contacts"}},
      {"wrapped_balloon",
       {"wind predict detect_contacts start_self_collision start_pressures iterate clamp_tunnelling truncate_motion "
        "update_state restitute end_self_collision",
        "solve_patches project_pressures solve_self_contacts solve_contacts", "in_iterations", "o"}},
  };
  for (const std::string& name : shipped_scenes()) {
    ASSERT_TRUE(lists.contains(name)) << name;
    const Listed& listed = lists.at(name);
    const StepPlan plan = Simulation(load_shipped(name), {.threads = 1}).solver().step_plan();
    EXPECT_EQ(text_of(plan.substep), listed.substep) << name;
    EXPECT_EQ(text_of(plan.iteration), listed.iteration) << name;
    EXPECT_EQ(name_of(plan.solves), listed.solves) << name;
    EXPECT_EQ(plan.skips_contacts, listed.notes.find('s') != std::string::npos) << name;
    EXPECT_EQ(plan.overlaps_queries, listed.notes.find('o') != std::string::npos) << name;
    EXPECT_EQ(plan.recorded, listed.notes.find('r') != std::string::npos) << name;
  }
}

}  // namespace
}  // namespace malha
