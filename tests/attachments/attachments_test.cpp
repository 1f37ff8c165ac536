// SPDX-License-Identifier: Apache-2.0
// Attachments of particles to fixed points, to points on a path, and to rigidly moving meshes.
#include <gtest/gtest.h>

#include "host/attachments/pose.h"
#include "host/report/plan.h"
#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

Attachment tied(const Selector& at, std::optional<double> compliance = std::nullopt) {
  Attachment attachment;
  attachment.at = at, attachment.compliance = compliance;
  return attachment;
}

/// A particle of 2 kg on a spring of 800 N/m (omega = 20/s) to a point that leaves at speed u at t = 0:
/// x = u t - u / omega sin(omega t), of an amplitude of 5 cm.
Scene driven(int substeps, int iterations) {
  BodySpec body = particle({0, 0, 0}, {}, 2);
  body.attachments = {tied(ListPin{{0}}, 1.0 / 800)};
  body.attachments[0].motion = {{0, {}, {0, 1, 0}, 0}, {10, {10, 0, 0}, {0, 1, 0}, 0}};
  Scene scene = scene_of({body}, {0, 0, 0}, 0.01, substeps);
  scene.solver.iterations = iterations;
  return scene;
}

double worst_error(const Scene& scene) {
  Simulation simulation(scene, {.threads = 1});
  double worst = 0;
  for (int step = 0; step < 100; ++step) {
    simulation.step();
    const double t = simulation.time();
    worst = std::max(worst, std::abs(simulation.positions()[0][0] - (t - std::sin(20 * t) / 20)));
  }
  return worst;
}

TEST(Attachments, OnACompliantSpringFollowTheDrivenOscillator) {
  // Backward Euler damps at omega^2 h / 2: after a second at h = 1e-4 two per cent of the 5 cm, and half at half the h.
  const double coarse = worst_error(driven(100, 1)), fine = worst_error(driven(200, 1));
  EXPECT_LT(coarse, 0.05 * 0.025);
  EXPECT_NEAR(coarse / fine, 2, 0.1);
}

TEST(Attachments, AreAsCompliantWithManyIterationsAsWithOne) {
  EXPECT_NEAR(worst_error(driven(20, 1)), worst_error(driven(20, 5)), 1e-12);
}

TEST(Attachments, HangByTheirSpring) {
  // In rest length 0 a spring carries the weight at m g alpha below its point.
  BodySpec body = particle({0, 0, 0}, {}, 2);
  body.attachments = {tied(ListPin{{0}}, 1.0 / 800)};
  body.attachments[0].point = {{3, 1, 0}};
  const Scene scene = scene_of({body}, kEarth, 1.0, 1);  // a step of a second: implicit, and so at rest soon
  const Simulation simulation = after(scene, 30);
  const Vec3 x = simulation.positions()[0];
  EXPECT_NEAR(x[0], 3, 1e-9);
  EXPECT_NEAR(x[1], 1 - 2 * 9.81 / 800, 1e-9);
  EXPECT_NEAR(simulation.measure().elastic, std::pow(2 * 9.81, 2) / 800 / 2, 1e-9);
}

/// A particle on an attachment to a point at rest in the moving frame stays at that point: with steps of a second a lag
/// of one substep would be 2 m.
TEST(Attachments, OnACompliantSpringDoNotLagBehindASteadyPoint) {
  BodySpec body = particle({0, 0, 0}, {}, 2);
  body.attachments = {tied(ListPin{{0}}, 1.0 / 800)};
  body.attachments[0].motion = {{0, {}, {0, 1, 0}, 0}, {50, {100, 0, 0}, {0, 1, 0}, 0}};
  EXPECT_NEAR(after(scene_of({body}, {0, 0, 0}, 1.0, 1), 40).positions()[0][0], 80, 1e-9);
}

TEST(Attachments, RigidOnesAreAtTheirPointAndEndWhenTheyShould) {
  BodySpec body = particle({0, 0, 0});
  body.attachments = {tied(ListPin{{0}})};
  body.attachments[0].motion = {{0, {}, {0, 1, 0}, 0}, {1, {2, 0, 0}, {0, 1, 0}, 0}};
  body.attachments[0].release_time = 0.5;
  const Scene scene = scene_of({body}, {0, 0, 0}, 0.01, 2, Precision::Float);
  EXPECT_NEAR(after(scene, 0.4).positions()[0][0], 0.8, 1e-6);
  body.attachments[0].release_time.reset();
  EXPECT_NEAR(after(scene, 0.9).positions()[0][0], 1.8, 1e-4) << "goes on at 2 m/s";
}

TEST(Attachments, TenKilometresFarTheyAreAsGood) {
  BodySpec body = particle({10000, 0, 0});
  body.attachments = {tied(ListPin{{0}}, 1e-4)};
  const Simulation simulation = after(scene_of({body}, kEarth, 0.01, 10, Precision::Float), 2);
  EXPECT_NEAR(simulation.positions()[0][0], 10000, 1e-2);
  EXPECT_NEAR(simulation.positions()[0][1], -9.81e-4, 1e-4) << "what backward Euler leaves of the swing after 2 s";
}

/// A sheet of which one side is tied to a turning, climbing box beside it.
Scene tied_to_a_mesh(const std::string& solver = "pbd") {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.2;
  sheet.shape = GridShape{{1, 1}, {6, 6}};
  sheet.constraints = {stiff("distance", {"edges", "shear"})};
  sheet.attachments = {tied(RowPin{})};
  sheet.attachments[0].environment = "box";
  EnvironmentSpec box;
  box.name = "box", box.shape = BoxShape{{1, 0.2, 0.2}, {{1, 1, 1}}};
  box.transform.translate = {0.5, 0, -0.2};
  box.motion = {{0, {0, 0.1, 0}, {0, 1, 0}, 5}, {1, {0, 0.3, 0}, {0, 1, 0}, 150}};
  Scene scene = scene_of({sheet}, kEarth, 0.01, 4, Precision::Double);
  scene.solver.type = solver;
  scene.environment = {box};
  return scene;
}

TEST(Attachments, ToATurningMeshKeepTheirPlaceInItsFrame) {
  for (const std::string solver : {"pbd", "desbrun"}) {
    const Scene scene = tied_to_a_mesh(solver);
    Simulation simulation(scene, {.threads = 1});
    const std::vector<Vec3> start = simulation.positions();
    const std::vector<Keyframe>& motion = scene.environment[0].motion;
    run_for(simulation, scene, 0.6);
    for (int i = 0; i < 7; ++i) {
      const Vec3 x = simulation.positions()[i], a = start[i];
      const Vector3<double> now = to_local(pose_at(motion, simulation.time()), {x[0], x[1], x[2]}),
                            then = to_local(pose_at(motion, 0), {a[0], a[1], a[2]});
      EXPECT_NEAR(now.x, then.x, 1e-9) << solver;
      EXPECT_NEAR(now.y, then.y, 1e-9) << solver;
      EXPECT_NEAR(now.z, then.z, 1e-9) << solver;
    }
  }
}

TEST(Attachments, ArePlannedAndReported) {
  Scene scene = tied_to_a_mesh();
  EXPECT_NE(plan(Simulation(scene, {.threads = 1})).find("\n  count 7, environment box, keyframes 2\n"),
            std::string::npos)
      << "rigidly tied is pinned";
  scene.bodies[0].attachments[0].compliance = 1e-5;
  const Simulation simulation(scene, {.threads = 1});
  const std::string text = plan(simulation);
  EXPECT_NE(text.find("\n  attachment: count 7, compliance 1e-05, environment box, keyframes 2\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("\n  attachments: 4\n"), std::string::npos) << text;
  EXPECT_NE(simulation.report("finished").find("\"attachment\""), std::string::npos);
}

std::string tie_refusal(Scene scene) {
  scene.file = "s.json";
  return refusal([&] { Simulation(scene, {.threads = 1}); });
}

TEST(Attachments, ToWhatIsNotThereAreRefused) {
  Scene scene = tied_to_a_mesh();
  scene.bodies[0].attachments[0].environment = "bux";
  EXPECT_EQ(tie_refusal(scene),
            "s.json: /bodies/0/attachments/0/to/environment: found unknown environment object 'bux' (did you mean "
            "'box'?); allowed: box");
  scene.environment.clear();
  EXPECT_EQ(
      tie_refusal(scene),
      "s.json: /bodies/0/attachments/0/to/environment: found unknown environment object 'bux'; allowed: one of the "
      "scene's environment, which has none");
  scene = tied_to_a_mesh();
  scene.bodies[0].attachments[0].at = SpherePin{{9, 9, 9}, 1};
  EXPECT_EQ(
      tie_refusal(scene),
      "s.json: /bodies/0/attachments/0/at: found no particle there; allowed: an attachment of a particle (rows are "
      "for grids and chains, rims for meshes that are not closed)");
  scene = tied_to_a_mesh();
  scene.bodies[0].pins = {RowPin{}};
  EXPECT_EQ(
      tie_refusal(scene),
      "s.json: /bodies/0/attachments/0: found particle 0, which another pin or rigid attachment holds too; allowed: "
      "one for a particle that moves or is released");
  scene.bodies[0].attachments[0].stiffness = 0.5;
  EXPECT_EQ(tie_refusal(scene),
            "s.json: /bodies/0/attachments/0/at: found pinned particles alone; allowed: at least one that can move");
}

INSTANTIATE_TEST_SUITE_P(Attachments, SameBits,
                         testing::Values(SameBitsScene{"ReleasedAndCompliant",
                                                       [](const auto&) {
                                                         Scene scene = tied_to_a_mesh();
                                                         Attachment& tie = scene.bodies[0].attachments[0];
                                                         tie.compliance = 1e-4;
                                                         tie.release_time = 0.2;
                                                         scene.solver.iterations = 2;
                                                         return scene;
                                                       },
                                                       30,
                                                       {10, 25}}),
                         name_of_scene);

}  // namespace
}  // namespace malha
