#include "tests/blocks_solvers.h"

#include "host/filter/make_filter.h"
#include "host/solver/instantiate.h"

namespace malha {

template <class Visited>
void visit_patches(const Blocks& executor, const Visited& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
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

}  // namespace malha
