// SPDX-License-Identifier: Apache-2.0
// Tiles of sixteen numbers in packs of any width, against sixteen scalars.
#include "kernels/simd/tile.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

template <class T>
struct NumberOf;
template <class Number, class Isa>
struct NumberOf<Tile<Number, Isa>> {
  using type = Number;
};

template <class T>
struct TileOf : testing::Test {
  TileOf() {
    Random random(1);
    for (R& number : a) number = R(random());
    for (R& number : b) number = R(random());
  }
  using R = typename NumberOf<T>::type;
  R a[16], b[16];
  R found[16];
};

using Tiles = testing::Types<Tile<float, Baseline>, Tile<float, Avx2>, Tile<float, Avx512>, Tile<double, Baseline>,
                             Tile<double, Avx2>, Tile<double, Avx512>>;
TYPED_TEST_SUITE(TileOf, Tiles);

TYPED_TEST(TileOf, SixteenComesFromAndGoesToAnyPlace) {
  std::vector<typename TestFixture::R> from(20), to(20, -1);
  for (int first = 0; first < 4; ++first) {
    for (int k = 0; k < 20; ++k) from[k] = k;
    TypeParam::load_from(from.data() + first).store_to(to.data() + first);
    for (int k = 0; k < 16; ++k) EXPECT_EQ(to[first + k], first + k);
  }
  EXPECT_EQ(to[19], -1) << "and no further";
  TypeParam::zero().store_to(this->found);
  for (const auto number : this->found) EXPECT_EQ(number, 0);
  TypeParam::broadcast(3).store_to(this->found);
  for (const auto number : this->found) EXPECT_EQ(number, 3);
}

TYPED_TEST(TileOf, IntegersAreThoseNumbers) {
  short from[17];
  for (int k = 0; k < 17; ++k) from[k] = static_cast<short>(k % 2 ? 32767 - k : -32767 + k);
  for (const int first : {0, 1}) {
    TypeParam::load_from(from + first).store_to(this->found);
    for (int k = 0; k < 16; ++k) EXPECT_EQ(this->found[k], from[first + k]);
  }
}

TYPED_TEST(TileOf, SumsAndProductsAreThoseOfScalars) {
  TypeParam t = TypeParam::load_from(this->a);
  t.add_product(TypeParam::load_from(this->b), TypeParam::load_from(this->a));
  t.store_to(this->found);
  for (int k = 0; k < 16; ++k) EXPECT_EQ(this->found[k], this->a[k] + this->b[k] * this->a[k]) << k;
}

template <int q, class T, class R>
void expect_splat(const R (&a)[16]) {
  R found[16];
  T::load_from(a).template splat_row<q>().store_to(found);
  for (int r = 0; r < 4; ++r)
    for (int k = 0; k < 4; ++k) EXPECT_EQ(found[4 * r + k], a[4 * q + r]) << q << ", row " << r;
}

TYPED_TEST(TileOf, ARowSpreadsOverTheRowsOfAnother) {
  expect_splat<0, TypeParam>(this->a);
  expect_splat<1, TypeParam>(this->a);
  expect_splat<2, TypeParam>(this->a);
  expect_splat<3, TypeParam>(this->a);
}

TYPED_TEST(TileOf, ARowRepeats) {
  const Vec4<typename TestFixture::R> row{this->a[0], this->a[1], this->a[2], this->a[3]};
  TypeParam::repeat_row(row).store_to(this->found);
  for (int k = 0; k < 16; ++k) EXPECT_EQ(this->found[k], this->a[k % 4]);
}

TYPED_TEST(TileOf, SumsAreAFixedTree) {
  const auto& all = this->a;
  const auto rows = TypeParam::load_from(all).sum_of_rows();
  for (int k = 0; k < 4; ++k) EXPECT_EQ((&rows.x)[k], (all[k] + all[4 + k]) + (all[8 + k] + all[12 + k]));
  // Four tiles are summed at once, each by this tree and then (x + y) + (z + w).
  const TypeParam own = TypeParam::load_from(all), other = TypeParam::load_from(this->b);
  TypeParam twice = TypeParam::zero(), four_times = TypeParam::zero();
  twice.add_product(own, TypeParam::broadcast(2)), four_times.add_product(other, TypeParam::broadcast(4));
  const auto sums = TypeParam::sums(own, other, twice, four_times);
  const auto others = other.sum_of_rows();
  EXPECT_EQ(sums.x, (rows.x + rows.y) + (rows.z + rows.w));
  EXPECT_EQ(sums.y, (others.x + others.y) + (others.z + others.w));
  EXPECT_EQ(sums.z, 2 * sums.x);
  EXPECT_EQ(sums.w, 4 * sums.y);
}

}  // namespace
}  // namespace malha
