// SPDX-License-Identifier: Apache-2.0
// The broad phase of self-collision: the pairs that it finds, and their layout in contact blocks, patches and colours.
#include "host/self_collision/pair_search.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <utility>

#include "kernels/geometry/closest_point.h"
#include "kernels/simd/rows.h"
#include "tests/numbers.h"

namespace malha {
namespace {

constexpr double kPairThickness = 0.02;

/// A search, and the pairs that it has found.
template <class R>
struct Searched {
  PairSearch<Serial, R> search;
  SelfContacts<Serial, R> contacts;
};

/// Triangles, some edges and loose particles among random points with random displacements: each particle and edge is
/// owned by the first primitive that has it. There are two bodies, and long thin triangles too.
template <class R>
struct Tangle {
  static constexpr int kCount = 420;
  SelfSurface surface;
  std::vector<Vec3> x;
  Array<Serial, Vec4<R>> x0, moved;
  Array<Serial, unsigned char> takes_part;

  explicit Tangle(unsigned seed) {
    Random random(seed);
    std::vector<Vec4<R>> start, way;
    for (int i = 0; i < kCount; ++i) {
      const Vector3<double> a = random.in_cube(0.4), d = random.in_cube(i % 7 == 0 ? 0.05 : 0.01);
      x.push_back({double(R(a.x)), double(R(a.y)), double(R(a.z))});
      start.push_back({R(a.x), R(a.y), R(a.z), R(0)});
      way.push_back({R(d.x), R(d.y), R(d.z), R(1)});
    }
    start.push_back({}), way.push_back({});
    x0 = Array<Serial, Vec4<R>>(start), moved = Array<Serial, Vec4<R>>(way);
    std::vector<Simplex>& simplices = surface.simplices;
    std::set<std::array<int, 3>> once;
    for (int t = 0; t < 330; ++t) {
      const int a = random.below(400), b = (a + 1 + random.below(5)) % 400, c = (b + 1 + random.below(5)) % 400;
      std::array<int, 3> corners{a, b, t % 9 == 0 ? b : c};
      std::sort(corners.begin(), corners.end());
      if (a != c && once.insert(corners).second)
        simplices.push_back({{a, b, t % 9 == 0 ? b : c}, t % 9 == 0 ? 0 : 1 << 6});
    }
    for (int i = 400; i < kCount; ++i) simplices.push_back({{i, i, i}, 0});
    std::set<int> taken;
    std::set<std::pair<int, int>> sides;
    for (Simplex& s : simplices)
      for (int k = 0; k < 3; ++k) {
        if (taken.insert(s.corner[k]).second) s.has |= 1 << k;
        const std::pair<int, int> side = std::minmax(int(s.from(k)), int(s.to(k)));
        if (side.first != side.second && sides.insert(side).second) s.has |= 8 << k;
      }
    surface.takes_part.assign(kCount, 1), surface.body.assign(kCount, 0);
    for (int i = 200; i < kCount; ++i) surface.body[i] = 1;
    takes_part = Array<Serial, unsigned char>(surface.takes_part);
  }

  Searched<R> searched() const { return searched(moved); }
  Searched<R> searched(const Array<Serial, Vec4<R>>& ways) const {
    PairSearch<Serial, R> search(Serial{}, surface, x, kPairThickness);
    SelfContacts<Serial, R> contacts(Serial{}, kCount, search.clusters(), kPairThickness, 0, 1e-3);
    search.search({x0.data(), ways.data()}, {0, 0, 0}, 8, contacts);
    return {std::move(search), std::move(contacts)};
  }
};

/// A key that is the same whichever of two edges is named first, and whichever of its ends.
std::array<int, 5> named(bool edges, const std::array<int, 4>& i) {
  if (!edges) {
    std::array<int, 5> all{0, i[0], i[1], i[2], i[3]};
    std::sort(all.begin() + 2, all.end());
    return all;
  }
  std::array<std::pair<int, int>, 2> both{std::minmax({i[0], i[1]}), std::minmax({i[2], i[3]})};
  std::sort(both.begin(), both.end());
  return {1, both[0].first, both[0].second, both[1].first, both[1].second};
}

template <class R>
std::set<std::array<int, 5>> found_by(const Searched<R>& searched) {
  std::set<std::array<int, 5>> found;
  const Pairs<R> pairs = searched.contacts.pairs();
  for (int u = 0; u < searched.search.clusters(); ++u)
    pairs.patches[u].for_each_block([&](int b, int section) {
      const ContactBlock<R>& block = pairs.blocks[b];
      std::multiset<int> particles;
      for (int k = 0; k < kPairBlock; ++k) {
        if (block.i[0][k] == pairs.padding) continue;
        std::array<int, 4> i{};
        for (int j = 0; j < 4; ++j) particles.insert(i[j] = block.i[j][k] / kIndexScale<R>);
        EXPECT_TRUE(found.insert(named(section > 0, i)).second) << "twice";
      }
      for (const int i : particles) EXPECT_EQ(particles.count(i), 1u) << "shared in a block";
    });
  return found;
}

template <class R>
class PairSearchOf : public testing::Test {};
using Numbers = testing::Types<float, double>;
TYPED_TEST_SUITE(PairSearchOf, Numbers);

// Wherever in the swept bounds particles are, every pair nearer than the search distance was found.
TYPED_TEST(PairSearchOf, ATangleFindsAllThatCanComeNear) {
  using R = TypeParam;
  for (const unsigned seed : {1u, 2u}) {
    const Tangle<R> tangle(seed);
    const Searched<R> searched = tangle.searched();
    const std::set<std::array<int, 5>> found = found_by(searched);
    ASSERT_GT(found.size(), 300u);
    EXPECT_EQ(static_cast<std::int64_t>(found.size()), searched.contacts.found());
    SelfMemory<R> memory;
    searched.search.save(memory);
    Random random(seed + 10);
    int near = 0;
    const auto check = [&]<PairKind kind>(const std::array<int, 4>& i) {
      Vector3<double> rest[4], at[4];
      double w[4];
      for (int j = 0; j < 4; ++j) rest[j] = {tangle.x[i[j]][0], tangle.x[i[j]][1], tangle.x[i[j]][2]};
      weigh<kind>(rest, w);
      const auto same_body = [&](int a, int b) { return tangle.surface.body[i[a]] == tangle.surface.body[i[b]]; };
      // An edge of the tangle may join two bodies, and either edge of a pair may come first.
      const bool one_body = same_body(0, 3) || (kind == PairKind::Edges && same_body(1, 2));
      const double wanted = one_body ? std::min(kPairThickness, 0.5 * norm(closest_offset(rest, w))) : kPairThickness;
      for (int trial = 0; trial < 4; ++trial) {
        for (int j = 0; j < 4; ++j) {
          const double part = trial == 0 ? 0 : trial == 1 ? 1 : random(0, 1);
          const auto& from = memory.from[i[j]];
          const auto& way = memory.way[i[j]];
          Vector3<double> beyond = random.in_cube(from[3]);
          if (norm(beyond) > from[3]) beyond = beyond * (from[3] / norm(beyond));
          at[j] = Vector3<double>{from[0], from[1], from[2]} + Vector3<double>{way[0], way[1], way[2]} * part + beyond;
        }
        weigh<kind>(at, w);
        if (norm(closest_offset(at, w)) >= wanted) continue;
        ++near;
        ASSERT_TRUE(found.count(named(kind == PairKind::Edges, i)) == 1) << i[0] << " " << i[1] << " " << i[2];
      }
    };
    std::vector<std::array<int, 2>> edges;
    std::vector<std::array<int, 3>> faces;
    std::set<int> points;
    for (const Simplex& s : tangle.surface.simplices) {
      for (int k = 0; k < 3; ++k) {
        if (s.owns_edge(k)) edges.push_back({s.from(k), s.to(k)});
        points.insert(s.corner[k]);
      }
      if (s.is_face()) faces.push_back({s.corner[0], s.corner[1], s.corner[2]});
    }
    for (const int p : points)
      for (const auto& f : faces)
        if (p != f[0] && p != f[1] && p != f[2]) check.template operator()<PairKind::Face>({p, f[0], f[1], f[2]});
    for (std::size_t a = 0; a < edges.size(); ++a)
      for (std::size_t b = a + 1; b < edges.size(); ++b) {
        const auto &e = edges[a], &f = edges[b];
        if (e[0] != f[0] && e[0] != f[1] && e[1] != f[0] && e[1] != f[1])
          check.template operator()<PairKind::Edges>({e[0], e[1], f[0], f[1]});
      }
    EXPECT_GT(near, 100);
  }
}

TYPED_TEST(PairSearchOf, ATangleFindsTheSameOnAnyNumberOfThreadsAndAgain) {
  using R = TypeParam;
  const Tangle<R> tangle(3);
  Searched<R> searched = tangle.searched();
  const auto first = found_by(searched);
  SelfMemory<R> memory;
  searched.search.save(memory);
  searched.search.restore(memory, searched.contacts);
  EXPECT_EQ(found_by(searched), first);
}

// Clusters outgrow their memory one after the other, as more and more particles move.
TYPED_TEST(PairSearchOf, ATangleFindsTheSameInMemoryThatGrowsAsInNewMemory) {
  using R = TypeParam;
  const Tangle<R> tangle(5);
  const auto moving = [&](int first) {
    std::vector<Vec4<R>> ways = tangle.moved.download();
    for (int i = first; i < tangle.kCount; ++i) ways[i] = {R(0), R(0), R(0), R(1)};
    return Array<Serial, Vec4<R>>(ways);
  };
  Searched<R> grown = tangle.searched(moving(0));
  const std::int64_t at_rest = grown.contacts.found();
  for (int first = 0; first <= tangle.kCount; first += 20) {
    const Array<Serial, Vec4<R>> ways = moving(first);
    grown.search.search({tangle.x0.data(), ways.data()}, {0, 0, 0}, 8, grown.contacts);
    ASSERT_EQ(found_by(grown), found_by(tangle.searched(ways))) << first;
  }
  EXPECT_GT(grown.contacts.found(), 2 * at_rest);
}

// No particle is in two patches of a colour.
TYPED_TEST(PairSearchOf, ATangleHasColoursOfPatchesThatShareNothing) {
  using R = TypeParam;
  const Tangle<R> tangle(4);
  const Searched<R> searched = tangle.searched();
  const SelfContacts<Serial, R>& contacts = searched.contacts;
  EXPECT_GT(contacts.colours(), 1);
  const Pairs<R> pairs = contacts.pairs();
  for (int colour = 0; colour < contacts.colours(); ++colour) {
    std::vector<int> patches;
    contacts.in_colour(Serial{}, colour, [&](const auto& group) { patches.push_back(group.index); });
    std::set<int> seen;
    for (const int u : patches)
      for (int k = 0; k < pairs.patches[u].particle_count; ++k)
        EXPECT_TRUE(seen.insert(pairs.patch_particles[pairs.patches[u].particles_begin + k]).second)
            << "colour " << colour;
  }
}

}  // namespace
}  // namespace malha
