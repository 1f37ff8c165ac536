#include "kernels/local.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

constexpr int kSlots = 64;

/// What both layouts of a patch's memory must do alike.
template <class Local>
struct LayoutOf;
template <class R>
struct LayoutOf<Columns<R>> {
  using Real = R;
};
template <class R>
struct LayoutOf<Rows<R>> {
  using Real = R;
};

template <class Local>
struct LocalMemory : testing::Test {
  using Real = typename LayoutOf<Local>::Real;
  using Wide = Lane<Real>;
  alignas(64) Real memory[4 * kSlots];
  const Local local = Local::over(memory, kSlots);

  /// Particle i at (i, i + 0.25, i + 0.5) with w = i + 0.75: every number says where it belongs.
  LocalMemory() {
    for (int i = 0; i < kSlots; ++i) put(i, Real(i), Real(i + 0.75));
  }
  void put(int i, Real a, Real w) { local.fill(i, Vector3<Real>{a, a + Real(0.25), a + Real(0.5)}, w); }
  void expect_at(int i, Real a, Real w) const {
    Vector3<Real> q;
    Real found;
    local.read(i, q, found);
    EXPECT_EQ(q.x, a) << "particle " << i;
    EXPECT_EQ(q.y, a + Real(0.25)) << "particle " << i;
    EXPECT_EQ(q.z, a + Real(0.5)) << "particle " << i;
    EXPECT_EQ(found, w) << "particle " << i;
  }
  static void expect_lane(const Vector3<Wide>& q, const Wide& w, int i, Real a) {
    EXPECT_EQ(lane(q.x, i), a) << "lane " << i;
    EXPECT_EQ(lane(q.y, i), a + Real(0.25)) << "lane " << i;
    EXPECT_EQ(lane(q.z, i), a + Real(0.5)) << "lane " << i;
    EXPECT_EQ(lane(w, i), a + Real(0.75)) << "lane " << i;
  }
};

using Layouts = testing::Types<Columns<float>, Columns<double>, Rows<float>, Rows<double>>;
TYPED_TEST_SUITE(LocalMemory, Layouts);

TYPED_TEST(LocalMemory, KeepsEachParticleInItsPlace) {
  using R = typename TestFixture::Real;
  for (int i = 0; i < kSlots; ++i) this->expect_at(i, R(i), R(i + 0.75));
}

TYPED_TEST(LocalMemory, ReadsAPackFromAnyPlaceOn) {
  using R = typename TestFixture::Real;
  for (int at = 0; at + kLanes<R> <= kSlots; ++at) {
    Vector3<Lane<R>> q;
    Lane<R> w;
    this->local.read(at, q, w);
    for (int i = 0; i < kLanes<R>; ++i) this->expect_lane(q, w, i, R(at + i));
  }
}

TYPED_TEST(LocalMemory, WritesAPackThereAndNowhereElse) {
  using R = typename TestFixture::Real;
  for (const int at : {0, 3, kSlots - kLanes<R>}) {
    Vector3<Lane<R>> q;
    Lane<R> w;
    this->local.read(at, q, w);
    const Lane<R> by(R(1000));
    this->local.fill(at, {q.x + by, q.y + by, q.z + by}, w);
    for (int i = 0; i < kSlots; ++i) this->expect_at(i, R(i + (at <= i && i < at + kLanes<R> ? 1000 : 0)), R(i + 0.75));
    this->local.fill(at, q, w);
  }
}

TYPED_TEST(LocalMemory, FillsAPackWithItsMassesToo) {
  using R = typename TestFixture::Real;
  Vector3<Lane<R>> q;
  Lane<R> w;
  this->local.read(0, q, w);
  this->local.fill(20, q, w);
  for (int i = 0; i < kSlots; ++i) {
    const R a = R(20 <= i && i < 20 + kLanes<R> ? i - 20 : i);
    this->expect_at(i, a, a + R(0.75));
  }
}

TYPED_TEST(LocalMemory, GathersAndScattersTheIndexedParticles) {
  using R = typename TestFixture::Real;
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<int> chosen;  // distinct, as for whole packs of a batch
    std::vector<LocalIndex> index;
    while (static_cast<int>(chosen.size()) < kLanes<R>)
      if (const int i = random.below(kSlots); std::find(chosen.begin(), chosen.end(), i) == chosen.end())
        chosen.push_back(i), index.push_back(static_cast<LocalIndex>(i * kIndexScale<R>));
    Vector3<Lane<R>> q;
    Lane<R> w;
    this->local.gather(index.data(), q, w);
    for (int i = 0; i < kLanes<R>; ++i) this->expect_lane(q, w, i, R(chosen[i]));
    if constexpr (!TypeParam::side_by_side) {
      const Lane<R> by(R(1000));
      this->local.scatter(index.data(), Vector3<Lane<R>>{q.x + by, q.y + by, q.z + by}, w);
      for (int i = 0; i < kSlots; ++i) {
        const bool moved = std::find(chosen.begin(), chosen.end(), i) != chosen.end();
        this->expect_at(i, R(i + (moved ? 1000 : 0)), R(i + 0.75));
      }
      this->local.scatter(index.data(), q, w);
    }
  }
}

TYPED_TEST(LocalMemory, FromAPlaceOnIsCountedFromThere) {
  if constexpr (TypeParam::side_by_side) {
    const TypeParam from = this->local.from(17);
    typename TestFixture::Real w;
    Vector3<typename TestFixture::Real> q;
    from.read(3, q, w);
    EXPECT_EQ(q.x, 20);
    EXPECT_EQ(w, 20.75);
    from.write(3, {1, 2, 3}, w);
    this->local.read(20, q, w);
    EXPECT_EQ(q.z, 3);
    EXPECT_EQ(w, 20.75);
  }
}

}  // namespace
}  // namespace malha
