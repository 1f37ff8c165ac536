// SPDX-License-Identifier: Apache-2.0
// The energy guard: energy that no force, pin or stored energy explains ends a run; explained energy does not, however
// sudden.
#include "host/solver/energy_guard.h"

#include <algorithm>
#include <cmath>

#include "host/base/point_array.h"
#include "host/solver/solver.h"
#include "tests/run_scenes.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// Steps for that long; the message of the run if it is ended.
std::string ended(const Scene& scene, double seconds, const SimulationOptions& options = {.threads = 1}) {
  try {
    after(scene, seconds, options);
  } catch (const Diverged& error) {
    return error.what();
  }
  return "";
}

/// A free shell of stiff springs by Desbrun's method, which does not carry on rounding errors: 170 km from the origin
/// float positions are 8 mm apart, and with 256 substeps displacements are lost in rounding. Springs respond to the
/// rounding and throw the particles about, at some 100 m/s that do not grow. Double resolves it.
Scene drowned_in_rounding(Precision precision, double mass = 1) {
  BodySpec shell;
  shell.name = "shell", shell.shape = SphereShape{0.5, 1}, shell.transform.translate = {1e5, 1e5, 1e5};
  shell.mass = mass, shell.spin = {0, 1, 0};
  shell.constraints = {stiff("distance", {"edges"})};
  Scene scene = scene_of({shell}, {0, 0, 0}, 1.0 / 60, 256, precision);
  scene.solver.type = "desbrun", scene.solver.desbrun.spring_constant = 6e7 * mass;  // k h^2 / m = 10
  return scene;
}

TEST(AnExplosion, EndsTheRunWhileItIsFiniteAndNamesStepPositionAndKind) {
  const std::string said = ended(drowned_in_rounding(Precision::Float), 2);
  EXPECT_TRUE(said.starts_with("step 32 (t = 0.533333 s): motion has ")) << said;
  EXPECT_TRUE(has(said, " times what anything gave it; fastest is particle ")) << said;
  EXPECT_TRUE(has(said, " of body 'shell' at (")) << said;
  EXPECT_TRUE(has(said, "of the constraints \"distance\" gained most")) << said;
  EXPECT_EQ(ended(drowned_in_rounding(Precision::Double), 0.6), "");
}

TEST(AnExplosion, IsReportedAlikeOnAnyNumberOfThreads) {
  const std::string expected = ended(drowned_in_rounding(Precision::Float), 0.6, {.backend = Backend::Serial});
  EXPECT_NE(expected, "");
  for (const int threads : {1, 2, 3})
    EXPECT_EQ(ended(drowned_in_rounding(Precision::Float), 0.6, {.threads = threads}), expected) << threads;
}

TEST(AnExplosion, IsNotHiddenByABodyThatIsFarAway) {
  Scene scene = drowned_in_rounding(Precision::Float);
  BodySpec chain = hung_chain({0, 0, 0}, {0.1, 0, 0}, 1, 0.01);
  chain.pins.clear(), chain.constraints = {stiff("distance", {"edges"})};
  scene.bodies.push_back(chain);
  EXPECT_TRUE(has(ended(scene, 0.6), " of body 'shell' at (")) << "173 km away: each body has its own size";
}

TEST(AnExplosion, IsNotHiddenByAHeavyBodyThatFlies) {
  // A body of a gram explodes beside one of a ton that is thrown at 10 m/s.
  Scene scene = drowned_in_rounding(Precision::Float, 1e-3);
  scene.bodies.push_back(particle({0, 0, 0}, {10, 0, 0}, 1000));
  EXPECT_TRUE(has(ended(scene, 0.6), " of body 'shell' at ("));
  std::swap(scene.bodies[0], scene.bodies[1]);
  EXPECT_TRUE(has(ended(scene, 0.6), " of body 'shell' at (")) << "in whatever order";
}

TEST(AnExplosion, IsNotHiddenByShortSteps) {
  // The same substeps, in steps of 1 ms: with a bound of 1 % of a metre in each, 10 m/s would pass unnoticed.
  Scene scene = drowned_in_rounding(Precision::Float);
  scene.solver.dt = 1e-3, scene.solver.substeps = 15;
  EXPECT_TRUE(has(ended(scene, 0.6), "times what anything gave it"));
}

TEST(AnExplosion, InTheLastStepsIsNotFinished) {
  const TemporaryFolder folder;
  const std::string file = folder.write("scene.json", to_json(drowned_in_rounding(Precision::Float)));
  const Ended ran = malha_command({"run", file, "--steps", "31", "--out", "out"}, folder / "");
  EXPECT_EQ(ran.status, 3) << ran.err;
  EXPECT_TRUE(has(ran.err, "step 31 (t = ")) << ran.err;
  EXPECT_EQ(Json::parse(bytes_of(folder / "out/report.json"))["status"], "diverged");
  EXPECT_FALSE(std::filesystem::exists(folder / "out/checkpoint.malha")) << "nobody should go on from there";
}

TEST(AnExplosion, LeavesAReportThatSaysSo) {
  const TemporaryFolder folder;
  const std::string file = folder.write("scene.json", to_json(drowned_in_rounding(Precision::Float)));
  const Ended ran = malha_command({"run", file, "--steps", "60", "--out", "out"}, folder / "");
  EXPECT_EQ(ran.status, 3) << ran.err;
  EXPECT_TRUE(has(ran.err, "times what anything gave it")) << ran.err;
  EXPECT_EQ(Json::parse(bytes_of(folder / "out/report.json"))["status"], "diverged");
}

/// One particle under the guard, whose state the test sets.
struct GuardedBody {
  Scene scene;
  Model model;
  PointArray<Serial, double> x, v, d;
  Array<Serial, double> w;
  EnergyGuard<Serial, double> guard;

  explicit GuardedBody(const Scene& of)
      : scene(of),
        model(build_model(of)),
        x(model.x),
        v(model.v),
        d(model.x.size()),
        w(model.w),
        guard(Serial{}, model) {}
  /// Tests whether the guard refuses this height (m) and speed (m/s), reached one step after a check.
  bool refuses(double height, double speed) {
    for (std::size_t i = 0; i < model.x.size(); ++i) x.set(i, {0, height, 0}), v.set(i, {speed, 0, 0});
    return guard
        .check(
            Particles<double>{model.count(), x.points(), v.points(), {x.points(), d.points(), {}}, w.data()},
            guard.every(), [this] { return x.download(); }, [this] { return v.download(); })
        .has_value();
  }
};

/// sqrt(kFactor) times the speed that is explained.
constexpr double kFaster = 10;

TEST(TheEnergyGuard, AcceptsTheEnergyOfAFall) {
  GuardedBody fall(scene_of({particle({0, 100, 0})}, kEarth, 1e-3));
  const double by_fall = std::sqrt(2 * 9.81 * 100);
  EXPECT_FALSE(fall.refuses(100, 0));
  EXPECT_FALSE(fall.refuses(0, 0.95 * kFaster * by_fall));
  EXPECT_TRUE(fall.refuses(0, 1.05 * kFaster * by_fall));
}

TEST(TheEnergyGuard, AcceptsTheEnergyOfAThrowAndOfALift) {
  GuardedBody thrown(scene_of({particle({0, 0, 0}, {0, 0, 7})}, {0, 0, 0}, 1e-3));
  EXPECT_FALSE(thrown.refuses(0, 0.95 * kFaster * 7));
  EXPECT_TRUE(thrown.refuses(0, 1.05 * kFaster * 7));
  GuardedBody lifted(scene_of({particle({0, 0, 0}, {0, 0, 7})}, kEarth, 1e-3));
  EXPECT_FALSE(lifted.refuses(50, 0)) << "whoever lifts it";
  EXPECT_FALSE(lifted.refuses(0, 0.95 * kFaster * std::sqrt(2 * 9.81 * 50 + 49)));
}

TEST(TheEnergyGuard, AcceptsTheEnergyStoredInSpringsAtTheStart) {
  // 1 N/m compressed by 0.5 m between 1 kg each: 0.125 J give both 0.354 m/s.
  BodySpec chain;
  chain.name = "chain", chain.shape = ChainShape{{0, 0, 0}, {1, 0, 0}, 1}, chain.mass = 2;
  chain.constraints = {compliant("distance", 1, {"edges"}, 1.5)};
  const double given = std::sqrt(0.125);
  // The steps are so large that 1 % of the body's size in one is negligible.
  Scene scene = scene_of({chain}, {0, 0, 0}, 1, 100);
  GuardedBody spring(scene);
  EXPECT_FALSE(spring.refuses(0, 0.95 * kFaster * given));
  EXPECT_TRUE(spring.refuses(0, 1.2 * kFaster * given));
}

TEST(TheEnergyGuard, AcceptsTheSpeedOfPinsAndWind) {
  Scene scene = scene_of({hung_chain({0, 0, 0}, {1, 0, 0}, 4)}, {0, 0, 0}, 1.0 / 60);
  scene.bodies[0].pins[0].motion = {Keyframe{0, {0, 0, 0}, {0, 1, 0}, 0}, Keyframe{0.5, {10, 0, 0}, {0, 1, 0}, 0}};
  const Model model = build_model(scene);
  EXPECT_NEAR(fastest_driven(model, 1.0 / 600), 20, 1e-12) << "10 m in half a second";
  scene.bodies[0].pins[0].motion[1] = Keyframe{0.5, {0, 0, 0}, {0, 1, 0}, 360};
  EXPECT_NEAR(fastest_driven(build_model(scene), 1.0 / 600), 4 * kPi, 1e-9) << "a turn of 1 m in half a second";
  scene.wind = Wind{{30, 40, 0}, 0.1, 0, 1.2, 1.2};
  EXPECT_NEAR(fastest_driven(build_model(scene), 1.0 / 600), 50, 1e-12);
}

TEST(TheEnergyGuard, AcceptsTheRecoveryOfBodiesStretchedInflatedAndTurnedInsideOut) {
  // Ten times too long, twice the volume at once: stiff, and so as fast as can be.
  BodySpec chain;
  chain.name = "chain", chain.shape = ChainShape{{0, 0, 0}, {1, 0, 0}, 8}, chain.mass = 1;
  chain.constraints = {stiff("distance", {"edges"}, 1, 10)};
  EXPECT_EQ(ended(scene_of({chain}, {0, 0, 0}, 1.0 / 60, 10), 2), "");
  BodySpec balloon;
  balloon.name = "balloon", balloon.shape = SphereShape{0.5, 2}, balloon.mass = 0.1;
  balloon.constraints = {compliant("distance", 0.01, {"edges"}), stiff("pressure", {}, 1, 8)};
  EXPECT_EQ(ended(scene_of({balloon}, {0, 0, 0}, 1.0 / 60, 10), 2), "");
}

TEST(TheEnergyGuard, AcceptsTheReleaseOfWhatPinsPulled) {
  // The body is pulled to three times its length within a second, and released: springs release the work of the pins.
  Scene scene = scene_of({hung_chain({0, 0, 0}, {1, 0, 0}, 8, 0.01)}, {0, 0, 0}, 1.0 / 60, 10);
  scene.bodies[0].constraints = {compliant("distance", 1e-4, {"edges"})};
  Pin end{ListPin{{8}}};
  end.motion = {Keyframe{0, {0, 0, 0}, {0, 1, 0}, 0}, Keyframe{1, {2, 0, 0}, {0, 1, 0}, 0}};
  end.release_time = 1.5;
  scene.bodies[0].pins.push_back(end);
  EXPECT_EQ(ended(scene, 4), "");
}

TEST(TheEnergyGuard, AcceptsTheShotOfABowWheneverItWasDrawn) {
  // The bow is drawn slowly and released between two checks: the work of the pin is accounted for all the same.
  for (const double drawn : {2.0, 2.1, 2.2}) {
    BodySpec bow;
    bow.name = "bow", bow.shape = ChainShape{{0, 0, 0}, {1.2, 0, 0}, 20}, bow.mass = 0.02;
    bow.constraints = {compliant("distance", 2e-4, {"edges"})};
    Pin hand{ListPin{{10}}};
    hand.motion = {Keyframe{0, {0, 0, 0}}, Keyframe{drawn, {0, 0, 0}}, Keyframe{drawn + 1.8, {0, 0, 1}}};
    hand.release_time = drawn + 2;
    bow.pins = {ListPin{{0}}, ListPin{{20}}, hand};
    EXPECT_EQ(ended(scene_of({bow}, kEarth, 1.0 / 60, 10, Precision::Float), 6), "") << drawn;
  }
}

TEST(TheEnergyGuard, AcceptsTheImpactOfAHeavyBodyOnALightOne) {
  // The bodies may touch, so that each may have the energy given to the other.
  BodySpec heavy, light;
  heavy.name = "heavy", heavy.shape = GridShape{{0.1, 0.1}, {4, 4}}, heavy.mass = 100, heavy.velocity = {0, -10, 0};
  heavy.transform.translate = {0.01, 0.2, 0.013};
  light.name = "light", light.shape = GridShape{{0.1, 0.1}, {3, 3}}, light.mass = 1e-3;
  heavy.constraints = light.constraints = {stiff("distance", {"edges", "shear"})};
  Scene scene = scene_of({heavy, light}, {0, 0, 0}, 1.0 / 60, 10, Precision::Double);
  scene.self_collision = SelfCollision{0.005, 0, {}};
  EXPECT_EQ(ended(scene, 1), "");
  double down = 0;  // mean downward speed of the light body's 16 particles, m/s, which come last
  const std::vector<Vec3> v = after(scene, 1).velocities();
  for (std::size_t i = v.size() - 16; i < v.size(); ++i) down -= v[i][1] / 16;
  EXPECT_GT(down, 9) << "it was hit";
}

TEST(TheEnergyGuard, ChangesNoBits) {
  // 16 steps come before the first check; 64 with the same substeps are checked twice.
  Scene coarse = scene_of({tumbling_ellipsoid(1, {stiff("distance", {"edges"})})}, kEarth, 1.0 / 16, 40);
  Scene fine = coarse;
  fine.solver.dt = 1.0 / 64, fine.solver.substeps = 10;  // the same substeps, to the bit
  const std::vector<Vec3> a = after(coarse, 1).positions(), b = after(fine, 1).positions();
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i], b[i]);
}

}  // namespace
}  // namespace malha
