// The solvers instantiated for the executors of the host. A GPU backend is one more file like this one, compiled by
// its own compiler.
#include "host/solver/pbd.h"

namespace malha {

namespace {

template <class Executor>
std::unique_ptr<Solver> make(const Model& model, const Executor& executor) {
  if (model.scene.solver.precision == Precision::Double)
    return std::make_unique<Pbd<Executor, double>>(model, executor);
  return std::make_unique<Pbd<Executor, float>>(model, executor);
}

}  // namespace

std::unique_ptr<Solver> make_solver(const Model& model, int threads) {
  if (threads == 0) return make(model, Serial{});
  return make(model, OpenMP{threads});
}

}  // namespace malha
