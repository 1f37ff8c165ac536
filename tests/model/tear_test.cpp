// SPDX-License-Identifier: Apache-2.0
// Tearing: which vertices split, along which plane, and what stays unchanged.
#include "host/model/tear.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "host/mesh/topology.h"
#include "host/run/run.h"
#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/same_bits.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A strip of cloth in the plane y = 0, pinned at z = 0, whose other side moves along z to a strain of `strain` in a
/// second.
Scene pulled(double strain, std::array<int, 2> cells = {4, 8}, double limit = 0.5) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.2;
  sheet.shape = GridShape{{1, 2}, cells};
  sheet.constraints = {compliant("distance", 1e-3, {"edges", "shear"}), compliant("bending", 0.1)};
  Pin end(RowPin{true});
  end.motion = {{0, {}, {0, 1, 0}, 0}, {1, {0, 0, 2 * strain}, {0, 1, 0}, 0}};
  sheet.pins = {RowPin{false}, end};
  sheet.damping = 0.1;
  sheet.tear = Tear{limit};
  return scene_of({sheet}, {0, 0, 0}, 0.01, 4, Precision::Float);
}

double mass_of(const Simulation& simulation, int& pinned) {
  double sum = 0;
  pinned = 0;
  for (const double w : simulation.model().w) w > 0 ? sum += 1 / w : ++pinned;
  return sum;
}

TEST(Tearing, HappensAboveTheLimitAndNotBelow) {
  EXPECT_EQ(after(pulled(0.1), 1).tears(), 0) << "waves that nothing damps stretch it by more, here and there";
  EXPECT_GT(after(pulled(0.9), 1).tears(), 0);
}

TEST(Tearing, GoesOnBesideEdgesOfTheEnvironmentAndFromItsCheckpoints) {
  Scene scene = pulled(0.9);
  for (const bool moves : {false, true}) {  // a rod at rest, and a rod that moves
    EnvironmentSpec rod;
    rod.name = moves ? "comes" : "lies", rod.shape = BoxShape{{1, 0.1, 0.1}, {{1, 1, 1}}}, rod.edges = true;
    rod.transform.translate = {0.5, moves ? -0.4 : -0.1, 1};
    if (moves) rod.motion = {{0, {}, {0, 1, 0}, 0}, {1, {0, 0.4, 0.1}, {0, 1, 0}, 20}};
    scene.environment.push_back(rod);
  }
  Simulation whole(scene, {.threads = 1});
  const TemporaryFolder folder;
  for (int step = 0; step < 100; ++step) {
    if (step % 20 == 0) whole.save_checkpoint(folder / std::to_string(step));
    whole.step();
  }
  EXPECT_GT(whole.tears(), 0);
  for (int from = 0; from < 100; from += 20) {
    Simulation resumed(scene, {.threads = 1});
    resumed.load_checkpoint(folder / std::to_string(from));
    while (resumed.steps() < 100) resumed.step();
    EXPECT_EQ(resumed.state_hash(), whole.state_hash()) << "from step " << from;
  }
}

TEST(Tearing, OfARopeCutsIt) {
  BodySpec rope = hung_chain({0, 0, 0}, {4, 0, 0}, 4);
  rope.constraints = {stiff("distance", {"edges"})};
  Pin end(RowPin{true});
  end.motion = {{0, {}, {0, 1, 0}, 0}, {1, {4, 0, 0}, {0, 1, 0}, 0}};
  rope.pins.push_back(end);
  rope.tear = Tear{0.2};
  const Scene scene = scene_of({rope}, {0, 0, 0}, 0.01, 10);
  Simulation simulation = after(scene, 1);
  EXPECT_EQ(simulation.tears(), 1) << "then nothing is pulled any more";
  EXPECT_EQ(simulation.positions().size(), 6u);
  EXPECT_LT(simulation.measure().strain_max, 0.2);
}

TEST(Tearing, SplitsAVertexAlongThePlaneThroughItThatIsPerpendicularToTheEdge) {
  Scene scene = pulled(0, {2, 4});  // 3 x 5 particles half a metre apart, x fastest
  const Model model = build_model(scene);
  std::vector<Vec3> x = model.render_mesh.points;
  for (std::size_t i = 9; i < x.size(); ++i) x[i][2] += 0.4;  // rows 3 and 4 away from row 2: strained by 0.8
  const std::vector<Split> splits = find_tears(model, x, pinned_now(model, 0));
  // Row 2 is particles 6, 7, 8; 7 cannot split in the step in which 6 does. The faces between rows 1 and 2 lie behind
  // the plane of each.
  ASSERT_EQ(splits.size(), 2u);
  EXPECT_EQ(splits[0].vertex, 6);
  EXPECT_EQ(splits[0].faces, std::vector<int>{2});
  EXPECT_EQ(splits[1].vertex, 8);
  EXPECT_EQ(splits[1].faces, std::vector<int>{3});
  EXPECT_TRUE(find_tears(model, model.render_mesh.points, pinned_now(model, 0)).empty());
}

TEST(Tearing, KeepsMassAndRestLengths) {
  const Scene scene = pulled(0.9);
  Simulation simulation(scene, {.threads = 1});
  int pinned = 0, still_pinned = 0;
  const double mass = mass_of(simulation, pinned);
  const std::size_t faces = simulation.model().render_mesh.faces.size();
  run_for(simulation, scene, 1);
  ASSERT_GT(simulation.tears(), 0);
  EXPECT_NEAR(mass_of(simulation, still_pinned), mass, 1e-14);
  EXPECT_EQ(still_pinned, pinned) << "pins do not tear";
  EXPECT_EQ(simulation.model().render_mesh.faces.size(), faces);
  EXPECT_EQ(simulation.positions().size(), 45u + simulation.tears());
}

TEST(Tearing, KeepsMomentumAndEnergyOfMotion) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.mass = 0.5;
  sheet.shape = GridShape{{1, 1}, {8, 8}};
  sheet.constraints = {compliant("distance", 1e-2, {"edges", "shear"})};
  sheet.velocity = {1, 2, 3}, sheet.spin = {0, 30, 0};
  sheet.tear = Tear{0.3};
  const Scene scene = scene_of({sheet}, {0, 0, 0}, 0.002, 4);
  Scene firm = scene;
  firm.bodies[0].tear.reset();
  Simulation simulation(scene, {.threads = 1}), twin(firm, {.threads = 1});
  while (simulation.tears() == 0 && simulation.time() < 1) simulation.step(), twin.step();
  ASSERT_GT(simulation.tears(), 0) << "centrifugal forces tear it";
  const Measures torn = simulation.measure(), whole = twin.measure();
  EXPECT_NEAR(torn.kinetic, whole.kinetic, 1e-12);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(torn.momentum[k], whole.momentum[k], 1e-12);
    EXPECT_NEAR(torn.angular_momentum[k], whole.angular_momentum[k], 1e-12);
  }
  run_for(simulation, scene, 0.04);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(simulation.measure().momentum[k], 0.5 * scene.bodies[0].velocity[k], 1e-11);
}

TEST(Tearing, LaysOutTheTornMeshAsAnyOther) {
  const Scene scene = pulled(0.9);
  const Simulation simulation = after(scene, 1);
  const Model& model = simulation.model();
  const Mesh torn = body_mesh(model.render_mesh, 0);
  // Every edge and diagonal with a movable end is a distance constraint, once.
  std::set<std::pair<int, int>> expected, found;
  std::vector<int> solver_of(model.user_index.size());
  for (std::size_t i = 0; i < solver_of.size(); ++i) solver_of[model.user_index[i]] = static_cast<int>(i);
  for (const auto& list : {edges(torn), shear(torn)})
    for (const Edge& e : list)
      if (model.w[solver_of[e[0]]] + model.w[solver_of[e[1]]] > 0)
        expected.insert(std::minmax(solver_of[e[0]], solver_of[e[1]]));
  const std::vector<int>& ends = model.sets.at(0).particles;
  for (std::size_t c = 0; c < ends.size(); c += 2) EXPECT_TRUE(found.insert(std::minmax(ends[c], ends[c + 1])).second);
  EXPECT_EQ(found, expected);
}

TEST(Tearing, WorksByDesbrunsMethodWhichIsFactoredAnew) {
  Scene scene = pulled(0.9);
  scene.solver.type = "desbrun", scene.solver.substeps = 1, scene.solver.iterations = 10;
  const Simulation simulation = after(scene, 1);
  EXPECT_GT(simulation.tears(), 0);
  EXPECT_EQ(simulation.solver().facts().filter->unknowns, 45 - 10 + simulation.tears());
}

TEST(Tearing, OfTheShippedSheetPullsAPieceOff) {
  const Scene scene = load_shipped("torn_sheet");
  const Simulation simulation = after(scene, scene.duration);
  EXPECT_GT(simulation.tears(), 10);
  EXPECT_LT(simulation.positions()[25 * 25 - 1][1], -3) << "its corner, let go, falls";
}

TEST(Tearing, GoesOnBesideOtherBodiesAndObstacles) {
  Scene scene = pulled(0.9);
  BodySpec ball = tumbling_ellipsoid(1, {stiff("distance", {"edges"})});
  EnvironmentSpec ground;
  ground.name = "ground", ground.shape = BoxShape{{9, 1, 9}, {{1, 1, 1}}};
  ground.transform.translate = {0, -1, 0};
  scene.bodies.push_back(ball), scene.environment = {ground}, scene.gravity = kEarth;
  const Simulation simulation = after(scene, 1);
  ASSERT_GT(simulation.tears(), 0);
  EXPECT_EQ(simulation.positions().size(), 45u + 42u + simulation.tears());
  EXPECT_LT(simulation.measure().penetration_max, 1e-3);
}

TEST(Tearing, ToPiecesWithoutHingesGoesOn) {
  BodySpec ball = tumbling_ellipsoid(1, {compliant("distance", 1, {"edges"}), stiff("bending", {}, 0.01)});
  ball.spin = {0, 300, 0};
  ball.tear = Tear{0.01};
  const Simulation simulation = after(scene_of({ball}, {0, 0, 0}, 0.005), 0.3);
  EXPECT_EQ(simulation.positions().size(), 42u + simulation.tears());
  EXPECT_GT(simulation.tears(), 80);
  EXPECT_NEAR(simulation.measure().momentum[0], 2 * ball.velocity[0], 1e-10);
}

TEST(Tearing, WritesFramesOfTheMeshAsItIs) {
  Scene scene = pulled(0.9);
  scene.duration = 1, scene.outputs.every = 50, scene.outputs.formats = {"obj", "vtp", "ply"};
  const TemporaryFolder folder;
  run(
      scene, {.threads = 1}, {.out = (folder / "out").string()}, [](const Progress&) {}, std::atomic<bool>{false});
  const auto points = [&](const std::string& name) {
    const std::string text = bytes_of(folder / ("out/frames/" + name));
    std::size_t count = 0;
    for (std::size_t at = text.find("v "); at != std::string::npos; at = text.find("\nv ", at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(points("frame_000000.obj"), 45u);
  EXPECT_EQ(points("frame_000002.obj"), 45u + after(scene, 1).tears());
  const std::string collection = bytes_of(folder / "out/frames/frames.pvd");
  EXPECT_NE(collection.find("frame_000000.vtp"), std::string::npos);
  EXPECT_NE(collection.find("frame_000002.vtp"), std::string::npos);
}

TEST(Tearing, IsRefusedWithAFormatThatHoldsOneMesh) {
  Scene scene = pulled(0.9);
  scene.file = "s.json", scene.outputs.every = 1;
  for (const std::string format : {"pc2", "glb"}) {
    scene.outputs.formats = {"vtp", format};
    EXPECT_EQ(refusal([&] { build_model(scene); }),
              "s.json: /outputs/frames/formats: found " + format +
                  ", which holds one mesh for all frames, of a scene that tears; allowed: vtp, ply, obj");
  }
}

INSTANTIATE_TEST_SUITE_P(Tearing, SameBits,
                         testing::Values(SameBitsScene{"OfSeveralPatches",
                                                       [](const auto&) {
                                                         return pulled(5, {32, 32}, 0.3);
                                                       },
                                                       12,
                                                       {3, 10},
                                                       [](const Simulation& simulation) {
                                                         EXPECT_GT(simulation.tears(), 3);
                                                         EXPECT_GT(simulation.solver().facts().patches.patches, 1);
                                                       }}),
                         name_of_scene);

}  // namespace
}  // namespace malha
