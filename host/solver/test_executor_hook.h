// SPDX-License-Identifier: Apache-2.0
// Hook for tests: makes make_solver() use another executor, with the same scenes and expectations.
#pragma once
#include <memory>

#include "host/solver/solver.h"

namespace malha {

/// Null: make_solver() uses the host.
inline std::unique_ptr<Solver> (*make_solver_hook)(const Model& model, int threads) = nullptr;

}  // namespace malha
