// SPDX-License-Identifier: Apache-2.0
#include "host/model/model.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/solver/solver.h"
#include "tests/refusal.h"
#include "tests/scene_builders.h"

namespace malha {
namespace {

const GridShape kGrid{{1, 1}, {4, 4}};

std::string model_refusal(const Scene& scene) {
  return refusal([&] { build_model(scene); });
}

/// The solver's index of each particle in the user's order.
std::vector<int> solver_of(const Model& model) {
  std::vector<int> of(model.count());
  for (int i = 0; i < model.count(); ++i) of[model.user_index[i]] = i;
  return of;
}

double total(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// A triangulated grid in a file, with its vertices in random order, like a scan.
struct ShuffledMesh {
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("malha_model_test_" + std::to_string(::getpid()));
  std::string path = (folder / "shuffled.obj").string();
  ShuffledMesh() {
    std::filesystem::create_directories(folder);
    const Mesh grid = generate(GridShape{{1, 1}, {20, 20}});
    const int n = static_cast<int>(grid.points.size());
    std::ofstream obj(path);
    for (int i = 0; i < n; ++i) {  // 441 = 3^2 7^2 has no factor in common with 200: every vertex once
      const Vec3& x = grid.points[i * 200 % n];
      obj << "v " << x[0] << ' ' << x[1] << ' ' << x[2] << '\n';
    }
    std::vector<int> at(n);
    for (int i = 0; i < n; ++i) at[i * 200 % n] = i;
    for (const Triangle& t : triangles(grid))
      obj << "f " << at[t[0]] + 1 << ' ' << at[t[1]] + 1 << ' ' << at[t[2]] + 1 << '\n';
  }
  ~ShuffledMesh() { std::filesystem::remove_all(folder); }
};

TEST(Model, SharesTheMassByAreaAndKeepsThatOfPinnedParticles) {
  BodySpec sheet = body("sheet", kGrid);
  sheet.mass = 3;
  sheet.pins = {ListPin{{0}}};
  const Model model = build_model(scene_of({sheet}));
  EXPECT_NEAR(total(model.mass), 3, 1e-12);
  const std::vector<int> at = solver_of(model);
  // 16 cells: a corner of the sheet has a quarter of a cell, an inner particle a whole one.
  EXPECT_NEAR(model.mass[at[0]], 3.0 / 64, 1e-12);
  EXPECT_NEAR(model.mass[at[6]], 3.0 / 16, 1e-12);
  EXPECT_EQ(model.w[at[0]], 0);
  EXPECT_NEAR(model.w[at[6]], 16.0 / 3, 1e-9);
}

TEST(Model, TakesADensityPerAreaAndPerLength) {
  BodySpec sheet = body("sheet", GridShape{{2, 3}, {4, 4}}),
           chain = body("chain", ChainShape{{0, 0, 0}, {0, 5, 0}, 10});
  sheet.mass.reset(), chain.mass.reset();
  sheet.density = 0.2, chain.density = 0.3;
  EXPECT_NEAR(total(build_model(scene_of({sheet})).mass), 0.2 * 6, 1e-12);
  EXPECT_NEAR(total(build_model(scene_of({chain})).mass), 0.3 * 5, 1e-12);
}

TEST(Model, SharesTheMassOfACloudEqually) {
  const Model model = build_model(scene_of({body("dust", LatticeShape{{0, 0, 0}, {1, 1, 1}, {2, 3, 4}})}));
  for (const double m : model.mass) EXPECT_NEAR(m, 1.0 / 24, 1e-15);
}

TEST(Model, MapsItsOrderBackToTheUsers) {
  const ShuffledMesh mesh;
  const Model model = build_model(scene_of({body("scan", MeshFile{mesh.path}), body("ball", SphereShape{0.5, 2})}));
  ASSERT_EQ(model.render_mesh.points.size(), 441u + 162u);
  for (int i = 0; i < model.count(); ++i) EXPECT_EQ(model.x[i], model.render_mesh.points[model.user_index[i]]);
  EXPECT_FALSE(std::is_sorted(model.user_index.begin(), model.user_index.end()))
      << "the example is one that is reordered";
  const auto solver = make_solver(model, 0);
  const std::vector<Vec3> positions = solver->positions();
  for (int i = 0; i < model.count(); ++i)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(positions[i][k], model.render_mesh.points[i][k], 1e-7);
}

TEST(Model, KeepsConstraintsOnTheirParticlesWhenItReorders) {
  const ShuffledMesh mesh;
  const Model model =
      build_model(scene_of({body("scan", MeshFile{mesh.path}, {constraint("distance"), constraint("bending")})}));
  ASSERT_EQ(model.sets.size(), 2u);
  // Cells of 0.05 m: sides, and the diagonals of the two triangles.
  for (int c = 0; c < model.sets[0].count(); ++c) {
    const Vec3 &a = model.x[model.sets[0].particles[2 * c]], &b = model.x[model.sets[0].particles[2 * c + 1]];
    const double length = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    EXPECT_TRUE(std::abs(length - 0.05) < 1e-4 || std::abs(length - 0.05 * std::sqrt(2.0)) < 1e-4) << length;
  }
  EXPECT_EQ(model.sets[0].count(), 20 * 21 * 2 + 400);
  EXPECT_EQ(model.sets[1].count(), 20 * 19 * 2 + 400);
}

TEST(Model, AppliesTheTransformBeforePinsAndMeasures) {
  BodySpec sheet = body("sheet", kGrid);
  sheet.transform.translate = {0, 10, 0}, sheet.transform.scale = {2, 2, 2};
  sheet.pins = {NearestPin{{2, 10, 2}}};
  const Model model = build_model(scene_of({sheet}));
  EXPECT_EQ(model.w[solver_of(model)[24]], 0);
  EXPECT_EQ(model.render_mesh.points[24], (Vec3{2, 10, 2}));
}

TEST(Model, SpinIsOmegaCrossRAboutTheCentreOfMass) {
  BodySpec sheet = body("sheet", kGrid);
  sheet.transform.translate = {5, 0, 0};
  sheet.velocity = {1, 2, 3}, sheet.spin = {0.5, -1, 2};
  sheet.pins = {ListPin{{7}}};
  const Model model = build_model(scene_of({sheet}));
  for (int i = 0; i < model.count(); ++i) {
    const Vec3& x = model.x[i];
    const Vec3 r{x[0] - 5.5, x[1], x[2] - 0.5};
    const Vec3 expected{1 + (-1 * r[2] - 2 * r[1]), 2 + (2 * r[0] - 0.5 * r[2]), 3 + (0.5 * r[1] + 1 * r[0])};
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(model.v[i][k], model.w[i] > 0 ? expected[k] : 0, 1e-12);
  }
}

TEST(Model, MergesSetsOfBodiesWithEqualNumbersOnly) {
  const auto model_of = [](const ConstraintSpec& a, const ConstraintSpec& b) {
    return build_model(scene_of({body("a", kGrid, {a}), body("b", kGrid, {b})}));
  };
  const ConstraintSpec plain = constraint("distance");
  const int edges = 2 * 4 * 5;
  Model model = model_of(plain, plain);
  ASSERT_EQ(model.sets.size(), 1u);
  EXPECT_EQ(model.sets[0].count(), 2 * edges);

  ConstraintSpec other = plain;
  other.stiffness = 0.5;
  EXPECT_EQ(model_of(plain, other).sets.size(), 2u);
  other = constraint("distance", 0.9);
  EXPECT_EQ(model_of(plain, other).sets.size(), 2u);
  other = with_compliance("distance", 0);
  EXPECT_EQ(model_of(plain, other).sets.size(), 2u) << "compliance 0 is not the absence of compliance";
  EXPECT_EQ(model_of(with_compliance("distance", 1e-3), with_compliance("distance", 1e-4)).sets.size(), 2u);
  EXPECT_EQ(model_of(with_compliance("distance", 1e-3), with_compliance("distance", 1e-3)).sets.size(), 1u);
  other = plain;
  other.elements = {"shear"};
  model = model_of(plain, other);
  ASSERT_EQ(model.sets.size(), 1u) << "what they stand on does not matter";
  EXPECT_EQ(model.sets[0].count(), edges + 2 * 16);
}

TEST(Model, OrdersSetsByKindWhateverTheScenesOrder) {
  const Model model =
      build_model(scene_of({body("a", kGrid, {constraint("bending"), constraint("distance")}),
                            body("b", kGrid, {constraint("distance_limit", 0.1), constraint("distance", 0.5)})}));
  std::vector<std::string> types;
  for (const ConstraintSet& set : model.sets) types.push_back(set.type);
  EXPECT_EQ(types, (std::vector<std::string>{"distance", "distance", "distance_limit", "bending"}));
}

TEST(Model, LeavesOutConstraintsBetweenPinnedParticles) {
  BodySpec sheet = body("sheet", kGrid, {constraint("distance")});
  sheet.pins = {RowPin{}};
  EXPECT_EQ(build_model(scene_of({sheet})).sets[0].count(), 2 * 4 * 5 - 4);
}

TEST(Model, PressureTakesAllParticlesAndTrianglesOfItsBody) {
  const Model model =
      build_model(scene_of({body("sheet", kGrid), body("ball", SphereShape{0.5, 2}, {constraint("pressure", 1.5)})}));
  ASSERT_EQ(model.pressures.size(), 1u);
  EXPECT_EQ(model.pressures[0].volume_ratio, 1.5);
  EXPECT_EQ(model.pressures[0].particles.size(), 162u);
  EXPECT_EQ(model.pressures[0].triangles.size(), 320u);
  for (const Triangle& t : model.pressures[0].triangles)
    for (const int corner : t) EXPECT_GE(model.user_index[corner], 25);
}

TEST(Model, DampsEveryConnectedPartByItself) {
  BodySpec damped = body("damped", kGrid), free = body("free", kGrid), dust = body("dust", LatticeShape{});
  damped.damping = 0.1, dust.damping = 0.2;
  const Model model = build_model(scene_of({damped, free, dust}));
  ASSERT_EQ(model.damped.size(), 1u) << "a single particle has nothing to damp";
  EXPECT_EQ(model.damped[0].count, 25);
  EXPECT_EQ(model.damped[0].damping, 0.1);
  for (int i = 0; i < 25; ++i) EXPECT_LT(model.user_index[model.damped[0].first + i], 25);
}

TEST(Model, NamesParticlesByBodyAndItsOwnNumber) {
  const Model model = build_model(scene_of({body("a", kGrid), body("b", kGrid)}));
  EXPECT_EQ(particle_name(model, 0), "particle 0 of body 'a'");
  EXPECT_EQ(particle_name(model, 24), "particle 24 of body 'a'");
  EXPECT_EQ(particle_name(model, 25), "particle 0 of body 'b'");
}

TEST(Model, WithoutEnvironmentHasNoCollider) {
  const Model bare = build_model(scene_of({body("a", kGrid)}));
  const Model with = build_model(scene_of({body("a", kGrid)}, {obstacle("ball", SphereShape{1, 1})}));
  for (const int threads : {0, 2}) {
    EXPECT_EQ(make_solver(bare, threads)->facts().collision_bytes, 0u);
    EXPECT_GT(make_solver(with, threads)->facts().collision_bytes, 0u);
  }
}

TEST(ModelRefuses, ParticlesWithoutMass) {
  BodySpec dust = body("dust", LatticeShape{});
  dust.mass.reset(), dust.density = 1;
  EXPECT_EQ(model_refusal(scene_of({body("a", kGrid), dust})),
            "test.json: /bodies/1/density: found a density of loose particles; allowed: 'mass' (kg)");
  for (const double mass : {0.0, -1.0, std::nan("")}) {
    BodySpec sheet = body("sheet", kGrid);
    sheet.mass = mass;
    EXPECT_NE(model_refusal(scene_of({sheet})).find("allowed: a number > 0 (kg)"), std::string::npos) << mass;
  }
}

TEST(ModelRefuses, ConstraintsThatFindNothingToActOn) {
  EXPECT_EQ(
      model_refusal(scene_of({body("dust", LatticeShape{}, {constraint("distance")})})),
      "test.json: /bodies/0/constraints/0: found a mesh without elements for distance; allowed: edges, or quads for "
      "shear");
  EXPECT_EQ(model_refusal(scene_of(
                {body("a", kGrid), body("chain", ChainShape{}, {constraint("distance"), constraint("bending")})})),
            "test.json: /bodies/1/constraints/1: found a mesh without elements for bending; allowed: a mesh with "
            "neighbouring faces");
  ConstraintSpec shear = constraint("distance_limit");
  shear.elements = {"shear"};
  EXPECT_EQ(model_refusal(scene_of({body("ball", SphereShape{}, {shear})})),
            "test.json: /bodies/0/constraints/0: found a mesh without elements for distance_limit; allowed: "
            "edges, or quads for shear");
}

TEST(ModelRefuses, PressureInAnOpenMesh) {
  const std::string message = model_refusal(scene_of({body("sheet", kGrid, {constraint("pressure")})}));
  EXPECT_NE(message.find("test.json: edge "), std::string::npos) << message;
  EXPECT_NE(message.find("pressure needs a closed mesh"), std::string::npos) << message;
}

TEST(ModelRefuses, SolidsThatAreOpenAndEnvironmentsWithoutFaces) {
  const std::string open = model_refusal(scene_of({body("a", kGrid)}, {obstacle("ground", kGrid)}));
  EXPECT_NE(open.find("a solid needs a closed mesh"), std::string::npos) << open;
  EXPECT_EQ(model_refusal(scene_of({body("a", kGrid)}, {obstacle("ground", kGrid, Sides::OneSided)})), "");
  EXPECT_EQ(model_refusal(scene_of({body("a", kGrid)}, {obstacle("b", SphereShape{}), obstacle("rope", ChainShape{})})),
            "test.json: /environment/1/shape/chain: found unknown key 'chain'; allowed: mesh, grid, sphere, box, bar, "
            "mesh_data, plane, capsule, cylinder, object, group, weld");
}

TEST(ModelRefuses, WhatPinsRefuse) {
  BodySpec sheet = body("sheet", kGrid);
  sheet.pins = {BoxPin{{8, 8, 8}, {9, 9, 9}}};
  EXPECT_NE(model_refusal(scene_of({sheet})).find("test.json: /bodies/0/pins/0: found no particle there"),
            std::string::npos);
}

TEST(ModelRefuses, TheMeshesOfAllBodiesAndObjectsAtOnce) {
  const std::string refused = model_refusal(
      scene_of({body("scan", MeshFile{"/nowhere/scan.obj"}), body("a", kGrid), body("b", MeshFile{"/nowhere/b.ply"})},
               {obstacle("ball", SphereShape{}), obstacle("floor", MeshFile{"/nowhere/floor.stl"})}));
  EXPECT_EQ(std::count(refused.begin(), refused.end(), '\n'), 2) << refused;
  EXPECT_NE(refused.find("/nowhere/scan.obj: "), std::string::npos);
  EXPECT_NE(refused.find("\n/nowhere/b.ply: "), std::string::npos);
  EXPECT_NE(refused.find("\n/nowhere/floor.stl: "), std::string::npos);
}

TEST(ModelRefuses, AMeshFileByItsOwnName) {
  EXPECT_NE(model_refusal(scene_of({body("scan", MeshFile{"/nowhere/scan.obj"})})).find("/nowhere/scan.obj"),
            std::string::npos);
}

TEST(ModelRefuses, InScenesMadeInCodeWhatAFileMayNotSay) {
  EXPECT_NE(model_refusal(scene_of({})).find("found no key 'bodies'"), std::string::npos);
  BodySpec weightless = body("weightless", kGrid);
  weightless.mass.reset();
  EXPECT_EQ(model_refusal(scene_of({weightless})),
            "test.json: /bodies/0: found neither 'mass' nor 'density'; allowed: exactly one of them");
  EXPECT_NE(model_refusal(scene_of({body("a", kGrid, {constraint("distance"), constraint("glue")})}))
                .find("test.json: /bodies/0/constraints/1/type: found unknown constraint \"glue\""),
            std::string::npos);
  Scene frozen = scene_of({body("sheet", kGrid)});
  frozen.solver.dt = 0;
  EXPECT_NE(model_refusal(frozen).find("test.json: /solver/dt: found 0"), std::string::npos);
}

TEST(ModelRefuses, ExpectationsThatCouldNotFail) {
  const auto refused = [](auto set) {
    Scene scene = scene_of({body("sheet", kGrid)});
    set(scene.expect);
    return model_refusal(scene).substr(0, std::string("test.json: /expect/").size()) == "test.json: /expect/";
  };
  EXPECT_TRUE(refused([](Expect& e) { e.max_strain = 1; }));
  EXPECT_TRUE(refused([](Expect& e) { e.rms_strain = 1; }));
  EXPECT_TRUE(refused([](Expect& e) { e.volume_ratio = {1, 2}; }));
  EXPECT_TRUE(refused([](Expect& e) { e.max_penetration = 1; }));
  EXPECT_FALSE(refused([](Expect& e) { e.max_speed = 1; }));
}

}  // namespace
}  // namespace malha
