// SPDX-License-Identifier: Apache-2.0
// Where make_solver is to run instead, for tests: the same scenes and the same expectations on another executor.
#pragma once
#include <memory>

#include "host/solver/solver.h"

namespace malha {

/// Null: on the host.
inline std::unique_ptr<Solver> (*make_elsewhere)(const Model& model, int threads) = nullptr;

}  // namespace malha
