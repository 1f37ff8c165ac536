// SPDX-License-Identifier: Apache-2.0
// Edits that lay a simulation out anew: one that throws leaves the simulation as it was.
#include <gtest/gtest.h>

#include <functional>

#include "host/solver/solver.h"
#include "host/solver/test_executor_hook.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// An edit, which `torn`, the same simulation a second later, may help to make.
struct FailingEdit {
  std::string name;
  std::function<void(Simulation& simulation, const Simulation& torn)> edit;
  bool refused = false;      // by its own check; else making the new solver throws
  bool step = false;         // it is a step, which has advanced when its tears fail
  std::string type = "pbd";  // of the solver
  friend void PrintTo(const FailingEdit& edit, std::ostream* out) { *out << edit.name; }
};

/// A strip that hangs in front of a bare particle, and that a moving pin pulls apart.
Scene strip_pulled_apart(const std::string& type) {
  BodySpec strip;
  strip.name = "strip", strip.mass = 0.2, strip.shape = GridShape{{1, 2}, {10, 20}}, strip.tear = Tear{0.4};
  strip.constraints = {compliant("distance", 1e-3, {"edges", "shear"})};
  Pin end(RowPin{true});
  end.motion = {{0, {}, {0, 1, 0}, 0}, {1, {0, 0, 2}, {0, 1, 0}, 0}};
  strip.pins = {RowPin{false}, end};
  Scene scene = scene_of({strip, particle({5, 0, 0})}, kEarth, 0.01, 4);
  scene.solver.type = type;
  if (type == "pbd") scene.solver.levels = 2;
  return scene;
}

class ThrowFromMakeSolver {
 public:
  ThrowFromMakeSolver() {
    make_solver_hook = [](const Model&, int) -> std::unique_ptr<Solver> { throw InputError("no solver"); };
  }
  ~ThrowFromMakeSolver() { make_solver_hook = before_; }
  ThrowFromMakeSolver(const ThrowFromMakeSolver&) = delete;
  ThrowFromMakeSolver& operator=(const ThrowFromMakeSolver&) = delete;

 private:
  decltype(make_solver_hook) before_ = make_solver_hook;
};

class Rebuild : public testing::TestWithParam<FailingEdit> {};

TEST_P(Rebuild, ThatThrowsLeavesTheSimulationAsItWas) {
  const FailingEdit& failing = GetParam();
  const Scene scene = strip_pulled_apart(failing.type);
  const SimulationOptions options{.threads = 1, .interactive = true};
  Simulation torn(scene, options);
  while (torn.tears() == 0 && torn.time() < 1) torn.step();
  ASSERT_GT(torn.tears(), 0);
  ASSERT_EQ(torn.solver().facts().levels.empty(), failing.type != "pbd");
  const auto just_before_it_tears = [&] {
    Simulation simulation(scene, options);
    simulation.pull(231, {5, 1, 0}, 1e-2);
    while (simulation.steps() + 1 < torn.steps()) simulation.step();
    return simulation;
  };
  Simulation simulation = just_before_it_tears(), twin = just_before_it_tears();
  run_for(torn, scene, 0.1);

  const auto edit = [&] { failing.edit(simulation, torn); };
  if (failing.refused) {
    EXPECT_NE(refusal(edit), "");
  } else {
    const ThrowFromMakeSolver hook;
    EXPECT_EQ(refusal(edit), "no solver");
  }
  EXPECT_EQ(simulation.tears(), 0);
  EXPECT_EQ(simulation.pins(), twin.pins());
  EXPECT_EQ(simulation.handles().size(), 1u);
  if (failing.step) {
    EXPECT_EQ(simulation.steps(), twin.steps() + 1);
    twin.step();
  } else {
    EXPECT_EQ(simulation.state_hash(), twin.state_hash());
    EXPECT_TRUE(simulation.save_state() == twin.save_state());
  }
  for (int step = 0; step < 3; ++step) {
    simulation.step(), twin.step();
    EXPECT_EQ(simulation.state_hash(), twin.state_hash()) << step;
  }
  EXPECT_GT(simulation.tears(), 0);
  EXPECT_EQ(simulation.handles()[0].particle, twin.handles()[0].particle);
  EXPECT_TRUE(simulation.save_state() == twin.save_state());
}

void cut_across(Simulation& simulation, const Simulation&) {
  std::vector<Edge> crossed;
  for (int i = 0; i < 11; ++i) crossed.push_back({110 + i, 121 + i});
  simulation.cut(crossed);
}
void pin_a_corner(Simulation& simulation, const Simulation&) { simulation.set_pins({0, 10}); }

INSTANTIATE_TEST_SUITE_P(
    Edits, Rebuild,
    testing::Values(
        FailingEdit{"Tear", [](Simulation& of, const Simulation&) { of.step(); }, false, true},
        FailingEdit{"TearOfDesbrun", [](Simulation& of, const Simulation&) { of.step(); }, false, true, "desbrun"},
        FailingEdit{"Cut", cut_across}, FailingEdit{"CutOfDesbrun", cut_across, false, false, "desbrun"},
        FailingEdit{"Pins", pin_a_corner},
        FailingEdit{"PinsOfNoParticle",
                    [](Simulation& of, const Simulation&) {
                      of.set_pins({0, 232});
                    },
                    true},
        FailingEdit{"Gravity",
                    [](Simulation& of, const Simulation&) {
                      of.set_gravity({0, 0, 1});
                    }},
        FailingEdit{"Restore", [](Simulation& of, const Simulation& torn) { of.restore_state(torn.save_state()); }},
        FailingEdit{"RestoreOfADamagedState",
                    [](Simulation& of, const Simulation& torn) {
                      const std::string state = torn.save_state();
                      of.restore_state(state.substr(0, state.size() - 1));
                    },
                    true},
        FailingEdit{"Checkpoint",
                    [](Simulation& of, const Simulation& torn) {
                      const TemporaryFolder folder;
                      torn.save_checkpoint(folder / "c");
                      of.load_checkpoint(folder / "c");
                    }},
        FailingEdit{"Transfer", [](Simulation& of, const Simulation& torn) { of.transfer_state_from(torn); }}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace malha
