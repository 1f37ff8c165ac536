// SPDX-License-Identifier: Apache-2.0
// The solver thread of the window, tested without a window.
#include <gtest/gtest.h>

#include <cmath>

#include "host/report/warnings.h"
#include "malha/simulation.h"
#include "tests/support.h"
#include "tools/view/history.h"
#include "tools/view/scenes.h"
#include "tools/view/session.h"

namespace malha {
namespace {

using view::Session;
using view::Snapshot;

const std::string kSheet = MALHA_SOURCE_DIR "/scenes/sheet_shear.json";

Snapshot settled(Session& session) {
  session.wait_until_done();
  return session.snapshot();
}

void step(Session& session, int count) {
  for (int k = 0; k < count; ++k) session.step();
}

SimulationOptions two_threads() {
  SimulationOptions options;
  options.threads = 2;
  return options;
}

/// Particles fly free.
Scene thrown(double gravity, double dt) {
  Scene scene;
  scene.name = "thrown", scene.gravity = {0, gravity, 0}, scene.solver.dt = dt, scene.solver.substeps = 1;
  BodySpec body;
  body.name = "lattice", body.shape = LatticeShape{}, body.mass = 1;
  scene.bodies = {body};
  return scene;
}

TEST(ViewSession, ShowsTheSolversOwnBits) {
  Session session(two_threads());
  session.open(kSheet);
  step(session, 30);
  const Snapshot now = settled(session);
  Simulation simulation(load_scene(kSheet));
  for (int k = 0; k < 30; ++k) simulation.step();
  const std::vector<Vec3> x = simulation.positions();
  ASSERT_EQ(now.sides.at(0).frame->steps, 30);
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(now.sides[0].frame->x[i][k], float(x[i][k]));
}

TEST(ViewSession, RewindsAndGoesOnWithTheSameBits) {
  Session session(two_threads());
  session.open(MALHA_SOURCE_DIR "/scenes/torn_sheet.json");  // a scene that tears during the run
  step(session, 50);
  const auto far = settled(session).sides[0].frame;
  ASSERT_GT(far->x.size(), settled(session).moments[0]->frames[0]->x.size()) << "it tore";
  session.show(20);
  const Snapshot back = settled(session);
  EXPECT_EQ(back.sides[0].frame->steps, 20);
  EXPECT_EQ(back.moments.size(), 51u) << "looking forgets nothing";
  step(session, 30);
  const auto again = settled(session).sides[0].frame;
  EXPECT_EQ(again->steps, 50);
  EXPECT_EQ(again->x, far->x);
  session.reset();
  EXPECT_EQ(settled(session).sides[0].frame->steps, 0);
  step(session, 50);
  EXPECT_EQ(settled(session).sides[0].frame->x, far->x);
}

TEST(ViewSession, PullingLeavesItsMarkAndResetTakesItAway) {
  Session session(two_threads());
  session.open(kSheet);
  step(session, 40);
  const auto untouched = settled(session).sides[0].frame;
  session.reset();
  const Vec3 to{0.5, 0.5, 0.9};
  session.set_handle({0}, 150, to, false);
  step(session, 40);
  const Snapshot pulled = settled(session);
  const auto away = [&](const view::Frame& frame) {
    return std::hypot(frame.x[150][0] - to[0], frame.x[150][1] - to[1], frame.x[150][2] - to[2]);
  };
  EXPECT_LT(away(*pulled.sides[0].frame), 0.5 * away(*untouched));
  EXPECT_EQ(pulled.sides[0].handles.size(), 1u);
  session.reset();
  step(session, 40);
  EXPECT_EQ(settled(session).sides[0].frame->x, untouched->x);
  EXPECT_TRUE(settled(session).sides[0].handles.empty());
}

TEST(ViewSession, AHeldParticleStaysAndIsReleased) {
  Session session(two_threads());
  session.open_made(thrown(-10, 0.01));
  const auto start = settled(session).sides.at(0).frame->x[3];
  session.set_handle({0}, 3, {start[0], start[1], start[2]}, true);
  step(session, 20);
  EXPECT_EQ(settled(session).sides[0].frame->x[3], start);
  session.release({0}, 3);
  step(session, 10);
  // Ten steps of fall from rest: g dt^2 (1 + 2 + ... + 10).
  EXPECT_NEAR(settled(session).sides[0].frame->x[3][1], start[1] - 10 * 1e-4 * 55, 1e-5);
}

TEST(ViewSession, ChangedSettingsGoOnWhereItWas) {
  Session session(two_threads());
  session.open_made(thrown(-10, 0.01));
  step(session, 50);
  const auto before = settled(session).sides.at(0).frame;
  Scene scene = *settled(session).sides[0].scene;
  scene.gravity = {0, 0, 0}, scene.solver.dt = 0.005;
  session.change(0, scene);
  const auto after = settled(session).sides[0].frame;
  EXPECT_EQ(after->x, before->x);
  EXPECT_DOUBLE_EQ(after->time, before->time);
  EXPECT_EQ(after->steps, 100) << "half as long";
  step(session, 100);
  // It flies on uniformly with g t = 5 m/s, to float's rounding.
  EXPECT_NEAR(settled(session).sides[0].frame->x[0][1], before->x[0][1] - 5 * 0.5, 1e-4);
}

TEST(ViewSession, RefusesSettingsThatCannotBeAndGoesOn) {
  Session session(two_threads());
  session.open(kSheet);
  step(session, 5);
  Scene scene = *settled(session).sides.at(0).scene;
  scene.solver.dt = -1;
  session.change(0, scene);
  const Snapshot refused = settled(session);
  EXPECT_TRUE(refused.is_error);
  EXPECT_TRUE(has(refused.message, "/solver/dt: found -1; allowed: ")) << refused.message;
  EXPECT_EQ(refused.sides[0].frame->steps, 5);
  step(session, 1);
  EXPECT_EQ(settled(session).sides[0].frame->steps, 6);
}

TEST(ViewSession, WarningsGoWhenSettingsMendThem) {
  Session session(two_threads());
  Scene scene = load_scene(MALHA_SOURCE_DIR "/scenes/desbrun_sheet.json");
  scene.solver.dt = 0.2;  // beyond the stability limit that malha study stability measured
  session.open_made(scene);
  const std::vector<std::string> bold = settled(session).sides.at(0).warnings;
  scene = load_scene(MALHA_SOURCE_DIR "/scenes/desbrun_sheet.json");
  session.change(0, scene);
  const std::vector<std::string> careful = settled(session).sides[0].warnings;
  EXPECT_EQ(careful, warnings(build_model(scene)));
  EXPECT_NE(bold, careful);
}

TEST(ViewSession, TwoSidesGoInStepAndAreMeasured) {
  Session session(two_threads());
  session.open_made(thrown(0, 0.01));
  session.compare(thrown(-10, 0.0025));
  const Snapshot start = settled(session);
  ASSERT_EQ(start.sides.size(), 2u);
  EXPECT_EQ((*start.apart)[0], 0);
  step(session, 40);
  const Snapshot now = settled(session);
  EXPECT_DOUBLE_EQ(now.sides[0].frame->time, 0.4);
  EXPECT_DOUBLE_EQ(now.sides[1].frame->time, 0.4);
  EXPECT_EQ(now.sides[1].frame->steps, 160);
  // One side floats, the other falls: g dt^2 n (n + 1) / 2 of its 160 steps.
  const double fallen = 10 * 0.0025 * 0.0025 * 160 * 161 / 2;
  EXPECT_NEAR((*now.apart)[0], fallen, 1e-5);
  EXPECT_NEAR((*now.apart)[1], fallen, 1e-5);
  session.compare(std::nullopt);
  EXPECT_EQ(settled(session).sides.size(), 1u);
}

TEST(ViewSession, KeepsToRealTime) {
  Session session(two_threads());
  session.open_made(thrown(-10, 0.01));
  settled(session);
  session.set_pace(0.5);
  session.run(true);
  const auto from = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  session.run(false);
  const Snapshot now = settled(session);
  const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
  EXPECT_LE(now.sides.at(0).frame->time, 0.5 * passed + 0.011) << "a step ahead at most";
  EXPECT_GT(now.sides[0].frame->steps, 0);
}

TEST(ViewSession, AChangeKeepsWhatWasAndCanBeUndone) {
  Session session(two_threads());
  session.open(kSheet);
  step(session, 10);
  const Snapshot before = settled(session);
  Scene heavier = *before.sides.at(0).scene;
  heavier.gravity = {0, -30, 0};
  session.change(0, heavier);
  step(session, 10);
  const Snapshot changed = settled(session);
  ASSERT_EQ(changed.moments.size(), before.moments.size() + 11) << "that of the change, too";
  EXPECT_EQ(changed.sides[0].scene->gravity[1], -30);
  session.show(before.moments.size() - 1);
  EXPECT_EQ(settled(session).sides[0].scene->gravity, before.sides[0].scene->gravity);
  step(session, 10);
  const Snapshot undone = settled(session);
  EXPECT_EQ(undone.sides[0].scene->gravity, before.sides[0].scene->gravity);
  Simulation simulation(load_scene(kSheet));
  for (int k = 0; k < 20; ++k) simulation.step();
  const Vec3 x = simulation.positions()[150];
  for (int k = 0; k < 3; ++k) EXPECT_EQ(undone.sides[0].frame->x[150][k], float(x[k])) << "bit by bit";
}

TEST(ViewSession, SavesWhatIsShown) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene.json").string(), state = (folder / "state.malha").string();
  Session session(two_threads());
  session.open(kSheet);
  step(session, 12);
  session.show(5);
  session.save(0, scene, state);
  step(session, 1);
  EXPECT_EQ(settled(session).sides[0].frame->steps, 6) << "nothing is lost by saving";
  Simulation saved(load_scene(scene)), alone(load_scene(kSheet));
  saved.load_checkpoint(state);
  for (int k = 0; k < 5; ++k) alone.step();
  EXPECT_EQ(saved.steps(), 5);
  EXPECT_EQ(saved.state_hash(), alone.state_hash());
}

TEST(ViewSession, ARunThatDivergedSavesItsLastMoment) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene.json").string(), state = (folder / "state.malha").string();
  Session session(two_threads());
  Scene rush = thrown(-1e18, 1e10);
  rush.duration = 1e12;
  session.open_made(rush);
  step(session, 5);
  ASSERT_GE(settled(session).sides.at(0).diverged_particle, 0);
  session.save(0, scene, state);
  settled(session);
  Simulation saved(load_scene(scene));
  saved.load_checkpoint(state);
  EXPECT_EQ(saved.steps(), 2);
}

TEST(ViewSession, WhatIsRefusedStopsNothing) {
  Session session(two_threads());
  session.open(kSheet);
  const Snapshot start = settled(session);
  const int pin = int(start.sides.at(0).frame->body->pinned.at(0));
  session.run(true);
  session.set_handle({0}, pin, {0, 0, 0}, false);
  Scene wrong = *start.sides[0].scene;
  wrong.solver.substeps = 0;
  session.change(0, wrong);
  const Snapshot now = settled(session);
  EXPECT_TRUE(now.running);
  EXPECT_TRUE(has(now.message, "/solver/substeps: found 0")) << now.message;
  EXPECT_EQ(now.refused, start.refused + 1) << "so that what was typed goes";
}

TEST(ViewSession, AHandleTakesAParticleOfBothOrOfNone) {
  Session session(two_threads());
  session.open(kSheet);
  session.compare(load_scene(MALHA_SOURCE_DIR "/scenes/desbrun_sheet.json"));
  ASSERT_EQ(settled(session).sides.size(), 2u);
  session.set_handle({0, 1}, 150, {0, 0, 0}, true);  // which Desbrun's method cannot hold
  const Snapshot refused = settled(session);
  EXPECT_TRUE(refused.is_error);
  EXPECT_TRUE(refused.sides[0].handles.empty() && refused.sides[1].handles.empty());
  session.set_handle({0, 1}, 150, {0, 0, 0}, false);
  const Snapshot pulled = settled(session);
  EXPECT_TRUE(pulled.sides[0].handles.contains(150) && pulled.sides[1].handles.contains(150));
}

TEST(ViewSession, ShowsTheSubstepsOfAStep) {
  Session session(two_threads());
  Scene coarser = thrown(-10, 0.1), finer = coarser;
  coarser.solver.substeps = 4, finer.solver.substeps = 8;
  session.open_made(coarser);
  const float top = settled(session).sides.at(0).frame->x[0][1];
  session.substep();
  for (int k = 1; k < 4; ++k, session.substep()) {
    const Snapshot now = settled(session);
    const auto& frame = *now.sides.at(0).frame;
    EXPECT_EQ(frame.substep, k);
    EXPECT_EQ(frame.steps, 0);
    EXPECT_NEAR(frame.time, 0.025 * k, 1e-12);
    EXPECT_NEAR(frame.x[0][1] - top, -10 * 0.025 * 0.025 * k * (k + 1) / 2, 1e-6) << "speed first, then the place";
    session.set_visual_field(view::VisualField::Speed);  // looks only
  }
  const auto whole = settled(session).sides[0].frame;
  EXPECT_EQ(whole->substep, 0);
  EXPECT_EQ(whole->steps, 1);
  session.reset(), session.step();
  EXPECT_EQ(settled(session).sides[0].frame->x, whole->x);

  session.compare(finer), session.substep();
  const Snapshot two = settled(session);
  EXPECT_NEAR(two.sides.at(1).frame->time, 0.0125, 1e-12) << "the finer one goes first";
  EXPECT_EQ(two.sides[0].frame->time, 0);
  session.step();
  EXPECT_EQ(settled(session).sides[0].frame->steps, 2) << "from the end of the step that was begun";
}

TEST(ViewSession, ARunThatDivergesSaysWhereAndCanGoBack) {
  Scene scene = thrown(0, 1e18);
  scene.duration = 1e18;
  scene.bodies[0].velocity = {1e18, 0, 0};  // beyond the largest float, 3.4e38, after 340 steps
  Session session(two_threads());
  session.open_made(scene);
  step(session, 400);
  const Snapshot diverged = settled(session);
  ASSERT_GE(diverged.sides.at(0).diverged_particle, 0);
  EXPECT_TRUE(has(diverged.message, "diverged at step ")) << diverged.message;
  for (const view::Point3f& x : diverged.sides[0].frame->x) EXPECT_TRUE(std::isfinite(x[0] + x[1] + x[2]));
  session.reset();
  EXPECT_EQ(settled(session).sides[0].diverged_particle, -1);

  session.set_pace(0);
  session.run(true);
  const auto shown = [&] { return session.snapshot().sides.at(0).diverged_particle >= 0; };
  for (int k = 0; k < 1'000 && !shown(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(shown()) << "its end is shown though nobody asked for anything";
  EXPECT_FALSE(session.snapshot().running);
}

TEST(ViewHistory, KeepsToItsMemoryLimitAndTheFirstMoment) {
  constexpr std::size_t kRoom = 200'000;
  Session session(two_threads(), kRoom);
  session.open(kSheet);
  step(session, 300);
  const Snapshot now = settled(session);
  std::size_t bytes = 0;
  for (const auto& moment : now.moments) bytes += moment->bytes();
  EXPECT_LE(bytes, kRoom);
  EXPECT_GE(now.moments.size(), 4u);
  EXPECT_EQ(now.moments[0]->frames[0]->steps, 0);
  for (std::size_t k = 1; k < now.moments.size(); ++k)
    EXPECT_GT(now.moments[k]->frames[0]->time, now.moments[k - 1]->frames[0]->time);
}

TEST(ViewHistory, HasAtMostFourThousandMomentsAtEqualDistances) {
  view::History history(std::size_t{1} << 30);
  constexpr double kStep = 0.3;  // s, longer than 1/60
  for (int k = 0; k < 20'000; ++k) {
    if (!history.is_due(k * kStep)) continue;
    auto frame = std::make_shared<view::Frame>();
    frame->time = k * kStep;
    view::Moment moment;
    moment.frames.push_back(frame);
    history.add(std::move(moment), k * kStep);
    ASSERT_LE(history.moments().size(), 4'000u);
  }
  const auto& moments = history.moments();
  ASSERT_GE(moments.size(), 1'900u);
  EXPECT_EQ(moments[0]->frames[0]->time, 0);
  for (std::size_t k = 1; k < moments.size(); ++k)
    EXPECT_NEAR(moments[k]->frames[0]->time - moments[k - 1]->frames[0]->time, 8 * kStep, 1e-6);
}

TEST(ViewScenes, ABallFliesAsGravitySays) {
  Scene scene = load_scene(kSheet);
  view::throw_ball(scene, 2, {1, 2, 3}, {0, 5, 0}, 0.1), view::throw_ball(scene, 2, {1, 2, 3}, {0, 5, 0}, 0.1);
  ASSERT_EQ(scene.environment.size(), 2u);
  EXPECT_NE(scene.environment[0].name, scene.environment[1].name);
  for (const Keyframe& key : scene.environment[0].motion) {
    const double t = key.time - 2;
    EXPECT_NEAR(key.translate[1], 2 + 5 * t - 0.5 * 9.81 * t * t, 1e-9);
  }
  EXPECT_EQ(to_json(parse_scene(to_json(scene), "", "")), to_json(scene)) << "it can be saved";
}

TEST(ViewScenes, ADroppedMeshIsAClothAboveAFloor) {
  Session session(two_threads());
  session.open_made(view::scene_of_mesh(MALHA_SOURCE_DIR "/scenes/meshes/scans/bunny00.off"));
  const auto start = settled(session).sides.at(0).frame;
  step(session, 3);
  EXPECT_LT(settled(session).sides[0].frame->x[0][1], start->x[0][1]) << "it falls";
}

}  // namespace
}  // namespace malha
