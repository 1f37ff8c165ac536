// SPDX-License-Identifier: Apache-2.0
// Whole solvers on blocks of threads (blocks.h).
#pragma once
#include <cstdint>
#include <memory>

#include "host/solver/solver.h"
#include "tests/parallel/blocks.h"

namespace malha {

std::unique_ptr<Solver> make_on_blocks(const Model& model, const Blocks& executor);

/// The hash of the state after that many steps.
std::uint64_t hash_on_blocks(const Scene& scene, int steps, const Blocks& executor);

}  // namespace malha
