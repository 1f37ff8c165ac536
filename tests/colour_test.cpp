#include "host/solver/colour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "host/solver/layout.h"
#include "tests/numbers.h"

namespace malha {
namespace {

/// Whether no two of these constraints share a movable particle: asked of a set, not of bit words.
bool independent(const std::vector<int>& constraints, const std::vector<int>& particles, int arity,
                 const std::vector<bool>& pinned) {
  std::set<int> taken;
  for (const int c : constraints) {
    std::set<int> own;
    for (int j = 0; j < arity; ++j)
      if (const int i = particles[c * arity + j]; !pinned[i]) own.insert(i);
    for (const int i : own)
      if (!taken.insert(i).second) return false;
  }
  return true;
}

void expect_valid(const Colouring& colouring, const std::vector<int>& particles, int arity,
                  const std::vector<bool>& pinned) {
  ASSERT_EQ(colouring.colour.size(), particles.size() / arity);
  std::vector<std::vector<int>> of(colouring.count);
  for (std::size_t c = 0; c < colouring.colour.size(); ++c) {
    ASSERT_GE(colouring.colour[c], 0);
    ASSERT_LT(colouring.colour[c], colouring.count);
    of[colouring.colour[c]].push_back(static_cast<int>(c));
  }
  for (int chosen = 0; chosen < colouring.count; ++chosen) {
    EXPECT_FALSE(of[chosen].empty()) << "an unused colour";
    EXPECT_TRUE(independent(of[chosen], particles, arity, pinned)) << "colour " << chosen;
  }
}

/// Edges 0-1, 0-2, ... from one hub.
std::vector<int> star(int edges) {
  std::vector<int> flat;
  for (int leaf = 1; leaf <= edges; ++leaf) flat.insert(flat.end(), {0, leaf});
  return flat;
}

template <class List>
std::vector<int> flatten(const List& list) {
  std::vector<int> flat;
  for (const auto& element : list) flat.insert(flat.end(), element.begin(), element.end());
  return flat;
}

/// A hypergraph with hubs: `arity` distinct particles a constraint, some of them wanted by many.
std::vector<int> tangle(int constraints, int arity, int particles, Random& random) {
  std::vector<int> flat;
  for (int c = 0; c < constraints; ++c)
    for (int j = 0; j < arity;) {
      const int i = random.below(random.below(3) == 0 ? 5 * arity : particles);
      if (std::find(flat.end() - j, flat.end(), i) != flat.end()) continue;
      flat.push_back(i), ++j;
    }
  return flat;
}

std::vector<bool> some_pinned(int particles, Random& random) {
  std::vector<bool> pinned(particles);
  for (int i = 0; i < particles; ++i) pinned[i] = random.below(6) == 0;
  return pinned;
}

TEST(Colour, IsValidOnTanglesOfAnyArity) {
  Random random(1);
  for (const int arity : {1, 2, 3, 4, 8})
    for (int trial = 0; trial < 5; ++trial) {
      const std::vector<int> particles = tangle(600, arity, 300, random);
      const std::vector<bool> pinned = some_pinned(300, random);
      expect_valid(colour(particles, arity, pinned), particles, arity, pinned);
    }
}

TEST(Colour, GivesAStarAroundAPinnedHubOneColour) {
  std::vector<bool> pinned(1001);
  pinned[0] = true;
  EXPECT_EQ(colour(star(1000), 2, pinned).count, 1);
}

TEST(Colour, GivesAStarAroundAFreeHubAsManyColoursAsItTakes) {
  const std::vector<bool> pinned(1001);
  const Colouring colouring = colour(star(1000), 2, pinned);
  EXPECT_EQ(colouring.count, 1000);
  expect_valid(colouring, star(1000), 2, pinned);
}

TEST(Colour, DependsOnItsArgumentsAlone) {
  Random random(2);
  const std::vector<int> particles = tangle(2000, 4, 700, random);
  const std::vector<bool> pinned = some_pinned(700, random);
  const Colouring first = colour(particles, 4, pinned), second = colour(particles, 4, pinned);
  EXPECT_EQ(first.colour, second.colour);
  EXPECT_EQ(first.count, second.count);
}

TEST(Colour, TakesTheLowestFreeColourInCreationOrder) {
  // Chain 0-1-2-3 and an edge apart: 0, 1, 0, 0.
  EXPECT_EQ(colour({0, 1, 1, 2, 2, 3, 4, 5}, 2, std::vector<bool>(6)).colour, (std::vector<int>{0, 1, 0, 0}));
  EXPECT_EQ(colour({}, 2, std::vector<bool>(6)).count, 0);
}

TEST(Colour, NeedsFewColoursForAGrid) {
  const Mesh mesh = generate(GridShape{{1, 1}, {40, 40}});
  std::vector<int> particles = flatten(edges(mesh));
  const std::vector<int> diagonals = flatten(shear(mesh));
  particles.insert(particles.end(), diagonals.begin(), diagonals.end());
  const std::vector<bool> pinned(mesh.points.size());
  const Colouring colouring = colour(particles, 2, pinned);
  expect_valid(colouring, particles, 2, pinned);
  EXPECT_GE(colouring.count, 8) << "an inner particle has eight edges";
  EXPECT_LE(colouring.count, 12);
}

void expect_sound(const Layout& layout, const std::vector<int>& particles, int arity, const std::vector<bool>& pinned,
                  const Colouring& colouring, int lanes) {
  const auto touches_pin = [&](int c) {
    for (int j = 0; j < arity; ++j)
      if (pinned[particles[c * arity + j]]) return true;
    return false;
  };
  ASSERT_EQ(layout.batches.size(), static_cast<std::size_t>(colouring.count));
  ASSERT_EQ(layout.constraint.size() % lanes, 0u);
  std::vector<int> seen(colouring.colour.size(), 0);
  int slot = 0;
  for (int chosen = 0; chosen < colouring.count; ++chosen) {
    const Batch& batch = layout.batches[chosen];
    ASSERT_EQ(batch.begin, slot) << "batches lie one after the other, each from the start of a pack";
    ASSERT_EQ(batch.begin % lanes, 0);
    ASSERT_EQ(batch.plain % lanes, 0);
    ASSERT_LE(batch.plain, batch.count);
    std::vector<int> members;
    for (; slot < batch.begin + batch.count; ++slot) {
      const int c = layout.constraint[slot];
      members.push_back(c);
      ++seen[c];
      EXPECT_EQ(colouring.colour[c], chosen);
      EXPECT_TRUE(slot >= batch.begin + batch.plain || !touches_pin(c)) << "a pin in a pack that is written whole";
    }
    EXPECT_TRUE(independent(members, particles, arity, pinned)) << "colour " << chosen;
    for (; slot % lanes != 0; ++slot) EXPECT_EQ(layout.constraint[slot], members.back()) << "padding";
    // All the whole packs without pins are written whole.
    const auto free = std::count_if(members.begin(), members.end(), [&](int c) { return !touches_pin(c); });
    EXPECT_EQ(batch.plain, free / lanes * lanes);
  }
  EXPECT_EQ(slot, static_cast<int>(layout.constraint.size()));
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<long>(seen.size())) << "each constraint once";
}

TEST(LayOut, HoldsEachConstraintOnceInIndependentPaddedBatches) {
  Random random(3);
  for (const int lanes : {1, 4, 8, 16})
    for (const int arity : {2, 4})
      for (const int constraints : {1, 5, 16, 500}) {
        const std::vector<int> particles = tangle(constraints, arity, 400, random);
        const std::vector<bool> pinned = some_pinned(400, random);
        const Colouring colouring = colour(particles, arity, pinned);
        expect_sound(lay_out(particles, arity, pinned, colouring, lanes), particles, arity, pinned, colouring, lanes);
      }
}

TEST(LayOut, OfAMeshIsSound) {
  Mesh grid = generate(GridShape{{1, 1}, {33, 21}});
  std::vector<bool> pinned(grid.points.size());
  for (int i = 0; i < 34; ++i) pinned[i] = true;
  const std::vector<int> lengths = flatten(edges(grid)), angles = flatten(hinges(grid));
  for (const auto& [particles, arity] : {std::pair(lengths, 2), std::pair(angles, 4)}) {
    const Colouring colouring = colour(particles, arity, pinned);
    expect_sound(lay_out(particles, arity, pinned, colouring, 16), particles, arity, pinned, colouring, 16);
  }
}

TEST(LayOut, OfNothingIsEmpty) {
  const Layout layout = lay_out({}, 2, {}, {}, 16);
  EXPECT_TRUE(layout.constraint.empty());
  EXPECT_TRUE(layout.batches.empty());
}

}  // namespace
}  // namespace malha
