// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <vector>

#include "kernels/simd/rows.h"
#include "tests/numbers.h"

namespace malha {
namespace {

/// Packs of R of this many bytes: every width of every instruction set, whatever this build is compiled for.
template <class R, int size>
struct Width {
  using Real = R;
  static constexpr int bytes = size;
};

template <class Width>
struct PackOf : testing::Test {
  using Real = typename Width::Real;
  using Wide = Pack<Real, Width::bytes>;
  static constexpr int lanes = Wide::lanes;
  using Values = std::array<Real, Wide::lanes>;

  static Wide pack(const Values& values) {
    Wide loaded;
    load(values.data(), loaded);
    return loaded;
  }
  static Values values(const Wide& from) {
    Values to;
    store(from, to.data());
    return to;
  }
  /// Random numbers of all sizes, with the special ones among them.
  static Values any(Random& random) {
    using Limits = std::numeric_limits<Real>;
    const Real special[] = {Real(0),      -Real(0), Limits::infinity(), -Limits::infinity(), Limits::denorm_min(),
                            Limits::max()};
    Values all;
    for (Real& a : all) {
      a = Real(random() * std::pow(10.0, random(-30, 30)));
      if (random.below(5) == 0) a = special[random.below(6)];
    }
    return all;
  }
  /// Particle i is at (i, i + 0.25, i + 0.5) with w = i + 0.75, so that every number tells its index.
  static std::vector<Vec4<Real>> numbered(int count) {
    std::vector<Vec4<Real>> particles(count);
    for (int i = 0; i < count; ++i) particles[i] = {Real(i), Real(i + 0.25), Real(i + 0.5), Real(i + 0.75)};
    return particles;
  }
  /// The same particles in the layout that packs load.
  static LocalIndex scaled(int i) { return static_cast<LocalIndex>(i * kIndexScale<Real>); }
  static std::vector<int> shuffled(int count, Random& random) {
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    for (int i = count - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
    return order;
  }
};

using Widths =
    testing::Types<Width<float, 16>, Width<float, 32>, Width<float, 64>, Width<double, 32>, Width<double, 64>>;
TYPED_TEST_SUITE(PackOf, Widths);

template <class R>
void expect_same(R found, R expected, const char* what) {
  if (std::isnan(expected)) {  // IEEE 754 does not say which NaN results
    EXPECT_TRUE(std::isnan(found)) << what;
  } else {
    EXPECT_TRUE(same_bits(found, expected)) << what << ": " << found << " instead of " << expected;
  }
}

TYPED_TEST(PackOf, LanesAreTheScalarOperationsBitForBit) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto a = this->any(random), b = this->any(random);
    const P A = this->pack(a), B = this->pack(b);
    const auto sum = this->values(A + B), difference = this->values(A - B), product = this->values(A * B),
               quotient = this->values(A / B), negative = this->values(-A), greater = this->values(max(A, B)),
               less = this->values(select(A < B, A, B)), more = this->values(select(A > B, A, B)),
               square_root = this->values(sqrt(max(A, -A)));
    for (int lane = 0; lane < this->lanes; ++lane) {
      const R x = a[lane], y = b[lane];
      expect_same(sum[lane], R(x + y), "+");
      expect_same(difference[lane], R(x - y), "-");
      expect_same(product[lane], R(x * y), "*");
      expect_same(quotient[lane], R(x / y), "/");
      expect_same(negative[lane], R(-x), "negation");
      expect_same(greater[lane], max(x, y), "larger");
      expect_same(less[lane], select(x < y, x, y), "select <");
      expect_same(more[lane], select(x > y, x, y), "select >");
      expect_same(square_root[lane], sqrt(max(x, -x)), "root");
    }
  }
}

TYPED_TEST(PackOf, BroadcastsAScalarToEveryLane) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  for (const R value : {R(0), R(1) / R(3), -R(2), std::numeric_limits<R>::infinity()})
    for (const R lane : this->values(P(value))) EXPECT_TRUE(same_bits(lane, value));
  for (const R lane : this->values(P(-R(0)))) EXPECT_TRUE(same_bits(lane, R(0)));
}

TYPED_TEST(PackOf, MaxTakesTheSecondOfNaNAsTheScalarDoes) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  const R nan = std::numeric_limits<R>::quiet_NaN();
  for (const R lane : this->values(max(P(nan), P(R(1))))) EXPECT_EQ(lane, R(1));
  EXPECT_EQ(max(nan, R(1)), R(1));
}

TYPED_TEST(PackOf, LoadsAndStoresAnywhere) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  Random random(5);
  for (int offset = 0; offset < 2 * this->lanes; ++offset) {
    std::vector<R> from(4 * this->lanes), to(4 * this->lanes, R(-1));
    for (R& a : from) a = R(random());
    P pack;
    load(from.data() + offset, pack);
    for (int i = 0; i < this->lanes; ++i) EXPECT_EQ(lane(pack, i), from[offset + i]);
    store(pack, to.data() + offset);
    for (int i = 0; i < 4 * this->lanes; ++i) {
      const bool inside = offset <= i && i < offset + this->lanes;
      EXPECT_EQ(to[i], inside ? from[i] : R(-1)) << i << " from " << offset;
    }
  }
}

TYPED_TEST(PackOf, SetsOneLaneAndLeavesTheOthers) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  for (int at = 0; at < this->lanes; ++at) {
    P pack(R(3));
    set_lane(pack, at, R(7));
    for (int i = 0; i < this->lanes; ++i) EXPECT_EQ(lane(pack, i), i == at ? R(7) : R(3));
  }
}

TYPED_TEST(PackOf, IsEqualToItselfWhereItIsANumber) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  P pack(R(3));
  set_lane(pack, 1, std::numeric_limits<R>::quiet_NaN());
  const auto chosen = this->values(select(pack == pack, P(R(1)), P(R(0))));
  for (int i = 0; i < this->lanes; ++i) EXPECT_EQ(chosen[i], i == 1 ? R(0) : R(1));
}

TYPED_TEST(PackOf, GatherPutsTheIndexedParticleIntoItsLane) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  Random random(2);
  auto particles = this->numbered(100);
  for (int trial = 0; trial < 50; ++trial) {
    int chosen[P::lanes];
    LocalIndex index[P::lanes];
    for (int i = 0; i < P::lanes; ++i) {
      chosen[i] = random.below(100);  // repeated ones too: indices of loads need not be distinct
      index[i] = this->scaled(chosen[i]);
    }
    Vector3<P> position;
    P w;
    gather_rows(particles.data(), index, position, w);
    for (int i = 0; i < P::lanes; ++i) {
      const Vec4<R>& expected = particles[chosen[i]];
      EXPECT_EQ(lane(position.x, i), expected.x);
      EXPECT_EQ(lane(position.y, i), expected.y);
      EXPECT_EQ(lane(position.z, i), expected.z);
      EXPECT_EQ(lane(w, i), expected.w);
    }
  }
}

TYPED_TEST(PackOf, TransposeIsItsOwnInverseAndSwapsRowsWithLanesOfEachBlock) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  typename P::Vector rows[4];
  for (int row = 0; row < 4; ++row)
    for (int lane = 0; lane < this->lanes; ++lane) rows[row][lane] = R(100 * row + lane);
  detail::transpose<P::lanes>(rows[0], rows[1], rows[2], rows[3]);
  for (int row = 0; row < 4; ++row)
    for (int lane = 0; lane < this->lanes; ++lane)
      EXPECT_EQ(rows[row][lane], R(100 * (lane % 4) + lane / 4 * 4 + row)) << "row " << row << ", lane " << lane;
  detail::transpose<P::lanes>(rows[0], rows[1], rows[2], rows[3]);
  for (int row = 0; row < 4; ++row)
    for (int lane = 0; lane < this->lanes; ++lane) EXPECT_EQ(rows[row][lane], R(100 * row + lane));
}

TYPED_TEST(PackOf, ScatterWritesEveryLaneToItsParticleAndNothingElse) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const auto order = this->shuffled(40, random);
    std::vector<LocalIndex> index;
    for (const int i : order) index.push_back(this->scaled(i));
    const auto before = this->numbered(40);
    auto particles = before;
    Vector3<P> position;
    P w;
    gather_rows(particles.data(), index.data(), position, w);
    scatter_rows(particles.data(), index.data(), position * P(R(-2)), w);
    for (int k = 0; k < 40; ++k) {
      const Vec4<R>&a = particles[order[k]], &b = before[order[k]];
      const R factor = k < P::lanes ? R(-2) : R(1);
      EXPECT_TRUE(a.x == factor * b.x && a.y == factor * b.y && a.z == factor * b.z && a.w == b.w) << k;
    }
  }
}

TYPED_TEST(PackOf, OneParticleIsGatheredAndScatteredByTheSameIndex) {
  using R = typename TypeParam::Real;
  auto particles = this->numbered(40);
  const LocalIndex index = this->scaled(7);
  Vector3<R> position;
  R w;
  gather_rows(particles.data(), &index, position, w);
  EXPECT_EQ(position.x, R(7));
  scatter_rows(particles.data(), &index, position * R(2), w);
  EXPECT_EQ(particles[7].x, R(14));
  EXPECT_EQ(particles[7].w, R(7.75));
}

TYPED_TEST(PackOf, AParticleIsOneAlignedLoad) {
  using R = typename TypeParam::Real;
  using P = typename TestFixture::Wide;
  EXPECT_EQ(sizeof(Vec4<R>), 4 * sizeof(R));
  EXPECT_EQ(alignof(Vec4<R>), 4 * sizeof(R));
  EXPECT_EQ(P::lanes % 4, 0);  // transposes work on blocks of four
}

}  // namespace
}  // namespace malha
