// SPDX-License-Identifier: Apache-2.0
// A plain Gauss-Seidel sweep of distance constraints, one constraint after the other in any given order: what
// Position Based Dynamics with substeps does without malha's patches, colours and packs.
#pragma once
#include <vector>

#include "tools/study/reference/system.h"

namespace malha::study {

/// All springs by the fewest springs that lead from a pinned particle to their nearer end, the nearest first.
std::vector<int> order_from_pins(const SpringSystem& system);

/// All springs by colour, greedily, those of a colour without a common particle.
std::vector<int> order_by_colour(const SpringSystem& system);

/// What a sweep over hard constraints in this order makes of small displacements from rest: the product of the
/// projections of their linearised lengths.
Eigen::MatrixXd linearised_sweep(const SpringSystem& system, const std::vector<int>& order);

/// By which a substep multiplies motion at most whose sweep is T: the spectral radius of y' = T (2 y - y before), by
/// the eigenvalues of T.
double amplification_of_sweep(const Eigen::MatrixXd& T);

/// x += h v, with v += h g; one sweep (Müller et al. 2006, stiffness 1; with a compliance, m/N, Macklin et al. 2016);
/// v = (p - x) / h. In numbers of type R.
template <class R>
class PlainSweep {
 public:
  PlainSweep(const SpringSystem& system, std::vector<int> order, double compliance = 0);
  void substep(double h);
  State state() const;

 private:
  using Column = Eigen::Matrix<R, 3, 1>;
  const SpringSystem& system_;
  std::vector<int> order_;
  std::vector<Column> x_, v_, p_;
  std::vector<R> w_;  // 1/kg
  double compliance_;
};

}  // namespace malha::study
