// SPDX-License-Identifier: Apache-2.0
#include "tests/parallel/blocks_solvers.h"

#include <cstdlib>

#include "host/filter/make_filter.h"
#include "host/solver/instantiate.h"
#include "host/solver/test_executor_hook.h"

namespace malha {

template <class AnySolve>
void solve_patches(const Blocks& executor, const AnySolve& solve, int begin, int end, const ScratchMemory& memory) {
  parallel_groups(executor, begin, end, memory, solve);
}

std::unique_ptr<Solver> make_on_blocks(const Model& model, const Blocks& executor) {
  return instantiate(model, executor, 1, {});
}

std::uint64_t hash_on_blocks(const Scene& scene, int steps, const Blocks& executor) {
  const Model model = build_model(scene);
  const auto solver = make_on_blocks(model, executor);
  for (int step = 0; step < steps; ++step) solver->step();
  return solver->state_hash();
}

namespace {

/// With MALHA_TESTS_ON=blocks or cuda, all tests of this program run their scenes on that executor.
const bool elsewhere = [] {
  const char* const on = std::getenv("MALHA_TESTS_ON");
  const std::string where = on != nullptr ? on : "host";
  if (where == "blocks")
    make_solver_hook = [](const Model& model, int) { return make_on_blocks(model, {}); };
  else if (where == "cuda")
    make_solver_hook = [](const Model& model, int threads) { return make_solver_on_cuda(model, threads); };
  else if (where != "host")
    throw InputError("MALHA_TESTS_ON: found \"" + where + "\"; allowed: host, blocks, cuda");
  return true;
}();

}  // namespace
}  // namespace malha
