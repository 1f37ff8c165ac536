// SPDX-License-Identifier: Apache-2.0
// The structure of the sparse factor: an ordering, an elimination tree, and rows that include all fill-in.
#include "host/filter/supernodes.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "host/filter/elimination_order.h"
#include "tests/filter/filter_reference.h"

namespace malha {
namespace {

/// Rows of each column of the factor including the diagonal, by symbolic elimination of column after column: without a
/// tree or counts.
std::vector<std::set<int>> eliminated(const SpringSystem& system, const std::vector<int>& order) {
  const int n = system.count();
  std::vector<int> now(n);
  for (int j = 0; j < n; ++j) now[order[j]] = j;
  std::vector<std::set<int>> rows(n);
  for (int i = 0; i < n; ++i) {
    rows[now[i]].insert(now[i]);
    for (int k = system.begin[i]; k < system.begin[i + 1]; ++k)
      if (const int j = now[system.column[k]]; j > now[i]) rows[now[i]].insert(j);
  }
  for (int j = 0; j < n; ++j) {
    const std::vector<int> below(std::next(rows[j].begin()), rows[j].end());
    for (const int i : below) rows[i].insert(std::lower_bound(below.begin(), below.end(), i), below.end());
  }
  return rows;
}

class SupernodesOf : public testing::TestWithParam<const char*> {
 protected:
  SupernodesOf() {
    const std::string name = GetParam();
    const auto sheet = [](int cells) { return sprung_sheet(cells, {ListPin{{0}}}); };
    BodySpec body = name == "sheet"      ? sheet(24)
                    : name == "chain"    ? sprung_chain(500, false)
                    : name == "particle" ? sprung_chain(1, false)
                    : name == "star"     ? star(folder_, 100)
                                         : star(folder_, 200, {ListPin{{0}}});
    std::vector<BodySpec> bodies{body};
    if (name == "bodies") {
      bodies = {sheet(12), sheet(3), sprung_chain(30, true), sheet(9)};
      for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b].name += std::to_string(b);
    }
    if (name == "ball") bodies[0] = sprung_sheet(3), bodies[0].shape = SphereShape{0.5, 3};
    system_ = spring_system(build_model(desbrun_scene(bodies, 1e4)), 0.01);
  }

  TemporaryFolder folder_;
  SpringSystem system_;
};

TEST_P(SupernodesOf, OrderIsAPermutationAndColumnsAreCutIntoThem) {
  const Supernodes all = supernodes(system_);
  std::vector<int> sorted = all.order, expected(system_.count());
  std::iota(expected.begin(), expected.end(), 0);
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, expected);
  ASSERT_EQ(all.column_begin.size(), all.parent.size() + 1);
  EXPECT_EQ(all.column_begin.front(), 0);
  EXPECT_EQ(all.column_begin.back(), system_.count());
  for (int s = 0; s < all.count(); ++s) EXPECT_GT(all.columns(s), 0);
}

TEST_P(SupernodesOf, ParentsComeLaterAndHoldTheFirstRowBelow) {
  const Supernodes all = supernodes(system_);
  for (int s = 0; s < all.count(); ++s) {
    const auto begin = all.rows.begin() + all.row_begin[s], end = all.rows.begin() + all.row_begin[s + 1];
    for (auto row = begin; row != end; ++row) {
      ASSERT_GE(*row, all.column_begin[s + 1]) << "below its own columns";
      ASSERT_LT(*row, system_.count());
      ASSERT_TRUE(row == begin || *(row - 1) < *row) << "ascending";
    }
    const int parent = all.parent[s];
    ASSERT_EQ(parent < 0, begin == end);
    if (parent < 0) continue;
    ASSERT_GT(parent, s);
    ASSERT_TRUE(*begin >= all.column_begin[parent] && *begin < all.column_begin[parent + 1]);
    // Every row of its update matrix has a row in its parent.
    for (auto row = begin; row != end; ++row)
      ASSERT_TRUE(*row < all.column_begin[parent + 1] ||
                  std::binary_search(all.rows.begin() + all.row_begin[parent],
                                     all.rows.begin() + all.row_begin[parent + 1], *row));
  }
}

TEST_P(SupernodesOf, RowsAreThoseThatEliminationFillsInAndFewZeros) {
  const Supernodes all = supernodes(system_);
  const std::vector<std::set<int>> exact = eliminated(system_, all.order);
  std::int64_t numbers = 0, held = 0;
  for (int s = 0; s < all.count(); ++s) {
    std::set<int> of_all;  // rows that any of its columns needs
    for (int j = all.column_begin[s]; j < all.column_begin[s + 1]; ++j) {
      numbers += static_cast<std::int64_t>(exact[j].size());
      held += all.column_begin[s + 1] - j + all.below(s);
      for (const int i : exact[j])
        if (i >= all.column_begin[s + 1]) of_all.insert(i);
    }
    EXPECT_TRUE(std::equal(of_all.begin(), of_all.end(), all.rows.begin() + all.row_begin[s],
                           all.rows.begin() + all.row_begin[s + 1]))
        << "supernode " << s << ": every row that is needed, and no other";
  }
  EXPECT_GE(held, numbers);
  EXPECT_LE(held, 5 * numbers) << "of supernodes up to 16 wide four fifths may be zeros; most have far fewer";
  EXPECT_GE(all.entries(), held);
}

TEST_P(SupernodesOf, TasksAreWholeSubtreesAndTheTopIsWhatIsAboveThem) {
  const Supernodes all = supernodes(system_);
  const Subtrees cut = subtrees(all);
  std::vector<int> task(all.count(), -2);
  for (std::size_t t = 0; t < cut.tasks.size(); ++t) {
    EXPECT_TRUE(std::is_sorted(cut.tasks[t].begin(), cut.tasks[t].end()));
    for (const int s : cut.tasks[t]) {
      ASSERT_EQ(task[s], -2) << "in one place only";
      task[s] = static_cast<int>(t);
    }
  }
  EXPECT_TRUE(std::is_sorted(cut.top.begin(), cut.top.end()));
  for (const int s : cut.top) {
    ASSERT_EQ(task[s], -2);
    task[s] = -1;
  }
  for (int s = 0; s < all.count(); ++s) {
    ASSERT_NE(task[s], -2) << "nothing is left out";
    if (all.parent[s] < 0) continue;
    const int up = task[all.parent[s]];
    ASSERT_TRUE(up == -1 || up == task[s]) << "a task's parents are in it or in the top";
  }
}

/// The order of builds without METIS: a permutation within each block, with less fill than the order of a grid's rows.
TEST_P(SupernodesOf, MinimumDegreeOrdersTheUnknownsOfEachBlock) {
  const std::vector<int> order = minimum_degree_order(system_);
  ASSERT_EQ(order.size(), static_cast<std::size_t>(system_.count()));
  for (const SystemBlock& block : system_.blocks) {
    std::vector<int> own(order.begin() + block.first, order.begin() + block.first + block.count), expected(own.size());
    std::sort(own.begin(), own.end());
    std::iota(expected.begin(), expected.end(), block.first);
    EXPECT_EQ(own, expected);
  }
}

TEST(Supernodes, OfASheetInMinimumDegreeFillAsNestedDissectionDoes) {
  const SpringSystem system = spring_system(build_model(desbrun_scene({sprung_sheet(60)}, 1e4)), 0.01);
  std::vector<int> rows(system.count());
  std::iota(rows.begin(), rows.end(), 0);
  const double dissected = static_cast<double>(supernodes(system).entries()),
               degrees = static_cast<double>(supernodes(system, minimum_degree_order(system)).entries()),
               plain = static_cast<double>(supernodes(system, rows).entries());
  EXPECT_LT(degrees, 1.3 * dissected);
  EXPECT_GT(plain, 1.5 * degrees) << "the order matters here";
}

/// A bad dissection or a wrong ordering would be far above these: the fill of a sheet grows like n log n.
TEST(Supernodes, OfASheetFillAsNestedDissectionDoes) {
  const SpringSystem system = spring_system(build_model(desbrun_scene({sprung_sheet(60)}, 1e4)), 0.01);
  const double n = system.count();
  EXPECT_LT(static_cast<double>(supernodes(system).entries()), 10 * n * std::log2(n));
}

INSTANTIATE_TEST_SUITE_P(, SupernodesOf,
                         testing::Values("sheet", "chain", "particle", "star", "cut_star", "bodies", "ball"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace malha
