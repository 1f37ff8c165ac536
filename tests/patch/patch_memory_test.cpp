// SPDX-License-Identifier: Apache-2.0
#include "kernels/projection/patch_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

constexpr int kSlots = 64;

/// Tests that both layouts of a patch's memory must pass.
template <class Local>
struct LayoutOf;
template <class R>
struct LayoutOf<SoaView<R>> {
  using Real = R;
};
template <class R>
struct LayoutOf<AosView<R>> {
  using Real = R;
};

template <class Local>
struct PatchMemoryView : testing::Test {
  using Real = typename LayoutOf<Local>::Real;
  using Wide = Lane<Real>;
  alignas(64) Real memory[kNumbersPerParticle * kSlots];
  const Local local = Local::over(memory, kSlots);

  /// Particle i starts at (i, i + 1/8, i + 2/8) with w = i + 3/8 and is displaced by (i + 4/8, i + 5/8, i + 6/8), so
  /// that every number tells its slot.
  PatchMemoryView() {
    for (int i = 0; i < kSlots; ++i) local.store_particle(i, moving(Real(i), Real(i)));
  }
  static Vector3<Real> three(Real a, int eighths) {
    const Real x = a + Real(0.125 * eighths);
    return {x, x + Real(0.125), x + Real(0.25)};
  }
  static PatchParticle<Real> moving(Real from, Real way) { return {three(from, 0), three(way, 4), from + Real(0.375)}; }
  void expect_at(int i, Real from, Real way) const {
    PatchParticle<Real> q;
    local.load_particle(i, q);
    EXPECT_TRUE(same(q, moving(from, way))) << "particle " << i;
    EXPECT_TRUE(malha::same(local.template load_displacement<Real>(i), three(way, 4))) << "particle " << i;
  }
  static void expect_lane(const PatchParticle<Wide>& q, int i, Real a) {
    const PatchParticle<Real> of{{lane(q.x.x, i), lane(q.x.y, i), lane(q.x.z, i)},
                                 {lane(q.d.x, i), lane(q.d.y, i), lane(q.d.z, i)},
                                 lane(q.w, i)};
    EXPECT_TRUE(same(of, moving(a, a))) << "lane " << i;
  }
  static bool same(const PatchParticle<Real>& a, const PatchParticle<Real>& b) {
    return malha::same(a.x, b.x) && malha::same(a.d, b.d) && a.w == b.w;
  }
  static Vector3<Wide> by(Real size) { return {Wide(size), Wide(size), Wide(size)}; }
};

using Layouts = testing::Types<SoaView<float>, SoaView<double>, AosView<float>, AosView<double>>;
TYPED_TEST_SUITE(PatchMemoryView, Layouts);

TYPED_TEST(PatchMemoryView, KeepsEachParticleInItsSlot) {
  using R = typename TestFixture::Real;
  for (int i = 0; i < kSlots; ++i) this->expect_at(i, R(i), R(i));
}

TYPED_TEST(PatchMemoryView, LoadsAPackFromAnySlotOn) {
  using R = typename TestFixture::Real;
  for (int at = 0; at + kLanes<R> <= kSlots; ++at) {
    PatchParticle<Lane<R>> q;
    this->local.load_particle(at, q);
    for (int i = 0; i < kLanes<R>; ++i) this->expect_lane(q, i, R(at + i));
  }
}

TYPED_TEST(PatchMemoryView, StoresAPackThereAndNowhereElse) {
  using R = typename TestFixture::Real;
  for (const int at : {0, 3, kSlots - kLanes<R>}) {
    PatchParticle<Lane<R>> q;
    this->local.load_particle(at, q);
    const auto expect_further = [&](int by) {
      for (int i = 0; i < kSlots; ++i) this->expect_at(i, R(i), R(i + (at <= i && i < at + kLanes<R> ? by : 0)));
    };
    this->local.store_displacement(at, q.d + this->by(1000));
    expect_further(1000);
    this->local.add_displacement(at, this->by(500));
    expect_further(1500);
    this->local.store_displacement(at, q.d);
  }
}

TYPED_TEST(PatchMemoryView, FillsAPackWithAllOfIt) {
  using R = typename TestFixture::Real;
  PatchParticle<Lane<R>> q;
  this->local.load_particle(0, q);
  this->local.store_particle(20, q);
  for (int i = 0; i < kSlots; ++i) {
    const R a = R(20 <= i && i < 20 + kLanes<R> ? i - 20 : i);
    this->expect_at(i, a, a);
  }
}

TYPED_TEST(PatchMemoryView, ShowsItsPositionsAndDisplacementsAsPoints) {
  using R = typename TestFixture::Real;
  const auto places = this->local.positions(), ways = this->local.displacements();
  for (int i = 0; i < kSlots; ++i) {
    EXPECT_TRUE(same(places[i], this->three(R(i), 0))) << i;
    EXPECT_TRUE(same(ways[i], this->three(R(i), 4))) << i;
  }
}

TYPED_TEST(PatchMemoryView, GathersAndScattersTheIndexedParticles) {
  using R = typename TestFixture::Real;
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<int> chosen;  // distinct, as in the full packs of a batch
    std::vector<LocalIndex> index;
    while (static_cast<int>(chosen.size()) < kLanes<R>)
      if (const int i = random.below(kSlots); std::find(chosen.begin(), chosen.end(), i) == chosen.end())
        chosen.push_back(i), index.push_back(static_cast<LocalIndex>(i * kIndexScale<R>));
    PatchParticle<Lane<R>> q;
    this->local.gather(index.data(), q);
    for (int i = 0; i < kLanes<R>; ++i) this->expect_lane(q, i, R(chosen[i]));
    if constexpr (!TypeParam::is_soa) {
      this->local.scatter(index.data(), q.d + this->by(1000));
      for (int i = 0; i < kSlots; ++i) {
        const bool moved = std::find(chosen.begin(), chosen.end(), i) != chosen.end();
        this->expect_at(i, R(i), R(i + (moved ? 1000 : 0)));
      }
      this->local.scatter(index.data(), q.d);
    }
  }
}

TYPED_TEST(PatchMemoryView, FromASlotOnIsCountedFromThere) {
  if constexpr (TypeParam::is_soa) {
    const TypeParam from = this->local.from(17);
    PatchParticle<typename TestFixture::Real> q;
    from.load_particle(3, q);
    EXPECT_EQ(q.x.x, 20);
    EXPECT_EQ(q.w, 20.375);
    from.store_displacement(3, decltype(q.d){1, 2, 3});
    this->local.load_particle(20, q);
    EXPECT_EQ(q.x.x, 20);
    EXPECT_EQ(q.d.z, 3);
    EXPECT_EQ(q.w, 20.375);
  }
}

}  // namespace
}  // namespace malha
