// The solvers instantiated for the executors of the host. A GPU backend is one more file like this one, compiled by
// its own compiler.
#include "host/solver/pbd.h"

namespace malha {

namespace {

template <class Executor>
std::unique_ptr<Solver> make(const Model& model, const Executor& executor, int threads) {
  if (model.scene.solver.precision == Precision::Double)
    return std::make_unique<Pbd<Executor, double>>(model, executor, threads);
  return std::make_unique<Pbd<Executor, float>>(model, executor, threads);
}

}  // namespace

std::vector<std::string> instruction_sets() {
  std::vector<std::string> names;
  for_each_isa([&]<class Isa>(Isa) { names.push_back(Isa::name); });
  return names;
}

std::unique_ptr<Solver> make_solver(const Model& model, int threads, const std::string& instructions) {
  const std::string wanted = instructions.empty() ? instruction_sets().back() : instructions;
  std::unique_ptr<Solver> made;
  for_each_isa([&]<class Isa>(Isa) {
    if (wanted != Isa::name) return;
    made = threads == 0 ? make(model, Serial{Isa::value}, 1) : make(model, OpenMP{threads, Isa::value}, threads);
  });
  if (!made) throw InputError("instructions: this build on this CPU has no \"" + wanted + "\"");
  return made;
}

}  // namespace malha
