// Whole solvers on blocks of threads (blocks.h).
#pragma once
#include <memory>

#include "host/solver/solver.h"
#include "tests/blocks.h"

namespace malha {

std::unique_ptr<Solver> make_on_blocks(const Model& model, const Blocks& executor);

}  // namespace malha
