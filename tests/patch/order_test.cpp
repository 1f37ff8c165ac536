// SPDX-License-Identifier: Apache-2.0
#include "host/model/ordering/order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "host/mesh/generate.h"
#include "host/mesh/topology.h"
#include "tests/numbers.h"

namespace malha {
namespace {

/// The input of solver_order.
struct Graph {
  std::vector<Vec3> points;
  std::vector<Edge> edges;
  std::vector<int> component;
  int components = 0;

  void add(const Mesh& mesh, const Vec3& at = {0, 0, 0}) {
    const int first = static_cast<int>(points.size());
    for (const Vec3& x : mesh.points) points.push_back({x[0] + at[0], x[1] + at[1], x[2] + at[2]});
    for (const Edge& e : malha::edges(mesh)) edges.push_back({e[0] + first, e[1] + first});
  }
  void shuffle(unsigned seed) {
    Random random(seed);
    std::vector<int> to(points.size());
    std::iota(to.begin(), to.end(), 0);
    for (int i = static_cast<int>(to.size()) - 1; i > 0; --i) std::swap(to[i], to[random.below(i + 1)]);
    std::vector<Vec3> moved(points.size());
    for (std::size_t i = 0; i < to.size(); ++i) moved[to[i]] = points[i];
    points = moved;
    for (Edge& e : edges) e = {to[e[0]], to[e[1]]};
  }
  std::vector<int> order() {
    component = malha::components(static_cast<int>(points.size()), edges, components);
    return solver_order(points, component, components, edges);
  }
  /// The mean of |i - j| over the edges, in the given order.
  double mean_distance(const std::vector<int>& order) const {
    std::vector<int> position(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = static_cast<int>(i);
    double sum = 0;
    for (const Edge& e : edges) sum += std::abs(position[e[0]] - position[e[1]]);
    return sum / static_cast<double>(edges.size());
  }
};

std::vector<int> as_given(int n) {
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

void expect_permutation(std::vector<int> order, std::size_t n) {
  ASSERT_EQ(order.size(), n);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, as_given(static_cast<int>(n)));
}

TEST(SolverOrder, IsAPermutation) {
  Graph graph;
  graph.add(generate(GridShape{{1, 1}, {17, 5}}));
  graph.add(generate(SphereShape{0.5, 2}), {3, 0, 0});
  graph.add(generate(LatticeShape{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}), {0, 3, 0});
  graph.shuffle(1);
  expect_permutation(graph.order(), graph.points.size());
}

TEST(SolverOrder, PutsConnectedBodiesOneAfterTheOther) {
  Graph graph;
  for (int k = 0; k < 5; ++k) graph.add(generate(SphereShape{0.5, 2}), {0.1 * k, 0, 0});  // the bodies overlap
  graph.shuffle(2);
  const std::vector<int> order = graph.order();
  ASSERT_EQ(graph.components, 5);
  for (std::size_t i = 1; i < order.size(); ++i)
    EXPECT_LE(graph.component[order[i - 1]], graph.component[order[i]]) << "position " << i;
}

TEST(SolverOrder, KeepsTheOrderOfGridsAndChains) {
  for (const auto& [nx, nz] :
       {std::pair(16, 16), std::pair(30, 30), std::pair(99, 99), std::pair(40, 80), std::pair(80, 40)}) {
    Graph grid;
    grid.add(generate(GridShape{{nx * 0.01, nz * 0.01}, {nx, nz}}));
    EXPECT_EQ(grid.order(), as_given((nx + 1) * (nz + 1))) << nx << " x " << nz;
  }
  Graph chain;
  chain.add(generate(ChainShape{{0, 0, 0}, {1, 1, 0}, 200}));
  EXPECT_EQ(chain.order(), as_given(201));
}

TEST(SolverOrder, RegainsTheLocalityOfAShuffledMesh) {
  // A square block of 4^k cells is contiguous in Morton order, so that the ends of an edge lie within 4^k of each other
  // unless the edge crosses a block's border: of n = 4^m points, one edge in 2^k does. Sum over k of 4^k / 2^k:
  // some 2^m, that is sqrt(n), times 2 for the far side of the border. Shuffled, it is n / 3.
  for (const int cells : {32, 100}) {
    Graph graph;
    graph.add(generate(GridShape{{1, 1}, {cells, cells}}));
    graph.shuffle(3);
    const double n = static_cast<double>(graph.points.size());
    EXPECT_GT(graph.mean_distance(as_given(static_cast<int>(n))), n / 4);
    EXPECT_LT(graph.mean_distance(graph.order()), 2 * std::sqrt(n));
  }
}

TEST(SolverOrder, ChoosesComponentByComponent) {
  Graph graph;
  const Mesh grid = generate(GridShape{{1, 1}, {20, 20}});
  graph.add(grid);
  graph.shuffle(4);
  const int shuffled = static_cast<int>(graph.points.size());
  graph.add(grid, {0, 5, 0});
  const std::vector<int> order = graph.order();
  const std::vector<int> kept(order.begin() + shuffled, order.end());
  std::vector<int> second = as_given(shuffled);
  for (int& i : second) i += shuffled;
  EXPECT_EQ(kept, second) << "the grid beside the shuffled one keeps its order";
  EXPECT_LT(graph.mean_distance(order), 2 * std::sqrt(shuffled));
}

TEST(SolverOrder, OfABodyDoesNotDependOnHowFarTheOthersAre) {
  Graph graph;
  graph.add(generate(GridShape{{1, 1}, {32, 32}}));
  graph.shuffle(5);
  const std::vector<int> alone = graph.order();
  graph.add(generate(GridShape{{1, 1}, {2, 2}}), {1e9, 0, 0});
  const std::vector<int> together = graph.order();
  EXPECT_TRUE(std::equal(alone.begin(), alone.end(), together.begin()));
}

TEST(SolverOrder, TakesPointsOnALineOrInOnePlace) {
  for (const double step : {0.0, 1.0}) {
    std::vector<Vec3> points;
    for (int i = 0; i < 10; ++i) points.push_back({i * step, 0, 0});
    expect_permutation(solver_order(points, std::vector<int>(10, 0), 1, {{0, 9}, {3, 4}}), 10);
  }
}

}  // namespace
}  // namespace malha
