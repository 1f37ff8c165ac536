// The solvers instantiated for the executors of the host. A GPU backend is one more file like this one, compiled by
// its own compiler.
#include "host/solver/desbrun.h"
#include "host/solver/optional_part.h"
#include "host/solver/pbd.h"

namespace malha {

namespace {

template <class R, class Executor>
std::unique_ptr<Solver> make(const Model& model, const Executor& executor, int threads, const ShowProgress& progress) {
  if (model.scene.solver.type == "desbrun") {
    if constexpr (!built("desbrun"))
      refuse_unbuilt();
    else
      return std::make_unique<Desbrun<Executor, R>>(model, executor, threads, progress);
  }
  return std::make_unique<Pbd<Executor, R>>(model, executor, threads);
}

template <class Executor>
std::unique_ptr<Solver> make(const Model& model, const Executor& executor, int threads, const ShowProgress& progress) {
  if (model.scene.solver.precision == Precision::Double) {
    if constexpr (!built("double"))
      refuse_unbuilt();
    else
      return make<double>(model, executor, threads, progress);
  }
  return make<float>(model, executor, threads, progress);
}

}  // namespace

std::vector<std::string> instruction_sets() {
  std::vector<std::string> names;
  for_each_isa([&]<class Isa>(Isa) { names.push_back(Isa::name); });
  return names;
}

std::unique_ptr<Solver> make_solver(const Model& model, int threads, const std::string& instructions,
                                    const ShowProgress& progress) {
  const std::string wanted = instructions.empty() ? instruction_sets().back() : instructions;
  std::unique_ptr<Solver> made;
  for_each_isa([&]<class Isa>(Isa) {
    if (wanted != Isa::name) return;
    const int count = threads > 0 ? threads : 1;
    made = make(model, OpenMP{count, Isa::value}, count, progress);  // of one thread: Serial at every launch
  });
  if (!made) throw InputError("instructions: this build on this CPU has no \"" + wanted + "\"");
  return made;
}

}  // namespace malha
