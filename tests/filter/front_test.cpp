// SPDX-License-Identifier: Apache-2.0
// The elimination of a dense front, against Eigen's Cholesky factor, on packs of every width.
#include "kernels/filter/front.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "tests/numbers.h"

namespace malha {
namespace {

Eigen::MatrixXd random_matrix(int rows, int columns, Random& random) {
  Eigen::MatrixXd A(rows, columns);
  for (int k = 0; k < A.size(); ++k) A.data()[k] = random();
  return A;
}

template <class Isa>
struct FrontOn : testing::Test {
  Random random{7};
};
using Isas = testing::Types<Baseline, Avx2, Avx512>;
TYPED_TEST_SUITE(FrontOn, Isas);

/// The terms are subtracted in the order of `inner`, as the kernel promises: so the bits are those of this loop.
TYPED_TEST(FrontOn, AProductIsTakenAwayInTheOrderOfItsTerms) {
  for (const int rows : {1, 3, 4, 7, 8, 15, 16, 17, 31, 33, 63, 64, 65, 70})
    for (const int columns : {1, 3, 4, 5, 9, 40})
      for (const int inner : {0, 1, 2, 31, 127, 128, 129, 260})
        for (const bool transposed : {false, true}) {
          const int stride = rows + 3;
          Eigen::MatrixXd A = random_matrix(stride, std::max(inner, 1), this->random);
          Eigen::MatrixXd B = transposed ? random_matrix(columns + 2, std::max(inner, 1), this->random)
                                         : random_matrix(inner + 2, columns, this->random);
          const Eigen::MatrixXd before = random_matrix(stride, columns, this->random);
          Eigen::MatrixXd C = before, expected = before;
          SubtractProduct<double, TypeParam>{{C.data(), stride},
                                             {A.data(), stride},
                                             {B.data(), static_cast<int>(B.rows())},
                                             transposed,
                                             false,
                                             rows,
                                             columns,
                                             inner}
              .run();
          for (int j = 0; j < columns; ++j)
            for (int i = 0; i < rows; ++i)
              for (int k = 0; k < inner; ++k) expected(i, j) -= A(i, k) * (transposed ? B(j, k) : B(k, j));
          ASSERT_EQ(C, expected) << rows << " x " << columns << " x " << inner << (transposed ? ", transposed" : "")
                                 << ": the product, and nothing beside it";
        }
}

TYPED_TEST(FrontOn, ALowerProductLacksNothingOnAndBelowTheDiagonal) {
  for (const int n : {1, 4, 5, 31, 64, 65, 70, 130}) {
    Eigen::MatrixXd A = random_matrix(n, 40, this->random), C = Eigen::MatrixXd::Zero(n, n);
    SubtractProduct<double, TypeParam>{{C.data(), n}, {A.data(), n}, {A.data(), n}, true, true, n, n, 40}.run();
    const Eigen::MatrixXd expected = -A * A.transpose();
    const Eigen::MatrixXd difference = (C - expected).triangularView<Eigen::Lower>();
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-14 * 40) << n;  // sums of 40 products of numbers below 1
  }
}

TYPED_TEST(FrontOn, EliminationGivesTheInverseOfTheFactorAndTheSchurComplement) {
  // fills the part above the diagonals, which no kernel may read
  const double garbage = std::numeric_limits<double>::quiet_NaN();
  for (const int height : {1, 2, 3, 4, 5, 8, 15, 16, 17, 31, 32, 33, 36, 47, 64, 65, 70}) {
    const Eigen::MatrixXd G = random_matrix(height, height, this->random);
    const Eigen::MatrixXd A = G * G.transpose() + height * Eigen::MatrixXd::Identity(height, height);
    const Eigen::MatrixXd L = A.llt().matrixL();
    for (const int pivots : {1, 2, 3, 4, 5, 7, 8, 16, 31, 32, 33, 40, 65}) {
      if (pivots > height) continue;
      const int below = height - pivots;
      Eigen::MatrixXd panel = A.leftCols(pivots), update = A.bottomRightCorner(below, below), copy(pivots, pivots);
      for (int j = 0; j < pivots; ++j)
        for (int i = 0; i < j; ++i) panel(i, j) = garbage;
      for (int j = 0; j < below; ++j)
        for (int i = 0; i < j; ++i) update(i, j) = garbage;
      const std::vector<double> least(pivots, 0);
      int failed = -1;
      EliminateFront<double, TypeParam>{
          height, pivots, {panel.data(), height}, {update.data(), below}, {copy.data(), pivots}, least.data(), &failed}(
          0);
      ASSERT_EQ(failed, -1);
      const Eigen::MatrixXd inverse = L.topLeftCorner(pivots, pivots)
                                          .triangularView<Eigen::Lower>()
                                          .solve(Eigen::MatrixXd::Identity(pivots, pivots));
      Eigen::MatrixXd expected(height, pivots);
      expected << inverse, -L.bottomLeftCorner(below, pivots) * inverse;
      // The matrix is well conditioned (below 10): some roundings a number.
      const double rounding = 1e-15 * height;
      ASSERT_LT((panel - expected).cwiseAbs().maxCoeff(), rounding) << height << ", " << pivots << " pivots";
      if (below == 0) continue;
      const Eigen::MatrixXd L21 = L.bottomLeftCorner(below, pivots);
      const Eigen::MatrixXd schur = A.bottomRightCorner(below, below) - L21 * L21.transpose();
      double worst = 0;
      for (int j = 0; j < below; ++j)
        for (int i = j; i < below; ++i) worst = std::max(worst, std::abs(update(i, j) - schur(i, j)));
      ASSERT_LT(worst, rounding * height) << height << ", " << pivots << " pivots";
    }
  }
}

TYPED_TEST(FrontOn, APivotOfNothingButRoundingIsReported) {
  for (const int n : {1, 5, 33, 40})
    for (int bad = 0; bad < n; bad += 4) {
      // L L^T with a zero on the diagonal of column `bad`
      const Eigen::MatrixXd all = random_matrix(n, n, this->random);
      Eigen::MatrixXd L = all.triangularView<Eigen::Lower>();
      for (int k = 0; k < n; ++k) L(k, k) = k == bad ? 0 : 1 + std::abs(L(k, k));
      L *= 0.3;
      Eigen::MatrixXd panel = L * L.transpose(), copy(n, n);
      std::vector<double> least(n);
      for (int k = 0; k < n; ++k) least[k] = 1e-9 * panel(k, k);
      int failed = -1;
      double none = 0;
      EliminateFront<double, TypeParam>{
          n, n, {panel.data(), n}, {&none, 0}, {copy.data(), n}, least.data(), &failed}(0);
      EXPECT_EQ(failed, bad) << n;
    }
}

}  // namespace
}  // namespace malha
