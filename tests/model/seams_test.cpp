// SPDX-License-Identifier: Apache-2.0
// The pairs that seams find, and what is refused.
#include "host/model/seams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "host/model/model.h"
#include "tests/refusal.h"
#include "tests/scene_builders.h"
#include "tests/support.h"

namespace malha {
namespace {

/// A sheet of unit side in the plane y = height, of n x n cells.
BodySpec sheet_to_sew(const std::string& name, int n, double height) {
  BodySpec sheet = body(name, GridShape{{1, 1}, {n, n}}, {constraint("distance")});
  sheet.transform.translate = {0, height, 0};
  return sheet;
}

SeamSpec seam_of(const std::string& from, Selector at, const std::string& to, Selector there, double within) {
  SeamSpec seam;
  seam.from = {from, std::move(at)}, seam.to = {to, std::move(there)}, seam.within = within;
  return seam;
}

/// Two sheets, one above the other, whose rims are sewn.
Scene two_sheets(int n, int m) {
  Scene scene = scene_of({sheet_to_sew("front", n, 0.1), sheet_to_sew("back", m, 0)});
  scene.seams = {seam_of("front", RimPin{}, "back", RimPin{}, 0.2)};
  return scene;
}

/// The joints of the model, each as the user's numbers.
std::vector<std::vector<int>> joints_in(const Model& model) {
  std::vector<std::vector<int>> all;
  for (const ConstraintSet& set : model.sets)
    for (std::size_t k = 0; is_seam(set) && k < set.particles.size(); k += set.arity) {
      std::vector<int> one;
      for (int j = 0; j < set.arity; ++j) one.push_back(model.user_index[set.particles[k + j]]);
      all.push_back(one);
    }
  return all;
}

std::string refusal_of_seams(const Scene& scene) {
  return refusal([&] { build_model(scene); });
}

TEST(Seams, OfTwoRimsPairEachParticleWithTheOneBelow) {
  const Model model = build_model(two_sheets(6, 6));
  const auto pairs = joints_in(model);
  EXPECT_EQ(pairs.size(), 24u);
  for (const auto& pair : pairs) EXPECT_EQ(pair[0] + 49, pair[1]);
}

TEST(Seams, PairEqualRowsOneToOneAlsoWhereTheNearestWouldBeShared) {
  // Three particles at -.1, 0 and .1 over three at -.02, 0 and .02: the outer ones are the nearest of the outer ones.
  Scene scene =
      scene_of({body("three", MeshDataShape{{{-0.1, 1, 0}, {0, 1, 0}, {0.1, 1, 0}}, {}, {{0, 1}, {1, 2}}, {}}),
                body("others", MeshDataShape{{{-0.02, 0, 0}, {0, 0, 0}, {0.02, 0, 0}}, {}, {{0, 1}, {1, 2}}, {}})});
  const BoxPin all{{-9, -9, -9}, {9, 9, 9}};
  scene.seams = {seam_of("three", all, "others", all, 1.1)};
  std::map<int, int> partner;
  for (const auto& pair : joints_in(build_model(scene))) partner[pair[0]] = pair[1];
  EXPECT_EQ(partner, (std::map<int, int>{{0, 3}, {1, 4}, {2, 5}}));
}

TEST(Seams, OfAFinerRowShareTheParticlesOfTheCoarserOne) {
  const auto pairs = joints_in(build_model(two_sheets(8, 4)));
  EXPECT_EQ(pairs.size(), 32u);
  std::set<int> below;
  for (const auto& pair : pairs) below.insert(pair[1]);
  EXPECT_EQ(below.size(), 16u) << "all particles of the coarser rim";
}

TEST(Seams, JoinTheListedVertices) {
  Scene scene = two_sheets(2, 2);
  scene.seams = {{{"front", {}}, {"back", {}}, {}, {{8, 0}, {3, 5}}}};
  EXPECT_EQ(joints_in(build_model(scene)), (std::vector<std::vector<int>>{{8, 9}, {3, 14}}));
}

TEST(Seams, OfABodyWithItselfMakeATube) {
  Scene scene = scene_of({sheet_to_sew("sheet", 4, 0)});
  scene.seams = {seam_of("sheet", RowPin{false}, "sheet", RowPin{true}, 1.01)};
  const auto pairs = joints_in(build_model(scene));
  EXPECT_EQ(pairs.size(), 5u);
  for (const auto& pair : pairs) EXPECT_EQ(pair[0] + 20, pair[1]);
  scene.seams = {seam_of("sheet", RowPin{false}, "sheet", RimPin{}, 0.1)};
  EXPECT_TRUE(has(refusal_of_seams(scene), "test.json: /seams/0: found particle 0 of body 'sheet' on both sides"));
}

TEST(Seams, ToASurfaceTakeTheClosestTriangle) {
  Scene scene = two_sheets(2, 3);
  scene.seams = {seam_of("front", NearestPin{{0.5, 0.1, 0.5}}, "back", NearestPin{}, 0.2)};
  scene.seams[0].to = {"back", {}, true};
  const Model model = build_model(scene);
  const auto joints = joints_in(model);
  ASSERT_EQ(joints.size(), 1u);
  EXPECT_EQ(joints[0][0], 4) << "the middle of nine particles";
  // The middle of the sheet is that of the diagonal of its middle quad, 9 + {5, 6, 10, 9}.
  for (int j = 1; j < 4; ++j)
    EXPECT_TRUE(std::set<int>({9 + 5, 9 + 6, 9 + 9, 9 + 10}).contains(joints[0][j])) << joints[0][j];
  scene.seams[0].within = 0.05;
  EXPECT_TRUE(
      has(refusal_of_seams(scene), "test.json: /seams/0/within: found particle 4 of body 'front', which is 0.1 m"));
}

TEST(Seams, OfOneLineOfABoundaryLeaveTheOthersOpen) {
  BodySpec tube = body("tube", MeshDataShape{}, {constraint("distance")});
  auto& mesh = std::get<MeshDataShape>(tube.shape);
  for (const double y : {0.0, 1.0})
    for (const Vec3& at : {Vec3{0, y, 0}, Vec3{1, y, 0}, Vec3{1, y, 1}, Vec3{0, y, 1}}) mesh.points.push_back(at);
  for (int k = 0; k < 4; ++k) mesh.faces.push_back({k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k});
  Scene scene = scene_of({tube, sheet_to_sew("lid", 1, 1.05)});
  scene.seams = {seam_of("tube", RimPin{Vec3{0.5, 1, 0}}, "lid", RimPin{}, 0.2)};
  std::set<int> sewn;
  for (const auto& pair : joints_in(build_model(scene))) sewn.insert(pair[0]);
  EXPECT_EQ(sewn, (std::set<int>{4, 5, 6, 7}));
}

TEST(Seams, AreFirstAmongTheConstraintsSoThatASweepEndsWithThem) {
  Scene scene = two_sheets(6, 6);
  scene.seams.push_back(scene.seams[0]), scene.seams.back().compliance = 1e-3;
  const Model model = build_model(scene);
  ASSERT_GE(model.sets.size(), 3u);
  EXPECT_EQ(model.sets[0].type, "seam");
  EXPECT_EQ(model.sets[1].type, "seam") << "another compliance is another set";
  EXPECT_EQ(model.sets[2].type, "distance");
}

TEST(Seams, MakeOneComponentOfTheirBodies) {
  Scene scene = two_sheets(6, 6);
  scene.solver.keeps_momenta = true;
  for (BodySpec& one : scene.bodies) one.damping = 0.1;
  const Model sewn = build_model(scene);
  scene.seams.clear();
  const Model apart = build_model(scene);
  EXPECT_EQ(apart.damped.size(), 2u);
  EXPECT_EQ(sewn.damped.size(), 1u);
  EXPECT_EQ(apart.free.size(), 2u);
  EXPECT_EQ(sewn.free.size(), 1u);
  EXPECT_EQ(sewn_bodies(sewn), (std::vector<int>{0, 0}));
}

TEST(Seams, AreRefusedWhereTheyCannotBeMade) {
  const Scene sound = two_sheets(4, 4);
  EXPECT_EQ(refusal_of_seams(sound), "");
  Scene scene = sound;
  scene.seams[0].within = 0.05;
  EXPECT_TRUE(
      has(refusal_of_seams(scene),
          "test.json: /seams/0/within: found particle 0 of body 'front', which is 0.1 m from the nearest of 'to'"));
  scene = sound, scene.seams[0].from.body = "frnt";
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams/0/from/body: found unknown body \"frnt\""))
      << refusal_of_seams(scene);
  scene = sound, scene.bodies[1].tear = Tear{};
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams/0: found a seam of the body 'back', which tears"));
  scene = sound, scene.bodies[1].damping = 0.5;
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams/0: found bodies 'front' and 'back', whose \"damping\" differs"));
  scene = sound, scene.seams[0].from.at = SpherePin{{9, 9, 9}, 1};
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams/0/from: found no particle there"));
  scene = sound, scene.bodies[0].pins = scene.bodies[1].pins = {RimPin{}};
  EXPECT_TRUE(has(refusal_of_seams(scene), "which pins hold")) << "apart";
  scene = sound, scene.seams[0] = {{"front", {}}, {"back", {}}, {}, {{0, 25}}};
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams/0/pairs: found particle 25; allowed: 0 to 24"));
  scene = sound, scene.seams[0] = {{"front", {}}, {"front", {}}, {}, {{3, 3}}};
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams/0: found particle 3 of body 'front' on both sides"));
  scene = sound, scene.seams[0].to = {"front", {}, true};
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams/0/to: found the surface of the body whose particles"));
  scene = sound, scene.solver.type = "desbrun";
  EXPECT_TRUE(has(refusal_of_seams(scene), "/seams: found seams under Desbrun's method"));
  scene = sound, scene.seams.clear(), scene.expect.max_seam_gap = 0.1;
  EXPECT_TRUE(has(refusal_of_seams(scene), "/expect/max_seam_gap: found an expectation about seams"));
}

TEST(Seams, CloseAJoinedMeshForPressureOrSayWhereItIsOpen) {
  Scene scene = two_sheets(4, 4);
  scene.bodies[1].transform.axis = {1, 0, 0}, scene.bodies[1].transform.degrees = 180;
  scene.bodies[1].transform.translate = {0, 0, 1};
  ConstraintSpec pressure = constraint("pressure", 2);
  pressure.with = {"back"};
  scene.bodies[0].constraints.push_back(pressure);
  ASSERT_EQ(refusal_of_seams(scene), "");
  const Model model = build_model(scene);
  ASSERT_EQ(model.pressures.size(), 1u);
  EXPECT_EQ(model.pressures[0].triangles.size(), 64u);
  EXPECT_EQ(model.pressures[0].particles.size(), 34u) << "two sheets of 25 whose 16 rim particles are one";
  EXPECT_EQ(model.pressures[0].followers.size(), 16u);

  Scene open = scene;
  open.seams[0].from.at = open.seams[0].to.at = RowPin{};
  open.seams[0].to.at = RowPin{true};
  EXPECT_TRUE(has(refusal_of_seams(open), "/bodies/0/constraints/1: found an open edge from particle"));
  Scene inside_out = scene;
  inside_out.bodies[1] = two_sheets(4, 4).bodies[1];
  EXPECT_TRUE(has(refusal_of_seams(inside_out), "found faces of opposite orientations at the edge"));
  Scene flat = scene;
  for (BodySpec& one : flat.bodies) one.transform.translate[1] = 0;
  EXPECT_TRUE(has(refusal_of_seams(flat), "a joined mesh that encloses only "));
  Scene unknown = scene;
  unknown.bodies[0].constraints[1].with = {"bakc"};
  EXPECT_TRUE(has(refusal_of_seams(unknown), "/constraints/1/with/0: found unknown body 'bakc'"));
  unknown.bodies[0].constraints[1].with = {"front"};
  EXPECT_TRUE(has(refusal_of_seams(unknown), "/constraints/1/with/0: found 'front' a second time"));
}

TEST(Seams, LetTethersRunOverThem) {
  // The lower half hangs on the pins of the upper one: its last row is 1 m away from them along the cloth.
  BodySpec upper = body("upper", GridShape{{1, 0.5}, {8, 4}}, {constraint("distance")});
  upper.pins = {RowPin{}};
  BodySpec lower = body("lower", GridShape{{1, 0.5}, {8, 4}}, {constraint("distance"), constraint("long_range", 0)});
  lower.transform.translate = {0, 0, 0.51};
  Scene scene = scene_of({upper, lower});
  EXPECT_TRUE(has(refusal_of_seams(scene), "no pin"));
  scene.seams = {seam_of("upper", RowPin{true}, "lower", RowPin{}, 0.02)};
  const Model model = build_model(scene);
  const LongRangeSet& set = model.long_range;
  double longest = 0;
  ASSERT_EQ(set.items(), 45) << "the particles of the lower half";
  for (std::size_t a = 0; a < set.anchor.size(); ++a) {
    EXPECT_LT(model.user_index[set.anchor[a]], 9) << "a pin of the upper half";
    longest = std::max(longest, set.max_distance[a]);
  }
  // No tether is shorter than the distance at the start, with the gap of 1 cm.
  EXPECT_NEAR(longest, 1.01, 1e-9);
}

}  // namespace
}  // namespace malha
