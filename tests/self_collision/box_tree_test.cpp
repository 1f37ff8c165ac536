// SPDX-License-Identifier: Apache-2.0
// The set-up of self-collision: intersections are found among triangles of any shape in near-linear time, and too many
// pairs are refused.
#include "host/model/box_tree.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "host/model/self_surface.h"
#include "malha/error.h"
#include "tests/numbers.h"
#include "tests/small_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

std::vector<BoundingBox> random_boxes(int count, unsigned seed) {
  Random random(seed);
  std::vector<BoundingBox> boxes;
  for (int i = 0; i < count; ++i) {
    const double stretch = i % 10 == 0 ? 1 : 0.05;  // a few that are large
    const Vec3 at{random(), random(), 0.2 * random()}, half{stretch * random(0, 1), 0.03 * random(0, 1), 0};
    boxes.push_back({at - half, {at[0] + half[0], at[1] + half[1], at[2] + half[2]}});
  }
  return boxes;
}

TEST(BoxTree, FindsAndCountsWhatASearchOfAllBoxesFinds) {
  const std::vector<BoundingBox> boxes = random_boxes(2000, 1), asked = random_boxes(100, 2);
  const BoxTree tree(boxes);
  for (const BoundingBox& box : asked) {
    std::set<int> all, found;
    for (int i = 0; i < 2000; ++i) {
      bool overlap = true;
      for (int k = 0; k < 3; ++k) overlap = overlap && boxes[i].low[k] <= box.high[k] && box.low[k] <= boxes[i].high[k];
      if (overlap) all.insert(i);
    }
    tree.for_each_overlap(box, [&](int i) { EXPECT_TRUE(found.insert(i).second); });
    EXPECT_EQ(found, all);
    EXPECT_EQ(tree.count_overlaps(box), std::ssize(all));
  }
}

/// A sheet of `cells` cells of 1 m x 1 mm, askew in space.
Model long_thin_cells(int cells) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 0.001 * cells}, {1, cells}}, sheet.mass = 1;
  sheet.transform.axis = {1, 2, 3}, sheet.transform.degrees = 40;
  return build_model(scene_of({sheet}, {0, 0, 0}, 0.01));
}

TEST(IntersectionCount, OfLongThinCellsTestsFewTrianglesAnEdge) {
  for (const int cells : {500, 8000}) {
    Model model = long_thin_cells(cells);
    model.scene.self_collision = SelfCollision{1e-4, 0, {}};
    const SelfSurface surface = self_surface(model);
    std::int64_t tried = 0;
    EXPECT_EQ(count_crossings(surface, model.x, &tried), 0);
    // An edge intersects the boxes of its own cell, of both neighbours and of a diagonal's: a uniform grid tested all
    // of them.
    EXPECT_LT(static_cast<double>(tried) / surface.edges, 20) << cells;
  }
}

Scene sheets_in_one_place(int sheets, double thickness) {
  std::vector<BodySpec> bodies;
  for (int s = 0; s < sheets; ++s) {
    BodySpec sheet;
    sheet.name = "sheet " + std::to_string(s), sheet.shape = GridShape{{1, 1}, {12, 12}}, sheet.mass = 1;
    sheet.transform.translate = {0, 1e-4 * s, 0};
    sheet.constraints = {stiff("distance", {"edges"})};
    bodies.push_back(sheet);
  }
  Scene scene = scene_of(bodies, {0, 0, 0}, 0.01);
  scene.self_collision = SelfCollision{thickness, 0, {}};
  return scene;
}

TEST(InitialPairs, AreWarnedOfWhereTheyAreVeryMany) {
  EXPECT_TRUE(build_model(sheets_in_one_place(1, 0.05)).notes.empty());
  EXPECT_TRUE(build_model(sheets_in_one_place(2, 0.05)).notes.empty());
  for (const Scene& scene : {sheets_in_one_place(1, 10), sheets_in_one_place(20, 0.05)}) {
    const Model model = build_model(scene);
    ASSERT_FALSE(model.notes.empty());
    const std::string& last = model.notes.back();  // earlier ones are about a thickness of 10 m, which is unlikely
    EXPECT_TRUE(has(last, "\"self_collision\": some ")) << last;
    EXPECT_TRUE(has(last, " pairs whose boxes come nearer than twice the thickness of ")) << last;
  }
}

TEST(InitialPairs, AreEstimatedFromASampleOfThem) {
  // Everything is within the thickness of everything: 288 triangles with 169 particles and 456 edges of their own.
  const Model model = build_model(sheets_in_one_place(1, 10));
  const PairEstimate pairs = estimate_pairs(self_surface(model), model.x, 10);
  // 3.25 pairs for two triangles are those of a sheet without a boundary; this one has more particles and edges: 12 %
  // more pairs.
  EXPECT_NEAR(pairs.candidates / (169.0 * 288 + 456.0 * 455 / 2), 1, 0.15);
  EXPECT_EQ(pairs.candidates, pairs.near);
}

TEST(InitialPairs, ThatFitNoMemoryAreRefused) {
  BodySpec sheet;
  sheet.name = "sheet", sheet.shape = GridShape{{1, 1}, {160, 160}}, sheet.mass = 1;
  Scene scene = scene_of({sheet}, {0, 0, 0}, 0.01);
  scene.self_collision = SelfCollision{10, 0, {}};  // 4e9 pairs
  try {
    build_model(scene);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_TRUE(has(error.what(), "/self_collision/thickness: found some ")) << error.what();
    EXPECT_TRUE(has(error.what(), " GiB; allowed: pairs that fit into the free memory")) << error.what();
  }
}

}  // namespace
}  // namespace malha
