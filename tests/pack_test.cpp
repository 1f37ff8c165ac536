#include "kernels/pack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

template <class R>
struct PackOf : testing::Test {
  static constexpr int lanes = kLanes<R>;
  using Values = std::array<R, kLanes<R>>;

  static Pack<R> pack(const Values& values) {
    alignas(kPackBytes) R aligned[lanes];
    std::copy(values.begin(), values.end(), aligned);
    Pack<R> loaded;
    load(aligned, loaded);
    return loaded;
  }
  static Values values(const Pack<R>& from) {
    alignas(kPackBytes) R aligned[lanes];
    store(from, aligned);
    Values to;
    std::copy_n(aligned, lanes, to.begin());
    return to;
  }
  /// Random numbers of all sizes, with the special ones among them.
  static Values any(Random& random) {
    using Limits = std::numeric_limits<R>;
    const R special[] = {R(0), -R(0), Limits::infinity(), -Limits::infinity(), Limits::denorm_min(), Limits::max()};
    Values all;
    for (R& a : all) {
      a = R(random() * std::pow(10.0, random(-30, 30)));
      if (random.below(5) == 0) a = special[random.below(6)];
    }
    return all;
  }
  /// Particle i at (i, i + 0.25, i + 0.5) with w = i + 0.75: every number says where it belongs.
  static std::vector<Vec4<R>> numbered(int count) {
    std::vector<Vec4<R>> particles(count);
    for (int i = 0; i < count; ++i) particles[i] = {R(i), R(i + 0.25), R(i + 0.5), R(i + 0.75)};
    return particles;
  }
  static std::vector<int> shuffled(int count, Random& random) {
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    for (int i = count - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
    return order;
  }
};

using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(PackOf, Reals);

template <class R>
void expect_same(R found, R expected, const char* what) {
  if (std::isnan(expected)) {  // which NaN comes out is not part of IEEE 754
    EXPECT_TRUE(std::isnan(found)) << what;
  } else {
    EXPECT_TRUE(same_bits(found, expected)) << what << ": " << found << " instead of " << expected;
  }
}

TYPED_TEST(PackOf, LanesAreTheScalarOperationsBitForBit) {
  using R = TypeParam;
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto a = this->any(random), b = this->any(random);
    const Pack<R> A = this->pack(a), B = this->pack(b);
    const auto sum = this->values(A + B), difference = this->values(A - B), product = this->values(A * B),
               quotient = this->values(A / B), negative = this->values(-A), greater = this->values(larger(A, B)),
               less = this->values(select(A < B, A, B)), more = this->values(select(A > B, A, B)),
               square_root = this->values(root(larger(A, -A)));
    for (int lane = 0; lane < this->lanes; ++lane) {
      const R x = a[lane], y = b[lane];
      expect_same(sum[lane], R(x + y), "+");
      expect_same(difference[lane], R(x - y), "-");
      expect_same(product[lane], R(x * y), "*");
      expect_same(quotient[lane], R(x / y), "/");
      expect_same(negative[lane], R(-x), "negation");
      expect_same(greater[lane], larger(x, y), "larger");
      expect_same(less[lane], select(x < y, x, y), "select <");
      expect_same(more[lane], select(x > y, x, y), "select >");
      expect_same(square_root[lane], root(larger(x, -x)), "root");
    }
  }
}

TYPED_TEST(PackOf, BroadcastsAScalarToEveryLane) {
  using R = TypeParam;
  for (const R value : {R(0), -R(0), R(1) / R(3), std::numeric_limits<R>::infinity()})
    for (const R lane : this->values(Pack<R>(value))) EXPECT_TRUE(same_bits(lane, value));
}

TYPED_TEST(PackOf, LargerTakesTheSecondOfNaNAsTheScalarDoes) {
  using R = TypeParam;
  const R nan = std::numeric_limits<R>::quiet_NaN();
  for (const R lane : this->values(larger(Pack<R>(nan), Pack<R>(R(1))))) EXPECT_EQ(lane, R(1));
  EXPECT_EQ(larger(nan, R(1)), R(1));
}

TYPED_TEST(PackOf, GatherPutsTheIndexedParticleIntoItsLane) {
  using R = TypeParam;
  Random random(2);
  const auto particles = this->numbered(100);
  for (int trial = 0; trial < 50; ++trial) {
    int index[kLanes<R>];
    for (int& i : index) i = random.below(100);  // repeated ones too: loads need not be distinct
    Vector3<Pack<R>> position;
    Pack<R> w;
    gather(particles.data(), index, position, w);
    const auto x = this->values(position.x), y = this->values(position.y), z = this->values(position.z),
               fourth = this->values(w);
    for (int lane = 0; lane < this->lanes; ++lane) {
      const Vec4<R>& expected = particles[index[lane]];
      EXPECT_EQ(x[lane], expected.x);
      EXPECT_EQ(y[lane], expected.y);
      EXPECT_EQ(z[lane], expected.z);
      EXPECT_EQ(fourth[lane], expected.w);
    }
  }
}

TYPED_TEST(PackOf, TransposeIsItsOwnInverseAndSwapsRowsWithLanesOfEachBlock) {
  using R = TypeParam;
  typename Pack<R>::Vector rows[4];
  for (int row = 0; row < 4; ++row)
    for (int lane = 0; lane < this->lanes; ++lane) rows[row][lane] = R(100 * row + lane);
  detail::transpose<kLanes<R>>(rows[0], rows[1], rows[2], rows[3]);
  for (int row = 0; row < 4; ++row)
    for (int lane = 0; lane < this->lanes; ++lane)
      EXPECT_EQ(rows[row][lane], R(100 * (lane % 4) + lane / 4 * 4 + row)) << "row " << row << ", lane " << lane;
  detail::transpose<kLanes<R>>(rows[0], rows[1], rows[2], rows[3]);
  for (int row = 0; row < 4; ++row)
    for (int lane = 0; lane < this->lanes; ++lane) EXPECT_EQ(rows[row][lane], R(100 * row + lane));
}

TYPED_TEST(PackOf, ScatterWritesEveryLaneToItsParticleAndNothingElse) {
  using R = TypeParam;
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const auto order = this->shuffled(40, random);
    const auto before = this->numbered(40);
    auto particles = before;
    Vector3<Pack<R>> position;
    Pack<R> w;
    gather(particles.data(), order.data(), position, w);
    scatter(particles.data(), order.data(), position * Pack<R>(R(-2)), w);
    for (int k = 0; k < 40; ++k) {
      const Vec4<R>&a = particles[order[k]], &b = before[order[k]];
      const R factor = k < this->lanes ? R(-2) : R(1);
      EXPECT_TRUE(a.x == factor * b.x && a.y == factor * b.y && a.z == factor * b.z && a.w == b.w) << k;
    }
  }
}

TYPED_TEST(PackOf, ScatterMovableLeavesPinnedParticlesAndPaddingAlone) {
  using R = TypeParam;
  Random random(4);
  for (int count = 1; count <= this->lanes; ++count) {
    const auto order = this->shuffled(40, random);
    auto before = this->numbered(40);
    for (int k = 0; k < this->lanes; k += 3) before[order[k]].w = R(0);
    auto particles = before;
    Vector3<Pack<R>> position;
    Pack<R> w;
    gather(particles.data(), order.data(), position, w);
    scatter_movable(particles.data(), order.data(), count, position * Pack<R>(R(-2)), w);
    for (int k = 0; k < 40; ++k) {
      const Vec4<R>&a = particles[order[k]], &b = before[order[k]];
      const R factor = k < count && k % 3 != 0 ? R(-2) : R(1);
      EXPECT_TRUE(a.x == factor * b.x && a.y == factor * b.y && a.z == factor * b.z && a.w == b.w)
          << k << " of " << count;
    }
  }
}

TYPED_TEST(PackOf, AParticleIsOneAlignedLoad) {
  using R = TypeParam;
  EXPECT_EQ(sizeof(Vec4<R>), 4 * sizeof(R));
  EXPECT_EQ(alignof(Vec4<R>), 4 * sizeof(R));
  EXPECT_EQ(kLanes<R> % 4, 0);  // transposes work on blocks of four
}

}  // namespace
}  // namespace malha
