// SPDX-License-Identifier: Apache-2.0
// Decimation for the window: few particles that stand for many in pictures.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "tools/view/decimated_mesh.h"

namespace malha {
namespace {

using view::DecimatedMesh;

/// Two flat sheets of n x n particles with irregular positions and numbers, one above the other; a chain; one
/// unconnected particle.
struct Parts {
  std::vector<std::array<double, 2>> x;
  std::vector<int> part;
  std::vector<std::array<unsigned, 3>> triangles;
  std::vector<std::array<unsigned, 2>> edges;

  explicit Parts(int n) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> off(-0.3, 0.3);
    const unsigned count = unsigned(2 * n * n + n + 1);
    std::vector<unsigned> number(count);
    std::iota(number.begin(), number.end(), 0u);
    std::shuffle(number.begin(), number.end(), random);
    x.resize(count), part.assign(count, 3);
    std::set<std::array<unsigned, 2>> joined;
    for (int sheet = 0; sheet < 2; ++sheet) {
      const auto at = [&](int i, int j) { return number[std::size_t((sheet * n + i) * n + j)]; };
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const bool rim = i == 0 || j == 0 || i + 1 == n || j + 1 == n;
          x[at(i, j)] = {i + (rim ? 0 : off(random)), j + (rim ? 0 : off(random))}, part[at(i, j)] = sheet;
          if (i + 1 == n || j + 1 == n) continue;
          triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
          triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    for (const auto& t : triangles)
      for (int k = 0; k < 3; ++k) joined.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    edges.assign(joined.begin(), joined.end());
    for (int k = 0; k < n; ++k) {
      part[number[std::size_t(2 * n * n + k)]] = 2;
      if (k > 0) edges.push_back({number[std::size_t(2 * n * n + k - 1)], number[std::size_t(2 * n * n + k)]});
    }
  }
};

double area(const Parts& of, const std::array<unsigned, 3>& t) {
  const auto &a = of.x[t[0]], &b = of.x[t[1]], &c = of.x[t[2]];
  return ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
}

TEST(ViewDecimation, CoversSheetsWithFewTrianglesThatFaceTheSameWay) {
  const int n = 200;
  const Parts parts(n);
  for (const double share : {5.0, 20.0, 60.0}) {
    const DecimatedMesh decimated = view::decimate(parts.x.size(), parts.triangles, parts.edges, share);
    double positive = 0, negative = 0;
    for (const auto& t : decimated.triangles) {
      const double one = area(parts, {decimated.particles[t[0]], decimated.particles[t[1]], decimated.particles[t[2]]});
      (one > 0 ? positive : negative) += one;
    }
    const double whole = 2.0 * (n - 1) * (n - 1), rim = 2.0 * 4 * n * std::sqrt(share);
    EXPECT_NEAR(positive + negative, whole, rim) << "all but half a distance between chosen ones along the rim";
    EXPECT_GT(negative, -0.01 * whole) << "irregular as they lie, hardly any turn over";
    EXPECT_NEAR(double(parts.x.size()) / double(decimated.particles.size()), share, 0.35 * share);
  }
}

TEST(ViewDecimation, JoinsNoParts) {
  const Parts parts(60);
  const DecimatedMesh decimated = view::decimate(parts.x.size(), parts.triangles, parts.edges, 20);
  std::set<int> kept;
  std::set<unsigned> once;
  for (const unsigned i : decimated.particles) {
    kept.insert(parts.part[i]);
    EXPECT_TRUE(once.insert(i).second) << i;
  }
  EXPECT_EQ(kept, (std::set<int>{0, 1, 2}));
  for (const auto& [a, b] : decimated.edges)
    EXPECT_EQ(parts.part[decimated.particles[a]], parts.part[decimated.particles[b]]);
  for (const auto& t : decimated.triangles) {
    EXPECT_EQ(parts.part[decimated.particles[t[0]]], parts.part[decimated.particles[t[1]]]);
    EXPECT_EQ(parts.part[decimated.particles[t[0]]], parts.part[decimated.particles[t[2]]]);
  }
}

TEST(ViewDecimation, OfNothingIsNothing) {
  const DecimatedMesh decimated = view::decimate(3, {}, {}, 20);
  EXPECT_TRUE(decimated.particles.empty() && decimated.triangles.empty() && decimated.edges.empty());
}

}  // namespace
}  // namespace malha
