// SPDX-License-Identifier: Apache-2.0
// The benchmark's cloth: the irregular mesh is valid, and other libraries get the same cloth as malha.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "host/base/hash.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "malha/simulation.h"
#include "tools/bench/cloth.h"
#include "tools/bench/irregular.h"

namespace malha::bench {
namespace {

/// Twice the signed area: positive if the normal points to +y.
double twice_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]);
}

TEST(IrregularSheet, IsAConsistentlyOrientedDiscOfTriangles) {
  const int side = 316, n = side * side;
  const Mesh mesh = irregular_sheet(side, 2);
  ASSERT_EQ(static_cast<int>(mesh.points.size()), n);
  double area = 0;
  std::set<Edge> sides;
  for (const Quad& face : mesh.faces) {
    ASSERT_TRUE(is_triangle(face));
    const double twice = twice_area(mesh.points[face[0]], mesh.points[face[1]], mesh.points[face[2]]);
    EXPECT_GT(twice, 0);
    area += twice / 2;
    for (int k = 0; k < 3; ++k)
      EXPECT_TRUE(sides.insert({face[k], face[(k + 1) % 3]}).second) << "two triangles on one side of an edge";
  }
  EXPECT_NEAR(area, 4, 1e-9) << "without gaps and overlaps; sums of 200,000 terms";
  const std::vector<Edge> all = edges(mesh);
  const auto border = std::count_if(all.begin(), all.end(), [&sides](const Edge& e) {
    return !sides.contains({e[0], e[1]}) || !sides.contains({e[1], e[0]});
  });
  EXPECT_EQ(border, 4 * (side - 1));
  EXPECT_EQ(n - static_cast<int>(all.size()) + static_cast<int>(mesh.faces.size()), 1)
      << "Euler characteristic of a disc";
  int parts = 0;
  components(n, all, parts);
  EXPECT_EQ(parts, 1);
}

TEST(IrregularSheet, HasPointsOfFourToNineNeighboursInNoOrder) {
  const Mesh mesh = irregular_sheet(316, 2);
  std::vector<int> valence(mesh.points.size());
  double apart = 0;
  const std::vector<Edge> all = edges(mesh);
  for (const Edge& e : all) ++valence[e[0]], ++valence[e[1]], apart += std::abs(e[0] - e[1]);
  std::map<int, int> inner;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& x = mesh.points[i];
    const bool border = x[0] == 0 || x[2] == 0 || x[0] == 2 || x[2] == 2;
    if (!border) ++inner[valence[i]];
  }
  EXPECT_EQ(inner.begin()->first, 4);
  EXPECT_EQ(inner.rbegin()->first, 9);
  for (const auto& [neighbours, points] : inner) EXPECT_GT(points, 100) << neighbours;
  // Of two random indices below n the mean distance is n / 3; in the lattice's order it would be below 2 * 316.
  EXPECT_NEAR(apart / static_cast<double>(all.size() * mesh.points.size()), 1.0 / 3, 0.01);
}

TEST(IrregularSheet, IsTheSameOnEveryPlatform) {
  const Mesh mesh = irregular_sheet(20, 2);
  EXPECT_EQ(hash_bytes(mesh.faces.data(), mesh.faces.size() * sizeof(Quad)), 10574377595618693642u);
  EXPECT_EQ(hash_bytes(mesh.points.data(), mesh.points.size() * sizeof(Vec3)), 10438142190506594994u);
}

class Clothes : public testing::TestWithParam<bool> {
 protected:
  Clothes() : which_(GetParam() ? grid_case(17) : irregular_case(400)), scene_(hanging_cloth(which_, {1, 10})) {}
  Case which_;
  Scene scene_;
};
INSTANTIATE_TEST_SUITE_P(Both, Clothes, testing::Bool(),
                         [](const auto& now) { return now.param ? "Grid" : "Irregular"; });

TEST_P(Clothes, HaveTheModelsLinksAndMasses) {
  const Model model = build_model(scene_);
  const Cloth cloth = cloth_of(scene_);
  ASSERT_EQ(static_cast<int>(cloth.points.size()), model.count());
  double total = 0;
  for (int i = 0; i < model.count(); ++i) {
    const int user = model.user_index[i];
    EXPECT_EQ(cloth.points[user], model.x[i]);
    EXPECT_EQ(cloth.mass[user], model.mass[i]);
    EXPECT_EQ(cloth.pinned[user], model.w[i] == 0);
    EXPECT_EQ(cloth.pinned[user], cloth.points[user][2] == 0);
    total += cloth.mass[user];
  }
  EXPECT_NEAR(total, 1, 1e-12);  // kg; rounding of some hundred terms
  const auto ordered = [](int a, int b) { return Edge{std::min(a, b), std::max(a, b)}; };
  std::set<Edge> theirs, ours;
  ASSERT_EQ(model.sets.size(), 1u);
  const std::vector<int>& ends = model.sets[0].particles;
  for (std::size_t k = 0; k < ends.size(); k += 2)
    theirs.insert(ordered(model.user_index[ends[k]], model.user_index[ends[k + 1]]));
  for (const Edge& e : cloth.links) ours.insert(ordered(e[0], e[1]));
  EXPECT_EQ(ours, theirs);
  EXPECT_EQ(ours.size(), cloth.links.size());
}

TEST_P(Clothes, HaveTheStrainThatMalhaMeasures) {
  const Cloth cloth = cloth_of(scene_);
  Simulation simulation(scene_, {.threads = 1});
  for (int step = 0; step < 60; ++step) simulation.step();
  const Strain mine = strain(cloth, simulation.positions());
  const Measures measures = simulation.measure();
  EXPECT_NEAR(mine.rms, measures.strain_rms, 1e-5);  // float rest lengths of 0.1 m
  EXPECT_NEAR(mine.max, measures.strain_max, 1e-5);
  EXPECT_GT(mine.rms, 1e-3);
}

}  // namespace
}  // namespace malha::bench
