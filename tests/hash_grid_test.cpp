// What self-collision is made of: closest points, sorting, and the grid that finds which pairs may meet.
#include "kernels/hash_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "host/collision/sorter.h"
#include "kernels/closest.h"
#include "tests/numbers.h"

namespace malha {
namespace {

template <class R>
Vector3<R> anywhere(Random& random, double size = 1) {
  return {R(random(-size, size)), R(random(-size, size)), R(random(-size, size))};
}

template <class R>
class ClosestPoints : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ClosestPoints, Precisions);

// The closest point q of a convex set is the one for which no point of the set lies beyond the plane through q that p -
// q is the normal of: a certificate that needs no other algorithm.
TYPED_TEST(ClosestPoints, OfATriangleHaveItsCornersBehindTheirPlane) {
  using R = TypeParam;
  Random random(1);
  const double rounding = sizeof(R) == 4 ? 2e-3 : 1e-7;  // needles keep half of the digits
  for (int k = 0; k < 20000; ++k) {
    const Vector3<R> b = anywhere<R>(random);
    Vector3<R> c = anywhere<R>(random);
    if (k % 5 == 1) c = b * R(random(-1, 2));  // no area
    if (k % 5 == 2) c = b;
    const Vector3<R> p = anywhere<R>(random), w = closest_on_triangle(b, c, p), q = b * w.y + c * w.z;
    ASSERT_TRUE(w.x >= 0 && w.y >= 0 && w.z >= 0);
    ASSERT_NEAR(w.x + w.y + w.z, 1, 1e-6);
    for (const Vector3<R>& corner : {Vector3<R>{0, 0, 0}, b, c})
      ASSERT_LE(double(dot(p - q, corner - q)), rounding) << k;
  }
}

TYPED_TEST(ClosestPoints, OfTwoSegmentsHaveTheirEndsBehindTheirPlanes) {
  using R = TypeParam;
  Random random(2);
  const double rounding = sizeof(R) == 4 ? 5e-4 : 1e-10;  // nearly parallel ones lose half of the digits
  for (int k = 0; k < 20000; ++k) {
    Vector3<R> d = anywhere<R>(random), e = anywhere<R>(random);
    const Vector3<R> r = anywhere<R>(random);
    if (k % 5 == 1) e = d * R(random(-2, 2));  // parallel
    if (k % 5 == 2) d = {0, 0, 0};
    if (k % 5 == 3) e = {0, 0, 0};
    const SegmentPoints<R> at = closest_on_segments(d, e, r);
    ASSERT_TRUE(at.s >= 0 && at.s <= 1 && at.t >= 0 && at.t <= 1);
    const Vector3<R> one = d * at.s, other = r + e * at.t, apart = one - other;
    for (const Vector3<R>& end : {Vector3<R>{0, 0, 0}, d}) ASSERT_GE(dot(apart, end - one), -rounding) << k;
    for (const Vector3<R>& end : {r, r + e}) ASSERT_LE(dot(apart, end - other), rounding) << k;
  }
}

TEST(Sorter, SortsByKeyAndKeepsTheOrderOfEquals) {
  Random random(3);
  for (const int count : {0, 1, 2, 1000, 100000})
    for (const int bits : {3, 14}) {
      Sorter<OpenMP> sorter;
      std::vector<std::pair<unsigned, int>> expected;
      Keyed* const items = sorter.items(count);
      for (int i = 0; i < count; ++i) {
        items[i] = {unsigned(random.below(1 << bits)), i};
        expected.emplace_back(items[i].key, i);
      }
      std::sort(expected.begin(), expected.end());
      sorter.sort(OpenMP{3}, count, bits, 1 << bits);
      for (int i = 0; i < count; ++i) {
        ASSERT_EQ(sorter.sorted()[i].key, expected[i].first);
        ASSERT_EQ(sorter.sorted()[i].value, expected[i].second);
        ASSERT_LE(sorter.begin()[expected[i].first], i);
        ASSERT_GT(sorter.begin()[expected[i].first + 1], i);
      }
      EXPECT_EQ(sorter.begin()[0], 0);
      EXPECT_EQ(sorter.begin()[1 << bits], count);
    }
}

TEST(Sorter, SumsWhatComesBefore) {
  Random random(4);
  for (const int count : {0, 1, 8191, 8192, 50000}) {
    std::vector<int> values(count), expected(count);
    for (int& value : values) value = random.below(9);
    std::exclusive_scan(values.begin(), values.end(), expected.begin(), 0);
    const int sum = std::accumulate(values.begin(), values.end(), 0);
    Growing<OpenMP, int> memory;
    EXPECT_EQ(running_sum(OpenMP{2}, values.data(), count, memory), sum);
    EXPECT_EQ(values, expected);
  }
}

/// Triangles, some edges and loose particles among random points: each particle and edge owned by the first that has
/// it.
template <class R>
struct Tangle {
  std::vector<Box<R>> particles, boxes;
  std::vector<Simplex> simplices;

  explicit Tangle(int seed) {
    Random random(seed);
    std::vector<Vector3<R>> x;
    for (int i = 0; i < 120; ++i) x.push_back(anywhere<R>(random));
    for (const Vector3<R>& a : x) {
      const R m = R(random(0.001, 0.05));
      particles.push_back({{a.x - m, a.y - m, a.z - m, 0}, {a.x + m, a.y + m, a.z + m, 0}});
    }
    for (int t = 0; t < 90; ++t) {
      const int a = random.below(100), b = (a + 1 + random.below(5)) % 100, c = (b + 1 + random.below(5)) % 100;
      if (a == c) continue;
      simplices.push_back({{a, b, t % 9 == 0 ? b : c}, t % 9 == 0 ? 0 : 1 << 6});
    }
    for (int i = 100; i < 120; ++i) simplices.push_back({{i, i, i}, 0});
    std::vector<int> taken;
    std::vector<std::pair<int, int>> sides;
    for (Simplex& s : simplices)
      for (int k = 0; k < 3; ++k) {
        if (std::find(taken.begin(), taken.end(), s.corner[k]) == taken.end())
          s.has |= 1 << k, taken.push_back(s.corner[k]);
        const std::pair<int, int> side = std::minmax(int(s.from(k)), int(s.to(k)));
        if (side.first != side.second && std::find(sides.begin(), sides.end(), side) == sides.end())
          s.has |= 8 << k, sides.push_back(side);
      }
    for (const Simplex& s : simplices)
      boxes.push_back(around(around(particles[s.corner[0]], particles[s.corner[1]]), particles[s.corner[2]]));
  }

  std::vector<Candidate> found(double cell) const {
    const int n = static_cast<int>(simplices.size());
    const Grid<R> grid{R(1 / cell), 7};
    std::vector<int> place(n);
    for (int e = 0; e < n; ++e) CountCells<R>{grid, boxes.data(), place.data()}(e);
    Growing<Serial, int> memory;
    const int total = running_sum(Serial{}, place.data(), n, memory);
    Sorter<Serial> cells;
    const EnterCells<R> enter{grid, boxes.data(), place.data(), cells.items(total)};
    for (int e = 0; e < n; ++e) enter(e);
    cells.sort(Serial{}, total, grid.bits, 1 << grid.bits);
    std::vector<Candidate> candidates;
    const FindCandidates<R, false> count{grid,           particles.data(), simplices.data(), boxes.data(),
                                         cells.sorted(), cells.begin(),    place.data(),     nullptr};
    for (int e = 0; e < n; ++e) count(e);
    candidates.resize(running_sum(Serial{}, place.data(), n, memory));
    const FindCandidates<R, true> lay{grid,           particles.data(), simplices.data(), boxes.data(),
                                      cells.sorted(), cells.begin(),    place.data(),     candidates.data()};
    for (int e = 0; e < n; ++e) lay(e);
    return candidates;
  }

  /// Whichever of two edges is named first, and of its ends.
  static std::array<int, 5> canonical(const Candidate& c) {
    if (!c.are_edges()) return {0, c.i[0], c.i[1], c.i[2], c.i[3]};
    std::array<std::pair<int, int>, 2> edges{std::minmax({c.particle(0), c.particle(1)}),
                                             std::minmax({c.particle(2), c.particle(3)})};
    std::sort(edges.begin(), edges.end());
    return {1, edges[0].first, edges[0].second, edges[1].first, edges[1].second};
  }

  std::vector<std::array<int, 5>> by_brute_force() const {
    std::vector<std::array<int, 5>> all;
    const auto shares = [](std::initializer_list<int> a, std::initializer_list<int> b) {
      return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
    };
    for (std::size_t e = 0; e < simplices.size(); ++e)
      for (std::size_t f = 0; f < simplices.size(); ++f) {
        const Simplex &a = simplices[e], &b = simplices[f];
        for (int k = 0; k < 3; ++k) {
          if (a.owns_corner(k) && b.is_face() && e != f && overlap(particles[a.corner[k]], boxes[f]) &&
              !shares({a.corner[k]}, {b.corner[0], b.corner[1], b.corner[2]}))
            all.push_back({0, a.corner[k], b.corner[0], b.corner[1], b.corner[2]});
          for (int l = 0; l < 3 && e < f; ++l)
            if (a.owns_edge(k) && b.owns_edge(l) && !shares({a.from(k), a.to(k)}, {b.from(l), b.to(l)}) &&
                overlap(around(particles[a.from(k)], particles[a.to(k)]),
                        around(particles[b.from(l)], particles[b.to(l)])))
              all.push_back(canonical({{~a.from(k), a.to(k), b.from(l), b.to(l)}}));
        }
      }
    std::sort(all.begin(), all.end());
    return all;
  }
};

template <class R>
class HashGrid : public testing::Test {};
TYPED_TEST_SUITE(HashGrid, Precisions);

TYPED_TEST(HashGrid, FindsExactlyThePairsThatBruteForceFindsAndInOneOrder) {
  for (int seed = 1; seed <= 2; ++seed) {
    const Tangle<TypeParam> tangle(seed);
    const std::vector<std::array<int, 5>> expected = tangle.by_brute_force();
    ASSERT_GT(expected.size(), 100u);
    std::vector<std::array<int, 4>> order;
    for (const double cell : {0.35, 0.8, 10.0}) {
      std::vector<std::array<int, 5>> found;
      std::vector<std::array<int, 4>> in_order;
      for (const Candidate& c : tangle.found(cell)) {
        found.push_back(Tangle<TypeParam>::canonical(c));
        in_order.push_back({c.i[0], c.i[1], c.i[2], c.i[3]});
      }
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected) << "cells of " << cell;
      if (order.empty()) order = in_order;
      EXPECT_EQ(in_order, order) << "cells of " << cell;
    }
  }
}

}  // namespace
}  // namespace malha
