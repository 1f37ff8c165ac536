// SPDX-License-Identifier: Apache-2.0
// Time integrators that malha is compared with: explicit and symplectic Euler, Runge-Kutta of fourth order, and
// backward Euler by Newton's method.
#pragma once
#include <memory>

#include "tools/study/reference/system.h"

namespace malha::study {

/// x += h v, v += h a(previous x). In each step the energy of an undamped mode of frequency omega is multiplied by
/// 1 + (omega h)^2, for any h.
void explicit_euler(const System& system, double h, State& state);

/// v += h a(x), x += h v.
void symplectic_euler(const System& system, double h, State& state);

/// The classical Runge-Kutta method: four evaluations, an error of order h^4.
void rk4(const System& system, double h, State& state);

/// Backward Euler, x' = x + h v', v' = v + h a(x'), solved by Newton's method on all coordinates with the true Hessian
/// of the forces, a line search, and a sparse Cholesky factorisation per iteration (without the indefinite part of
/// compressed springs, if the factorisation fails with it). Baraff & Witkin 1998 is its first iteration.
class BackwardEuler {
 public:
  explicit BackwardEuler(const SpringSystem& system);
  ~BackwardEuler();

  /// Iterates until the residual is below 1e-10 of the weight and inertia forces, but at most 50 times.
  void step(double h, State& state);
  long solves() const;  // number of factorisations so far

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace malha::study
