// SPDX-License-Identifier: Apache-2.0
// Plain Gauss-Seidel sweep over distance constraints, one after the other in a given order: Position Based Dynamics
// with substeps, without malha's patches, colours and packs.
#pragma once
#include <vector>

#include "tools/study/reference/system.h"

namespace malha::study {

/// All springs in order of their nearer end's graph distance from the pins.
std::vector<int> order_from_pins(const SpringSystem& system);

/// All springs by greedy colouring: springs of a colour have no particle in common.
std::vector<int> order_by_colour(const SpringSystem& system);

/// The matrix of a sweep over hard constraints in this order, which acts on small displacements from rest: the product
/// of the projections of their linearised lengths.
Eigen::MatrixXd linearised_sweep(const SpringSystem& system, const std::vector<int>& order);

/// The amplification factor of a substep whose sweep is T: the spectral radius of y' = T (2 y - previous y), from the
/// eigenvalues of T.
double amplification_of_sweep(const Eigen::MatrixXd& T);

/// x += h v, with v += h g; one sweep (Müller et al. 2006, stiffness 1; with a compliance, m/N, Macklin et al. 2016);
/// v = (p - x) / h. Computed in type R.
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
