// SPDX-License-Identifier: Apache-2.0
// Time integrators that malha is compared with: explicit and symplectic Euler, Runge-Kutta of fourth order, and
// backward Euler by Newton's method.
#pragma once
#include <memory>

#include "tools/study/reference/system.h"

namespace malha::study {

/// x += h v, v += h a(x before): an undamped mode of frequency omega gains the energy (1 + (omega h)^2) a step,
/// whatever h is.
void explicit_euler(const System& system, double h, State& state);

/// v += h a(x), x += h v.
void symplectic_euler(const System& system, double h, State& state);

/// The classical Runge-Kutta method: four evaluations, an error of h^4.
void rk4(const System& system, double h, State& state);

/// Backward Euler, x' = x + h v', v' = v + h a(x'), solved by Newton's method on all coordinates with the true Hessian
/// of the springs, a line search, and a sparse Cholesky factor a turn (without the part by which pressed springs
/// buckle, where there is none with it). Thesis ch. 2; Baraff & Witkin 1998 is its first turn.
class BackwardEuler {
 public:
  explicit BackwardEuler(const SpringSystem& system);
  ~BackwardEuler();

  /// Until the residual is below 1e-10 of the weight and inertia forces, or 50 turns.
  void step(double h, State& state);
  long solves() const;  // factors so far

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace malha::study
