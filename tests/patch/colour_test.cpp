// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/colour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "tests/self_collision/tangles.h"

namespace malha {
namespace {

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
  // The chain 0-1-2-3 and a separate edge have the colours 0, 1, 0, 0.
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

TEST(UsedColours, FindTheLowestThatNoneOfTheParticlesUses) {
  // The reference is a set of (particle, colour) pairs, over more than one word of 64 colours.
  Random random(4);
  constexpr int places = 12, colours = 150;
  UsedColours used(places);
  std::set<std::pair<int, int>> reference;
  for (int trial = 0; trial < 3000; ++trial) {
    const int some[] = {random.below(places), random.below(places), random.below(places)};
    const int count = random.below(4);
    if (trial % 2 == 0) {
      const int chosen = random.below(colours);
      used.use(chosen, some, count);
      for (int j = 0; j < count; ++j) reference.insert({some[j], chosen});
    }
    int lowest = 0;
    while (std::any_of(some, some + count, [&](int i) { return reference.count({i, lowest}) > 0; })) ++lowest;
    ASSERT_EQ(used.lowest_free(some, count), lowest);
  }
  EXPECT_GT(reference.size(), places * 64u) << "more than one word was in use";
}

}  // namespace
}  // namespace malha
