// SPDX-License-Identifier: Apache-2.0
// Fields of the solver's layout: patches, their colours, and batches.
#include <algorithm>
#include <map>
#include <set>

#include "host/fields/fields.h"
#include "host/solver/solver.h"
#include "tests/fields/fields_of_sheets.h"

namespace malha {
namespace {

/// Tests that no two of these lines share a movable particle.
bool apart(const std::vector<Edge>& lines, const std::vector<bool>& pinned) {
  std::set<int> taken;
  for (const Edge& line : lines)
    for (const int i : line)
      if (!pinned[i] && !taken.insert(i).second) return false;
  return true;
}

TEST_F(FieldsOfSheets, StructureIsTheLayoutOfTheSolver) {
  std::vector<Pin> pins{ListPin{{0, 30, 31}}};
  for (const bool grid : {true, false}) {
    Scene scene = sheet(60, {stiff("distance", {"edges"})}, pins);
    if (grid) scene.bodies[0].shape = GridShape{{1, 1}, {60, 60}};
    const Simulation simulation(scene, {.threads = 1});
    const Model& model = simulation.model();
    const SolverStats& facts = simulation.solver().facts();
    const Structure layout = structure(model);
    ASSERT_GT(layout.patches, 1);
    EXPECT_EQ(layout.patches, facts.patches.patches);
    EXPECT_EQ(layout.colours, facts.patches.colours);
    EXPECT_EQ(layout.batches, facts.sets[0].most_batches) << "there is one set";
    EXPECT_EQ(std::set<int>(layout.patch.begin(), layout.patch.end()).size(), std::size_t(layout.patches));
    EXPECT_EQ(*std::min_element(layout.patch.begin(), layout.patch.end()), 0);
    EXPECT_EQ(*std::max_element(layout.colour.begin(), layout.colour.end()), layout.colours - 1);

    std::vector<bool> pinned(model.x.size());
    for (int i = 0; i < model.count(); ++i) pinned[model.user_index[i]] = model.w[i] == 0;
    std::multiset<Edge> found, expected;
    std::map<std::pair<int, int>, std::vector<Edge>> batches;
    std::vector<std::map<int, std::set<int>>> users(
        layout.colours);  // of each colour: the patches that use each movable particle
    std::vector<int> colour_of(layout.patches, -1);
    for (std::size_t i = 0; i < layout.patch.size(); ++i) {
      int& colour = colour_of[layout.patch[i]];
      EXPECT_TRUE(colour < 0 || colour == layout.colour[i]) << "a patch of two colours";
      colour = layout.colour[i];
    }
    for (std::size_t l = 0; l < layout.lines.size(); ++l) {
      const Edge& line = layout.lines[l];
      found.insert({std::min(line[0], line[1]), std::max(line[0], line[1])});
      batches[{layout.owner[l], layout.batch[l]}].push_back(line);
      for (const int i : line)
        if (!pinned[i]) users[colour_of[layout.owner[l]]][i].insert(layout.owner[l]);
      EXPECT_TRUE(layout.patch[line[0]] == layout.owner[l] || layout.patch[line[1]] == layout.owner[l]);
      EXPECT_LT(layout.batch[l], layout.batches);
    }
    for (const Quad& face : model.render_mesh.faces)  // every side once, except those between two pins
      for (int k = 0; k < (face[3] < 0 ? 3 : 4); ++k) {
        const int i = face[k], j = face[(k + 1) % (face[3] < 0 ? 3 : 4)];
        const Edge edge{std::min(i, j), std::max(i, j)};
        if (!(pinned[i] && pinned[j]) && expected.count(edge) == 0) expected.insert(edge);
      }
    EXPECT_EQ(found, expected) << "every constraint is in one batch";
    for (const auto& [number, lines] : batches) {
      EXPECT_TRUE(apart(lines, pinned)) << "patch " << number.first << ", batch " << number.second;
    }
    for (const auto& colour : users)
      for (const auto& [i, patches] : colour) EXPECT_EQ(patches.size(), 1u) << "particle " << i << " in one colour";
  }
}

TEST_F(FieldsOfSheets, HaveNoPatchesWhereTheFilterDoesAll) {
  Scene scene = sheet(5, {stiff("distance", {"edges"})});
  scene.solver.type = "desbrun";
  const Simulation simulation(scene, {.threads = 1});
  const Structure layout = structure(simulation.model());
  EXPECT_EQ(layout.patches, simulation.solver().facts().patches.patches);
  EXPECT_EQ(layout.patch, std::vector<int>(36, -1));
  EXPECT_TRUE(layout.lines.empty());
}

}  // namespace
}  // namespace malha
