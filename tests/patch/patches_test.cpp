// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "kernels/projection/patch.h"
#include "tests/self_collision/tangles.h"

namespace malha {
namespace {

std::vector<int> in_given_order(int n) {
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// The constraints of a sheet with `along` rows of `across` particles, in row order: edges and shear, and hinges too if
/// named.
std::vector<ConstraintSet> sheet(int across, int along, bool hinged = false) {
  const Mesh mesh = generate(GridShape{{1, 1}, {across - 1, along - 1}});
  std::vector<int> lengths = flatten(edges(mesh)), diagonals = flatten(shear(mesh));
  lengths.insert(lengths.end(), diagonals.begin(), diagonals.end());
  std::vector<ConstraintSet> sets{set_of(2, lengths)};
  if (hinged) sets.push_back(set_of(4, flatten(hinges(mesh))));
  return sets;
}

int crossing(const std::vector<ConstraintSet>& sets, const std::vector<int>& begin) {
  const std::vector<int> patch_of = patch_of_particles({begin, {}, {}});
  int sum = 0;
  for (const ConstraintSet& set : sets)
    for (int c = 0; c < set.count(); ++c) {
      std::set<int> patches;
      for (int j = 0; j < set.arity; ++j) patches.insert(patch_of[set.particles[c * set.arity + j]]);
      sum += patches.size() > 1;
    }
  return sum;
}

/// Checks the properties of every cut, whatever the constraints.
void expect_sound(const Cut& cut, const std::vector<ConstraintSet>& sets, const std::vector<int>& island) {
  const int particles = static_cast<int>(island.size());
  const std::vector<int>& begin = cut.patches.begin;
  ASSERT_GE(begin.size(), 2u);
  EXPECT_EQ(begin.front(), 0);
  EXPECT_EQ(begin.back(), particles);
  EXPECT_EQ(std::adjacent_find(begin.begin(), begin.end(), std::greater_equal<>()), begin.end()) << "an empty patch";

  std::vector<int> sorted = cut.order;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(sorted, in_given_order(particles));
  for (int k = 0; k < cut.patches.count(); ++k)
    for (int i = begin[k]; i < begin[k + 1]; ++i) {
      EXPECT_TRUE(begin[k] <= cut.order[i] && cut.order[i] < begin[k + 1]) << "left its patch";
      EXPECT_TRUE(i == 0 || island[cut.order[i - 1]] <= island[cut.order[i]]) << "left its island";
    }

  ASSERT_EQ(cut.patches.class_of.size(), island.size());
  std::vector<int> now(particles);
  for (int i = 0; i < particles; ++i) now[cut.order[i]] = i;
  for (const ConstraintSet& set : sets)
    for (int c = 0; c < set.count(); ++c) {
      std::set<int> classes;
      int with_one = 0;
      for (int j = 0; j < set.arity; ++j)
        if (const int k = cut.patches.class_of[now[set.particles[c * set.arity + j]]]; k != kNoClass)
          classes.insert(k), ++with_one;
      ASSERT_EQ(static_cast<int>(classes.size()), with_one) << "two particles of one class in constraint " << c;
    }
}

/// Checks owners and their lists by their definition, without bookkeeping; the result is the number of slots that the
/// largest patch needs.
int expect_owned(const Cut& cut, std::vector<ConstraintSet> sets) {
  std::vector<int> now(cut.order.size());
  for (std::size_t i = 0; i < now.size(); ++i) now[cut.order[i]] = static_cast<int>(i);
  const std::vector<int> patch_of = patch_of_particles(cut.patches);
  std::vector<int> foreign(cut.patches.count(), 0);
  std::vector<std::vector<int>> needed(cut.patches.count());
  for (std::size_t i = 0; i < now.size(); ++i) needed[patch_of[i]].push_back(static_cast<int>(i));
  for (ConstraintSet& set : sets) {
    for (int& i : set.particles) i = now[i];
    const std::vector<int> owner = owners(set, patch_of, foreign);
    EXPECT_EQ(static_cast<int>(owner.size()), set.count());
    for (int c = 0; c < set.count(); ++c) {
      const int* of = &set.particles[c * set.arity];
      EXPECT_TRUE(std::any_of(of, of + set.arity, [&](int i) { return patch_of[i] == owner[c]; })) << "a stranger owns";
      needed[owner[c]].insert(needed[owner[c]].end(), of, of + set.arity);
    }
    const ByOwner lists = by_owner(owner, cut.patches.count());
    std::vector<int> all;
    for (int k = 0; k < cut.patches.count(); ++k)
      for (int c = 0; c < set.count(); ++c)
        if (owner[c] == k && static_cast<int>(all.size()) >= lists.begin[k]) all.push_back(c);
    EXPECT_EQ(lists.list, all);
    EXPECT_EQ(lists.begin.back(), set.count());
  }
  std::size_t most = 0;
  for (auto& list : needed) {
    std::sort(list.begin(), list.end());
    most = std::max<std::size_t>(most, std::unique(list.begin(), list.end()) - list.begin());
  }
  return static_cast<int>(most);
}

TEST(CutIntoPatches, CoversTanglesAndKeepsTheirIslands) {
  Random random(1);
  for (const int particles : {20, 700, 3000})
    for (const int reach : {20, particles}) {
      const std::vector<ConstraintSet> sets{set_of(2, tangle(2 * particles, 2, particles, random, reach)),
                                            set_of(4, tangle(particles, 4, particles, random, reach))};
      std::vector<int> island(particles);
      // islands that do not follow from the constraints, which the cut must not assume
      for (int i = 0; i < particles; ++i) island[i] = i / 17;
      const Cut cut = cut_into_patches(sets, {}, island);
      expect_sound(cut, sets, island);
      EXPECT_LE(expect_owned(cut, sets), kMostSlots);
    }
}

TEST(CutIntoPatches, DependsOnItsArgumentsAlone) {
  Random random(2);
  const std::vector<ConstraintSet> sets{set_of(2, tangle(9000, 2, 6000, random, 30)),
                                        set_of(4, tangle(6000, 4, 6000, random, 30))};
  const std::vector<int> island(6000, 0);
  const int threads = omp_get_max_threads();
  const Cut first = cut_into_patches(sets, {}, island);
  ASSERT_GT(first.patches.count(), 4);
  for (const int other : {1, 2, 5}) {
    omp_set_num_threads(other);
    const Cut again = cut_into_patches(sets, {}, island);
    EXPECT_EQ(again.order, first.order) << other << " threads";
    EXPECT_EQ(again.patches.begin, first.patches.begin);
    EXPECT_EQ(again.patches.class_of, first.patches.class_of);
  }
  omp_set_num_threads(threads);
}

TEST(CutIntoPatches, CutsASheetBetweenItsRows) {
  // A cut between two rows of r crosses r edges and 2 (r - 1) diagonals; any other crosses one more.
  for (const auto& [across, along] :
       {std::pair(7, 400), std::pair(20, 200), std::pair(31, 90), std::pair(100, 100), std::pair(316, 40)}) {
    const auto sets = sheet(across, along);
    const std::vector<int> island(across * along, 0);
    const Cut cut = cut_into_patches(sets, {}, island);
    expect_sound(cut, sets, island);
    EXPECT_GT(cut.patches.count(), 1) << across;
    for (const int begin : cut.patches.begin) EXPECT_EQ(begin % across, 0) << across;
    EXPECT_EQ(crossing(sets, cut.patches.begin), (cut.patches.count() - 1) * (3 * across - 2)) << across;
  }
}

TEST(CutIntoPatches, LetsATenthOfTheConstraintsCross) {
  for (const int n : {46, 100, 250}) {
    const auto sets = sheet(n, n, true);
    const std::vector<int> island(n * n, 0);
    const Cut cut = cut_into_patches(sets, {}, island);
    expect_sound(cut, sets, island);
    EXPECT_GT(cut.patches.count(), 1) << n;
    const int all = sets[0].count() + sets[1].count();
    // The size is chosen with equal patches; the last one's remainder may go to the others and make one more cut.
    EXPECT_LT(crossing(sets, cut.patches.begin), all / 10 * (cut.patches.count() + 1) / cut.patches.count()) << n;
  }
}

TEST(CutIntoPatches, NeedsFewClassesForASheet) {
  const Cut cut = cut_into_patches(sheet(60, 60), {}, std::vector<int>(3600, 0));
  const std::set<int> classes(cut.patches.class_of.begin(), cut.patches.class_of.end());
  EXPECT_EQ(classes.size(), 4u) << "even and odd rows and columns: the four corners of a cell are all neighbours";
}

TEST(CutIntoPatches, SortsASheetByClassSoThatItsNeighboursInARowLieTwoApart) {
  const auto sets = sheet(40, 40);
  const Cut cut = cut_into_patches(sets, {}, std::vector<int>(1600, 0));
  for (int k = 0; k < cut.patches.count(); ++k)
    EXPECT_TRUE(std::is_sorted(cut.patches.class_of.begin() + cut.patches.begin[k],
                               cut.patches.class_of.begin() + cut.patches.begin[k + 1]))
        << "patch " << k;
}

TEST(CutIntoPatches, PutsWhatIsSharedFirstWhereThereAreNoRuns) {
  Random random(3);
  const std::vector<ConstraintSet> sets{set_of(2, tangle(20000, 2, 6000, random, 40))};
  const std::vector<int> island(6000, 0);
  const Cut cut = cut_into_patches(sets, {}, island);
  expect_sound(cut, sets, island);
  ASSERT_GT(cut.patches.count(), 3);
  std::vector<int> now(6000);
  for (int i = 0; i < 6000; ++i) now[cut.order[i]] = i;
  const std::vector<int> patch_of = patch_of_particles(cut.patches);
  // the particle is in a patch above the lowest of its constraint, which owns it
  std::vector<bool> shared(6000, false);
  for (int c = 0; c < sets[0].count(); ++c) {
    const int a = now[sets[0].particles[2 * c]], b = now[sets[0].particles[2 * c + 1]];
    if (patch_of[a] != patch_of[b]) shared[patch_of[a] > patch_of[b] ? a : b] = true;
  }
  ASSERT_GT(std::count(shared.begin(), shared.end(), true), 0);
  for (int k = 0; k < cut.patches.count(); ++k)
    EXPECT_TRUE(std::is_partitioned(shared.begin() + cut.patches.begin[k], shared.begin() + cut.patches.begin[k + 1],
                                    [](bool is) { return is; }))
        << "patch " << k;
}

TEST(CutIntoPatches, CutsACloudEvenly) {
  const Cut cut = cut_into_patches({}, {}, std::vector<int>(5000, 0));
  expect_sound(cut, {}, std::vector<int>(5000, 0));
  EXPECT_EQ(cut.order, in_given_order(5000));
  EXPECT_GT(cut.patches.count(), 1);
  for (int k = 1; k < cut.patches.count(); ++k)
    EXPECT_LE(std::abs(cut.patches.begin[k + 1] - 2 * cut.patches.begin[k] + cut.patches.begin[k - 1]), 1);
}

TEST(CutIntoPatches, TakesOneParticle) {
  const Cut cut = cut_into_patches({}, {}, {0});
  EXPECT_EQ(cut.order, std::vector<int>{0});
  EXPECT_EQ(cut.patches.begin, (std::vector<int>{0, 1}));
}

TEST(CutIntoPatches, TakesAStarWhosePatchesStillCanNumberTheirParticles) {
  const std::vector<ConstraintSet> sets{set_of(2, star(100000))};
  const std::vector<int> island(100001, 0);
  const Cut cut = cut_into_patches(sets, {}, island);
  expect_sound(cut, sets, island);
  EXPECT_GT(cut.patches.count(), 1) << "all of them in one could not be numbered";
  EXPECT_LE(expect_owned(cut, sets), kMostSlots);
}

TEST(CutIntoPatches, TakesATangleOfTwoHalvesWhoseConstraintsAllCross) {
  // Each constraint joins a random particle of the first half to one of the second.
  Random random(4);
  constexpr int half = 50000;
  std::vector<int> particles;
  for (int c = 0; c < 3 * half; ++c) particles.insert(particles.end(), {random.below(half), half + random.below(half)});
  const std::vector<ConstraintSet> sets{set_of(2, particles)};
  const std::vector<int> island(2 * half, 0);
  const Cut cut = cut_into_patches(sets, {}, island);
  expect_sound(cut, sets, island);
  EXPECT_LE(expect_owned(cut, sets), kMostSlots);
}

TEST(CutIntoPatches, GivesParticlesWithoutAFreeClassNone) {
  // 300 particles that are all each other's neighbours: there are no 300 classes.
  std::vector<int> particles;
  for (int a = 0; a < 300; ++a)
    for (int b = 0; b < a; ++b) particles.insert(particles.end(), {a, b});
  const std::vector<ConstraintSet> sets{set_of(2, particles)};
  const std::vector<int> island(300, 0);
  const Cut cut = cut_into_patches(sets, {}, island);
  expect_sound(cut, sets, island);
  EXPECT_EQ(std::count(cut.patches.class_of.begin(), cut.patches.class_of.end(), kNoClass), 300 - kNoClass);
}

TEST(CutIntoPatches, KeepsTheEndsOfAnEdgeWithoutConstraintsApartToo) {
  // A pinned row has no constraints of its own; its edges still make it neighbours.
  std::vector<Edge> row;
  for (int i = 0; i < 50; ++i) row.push_back({i, i + 1});
  const Cut cut = cut_into_patches({}, row, std::vector<int>(51, 0));
  std::vector<int> now(51);
  for (int i = 0; i < 51; ++i) now[cut.order[i]] = i;
  for (const Edge& e : row) EXPECT_NE(cut.patches.class_of[now[e[0]]], cut.patches.class_of[now[e[1]]]);
}

TEST(PatchOwners, AreTheLowestPatchWithFreeSlots) {
  const std::vector<int> patch_of{0, 0, 1, 1, 2};
  std::vector<int> foreign(3, 0);
  EXPECT_EQ(owners(set_of(2, {0, 1, 3, 2, 4, 0, 2, 4, 3, 1}), patch_of, foreign), (std::vector<int>{0, 1, 0, 1, 0}));
  EXPECT_EQ(foreign, (std::vector<int>{2, 1, 0}));
  foreign = {kMostSlots, 0, 0};  // patch 0 has no free slots for neighbours
  EXPECT_EQ(owners(set_of(2, {4, 0, 3, 1, 0, 1}), patch_of, foreign), (std::vector<int>{2, 1, 0}));
  EXPECT_EQ(foreign, (std::vector<int>{kMostSlots, 1, 1}));
}

TEST(LayOutClasses, StartsThemWithWholePacksAndASpareOneBetween) {
  std::vector<std::uint8_t> class_of;
  for (const int size : {1, 16, 17, 40, 5})
    class_of.insert(class_of.end(), size, static_cast<std::uint8_t>(class_of.size()));
  const ClassLayout layout = lay_out_classes(class_of);
  ASSERT_EQ(layout.slot.size(), class_of.size());
  for (std::size_t i = 0; i < class_of.size(); ++i) {
    const bool starts = i == 0 || class_of[i] != class_of[i - 1];
    EXPECT_TRUE(starts ? layout.slot[i] % 16 == 0 : layout.slot[i] == layout.slot[i - 1] + 1) << i;
    // A pack of any width up to 16 that starts at the last particle of a class ends before the next class.
    EXPECT_TRUE(i == 0 || !starts || layout.slot[i] >= layout.slot[i - 1] + 16) << i;
  }
  EXPECT_GE(layout.slots, layout.slot.back() + 16);
}

}  // namespace
}  // namespace malha
