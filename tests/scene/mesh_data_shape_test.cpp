// SPDX-License-Identifier: Apache-2.0
// Meshes that a scene gets as data instead of a file.
#include <gtest/gtest.h>

#include "host/mesh/generate.h"
#include "host/model/model.h"
#include "tests/refusal.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

BodySpec listed_body(const Shape& shape) {
  BodySpec body;
  body.name = "body", body.shape = shape, body.mass = 1;
  return body;
}

/// A square with a gap in its numbers: nothing uses vertex 1.
const MeshDataShape kSquare{
    {{0, 0, 0}, {9, 9, 9}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}}, {{0, 3, 2, -1}, {2, 3, 4, -1}}, {}, {}};
constexpr const char* kSquareObj = "v 0 0 0\nv 9 9 9\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 4 3\nf 3 4 5\n";

TEST(MeshDataShape, IsTheSameBodyAsItsFile) {
  const TemporaryFolder folder;
  std::vector<std::uint64_t> hashes;
  for (const Shape& shape : {Shape(kSquare), Shape(MeshFile{folder.write("square.obj", kSquareObj)})}) {
    BodySpec body = listed_body(shape);
    body.constraints = {stiff("distance", {"edges"})}, body.pins = {ListPin{{3}}};
    const Simulation simulation = after(scene_of({body}, kEarth, 0.01, 4), 0.5);
    EXPECT_EQ(simulation.particles_of_vertices(0), (std::vector<int>{0, -1, 1, 2, 3}));
    hashes.push_back(simulation.state_hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(MeshDataShape, ComesBackFromItsJson) {
  Scene scene = scene_of({listed_body(kSquare)}, kEarth, 0.01);
  const Scene back = parse_scene(to_json(scene), "s.json", "");
  const auto& shape = std::get<MeshDataShape>(back.bodies[0].shape);
  EXPECT_EQ(shape.points, kSquare.points);
  EXPECT_EQ(shape.faces, kSquare.faces);
}

TEST(MeshDataShape, WithPointsAloneIsLoose) {
  const Scene scene = scene_of({listed_body(MeshDataShape{{{0, 0, 0}, {1, 0, 0}}, {}, {}, {}})}, kEarth, 0.1);
  EXPECT_EQ(Simulation(scene).positions().size(), 2u);
}

TEST(MeshDataShape, HasTheSurfaceOfItsTetrahedraAsFaces) {
  const Mesh mesh = generate(MeshDataShape{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, {}, {{0, 2, 1, 3}}});
  EXPECT_EQ(mesh.faces.size(), 4u);
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Tetrahedron>{{0, 2, 3, 1}})) << "of positive volume";
}

TEST(MeshDataShape, IsRefusedWhereACornerIsNoPoint) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(refusal([&] {
              generate(MeshDataShape{points, {{0, 1, 2, -1}, {0, 1, 3, -1}}, {}, {}});
            }),
            "mesh_data: faces/1: found vertex 3; allowed: 0 to 2");
  EXPECT_EQ(refusal([&] {
              generate(MeshDataShape{points, {{0, -1, 2, -1}}, {}, {}});
            }),
            "mesh_data: faces/0: found vertex -1; allowed: 0 to 2");
  EXPECT_EQ(refusal([&] {
              generate(MeshDataShape{points, {}, {{0, 5}}, {}});
            }),
            "mesh_data: lines/0: found vertex 5; allowed: 0 to 2");
  EXPECT_EQ(refusal([&] {
              generate(MeshDataShape{points, {}, {}, {{0, 1, 2, -1}}});
            }),
            "mesh_data: tetrahedra/0: found vertex -1; allowed: 0 to 2");
}

/// Valid meshes are not written as text to be checked; errors are named all the same.
TEST(MeshDataShape, MadeInCodeIsRefusedAsItsFileIs) {
  const auto refused = [](const MeshDataShape& shape) {
    return refusal([&] { build_model(scene_of({listed_body(shape)}, kEarth, 0.1)); });
  };
  MeshDataShape shape = kSquare;
  shape.points[2][1] = 2e18;
  EXPECT_TRUE(has(refused(shape), "/bodies/0/shape/mesh_data/points/2/1: found 2e+18; allowed: a number"))
      << refused(shape);
  shape.points[2][1] = NAN;
  EXPECT_TRUE(has(refused(shape), "/bodies/0/shape/mesh_data/points/2/1: found nan; allowed: a number"))
      << refused(shape);
  shape = kSquare, shape.faces[1][2] = -2;
  EXPECT_TRUE(has(refused(shape), "/bodies/0/shape/mesh_data/faces/1/2: found -2; allowed: ")) << refused(shape);
  EXPECT_TRUE(has(refused({}), "/bodies/0/shape/mesh_data/points: found a list of 0; allowed: ")) << refused({});
  EXPECT_EQ(refused(kSquare), "");
}

}  // namespace
}  // namespace malha
