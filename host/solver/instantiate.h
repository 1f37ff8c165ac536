// SPDX-License-Identifier: Apache-2.0
// Makes the solver of a model's method and precision on any executor. Each backend is one source file that includes
// this.
#pragma once
#include <memory>

#include "host/solver/desbrun.h"
#include "host/solver/pbd.h"

namespace malha {

template <class R, class Executor>
std::unique_ptr<Solver> instantiate(const Model& model, const Executor& executor, int threads,
                                    const ShowProgress& progress) {
  if (model.scene.solver.type == "desbrun")
    return std::make_unique<Desbrun<Executor, R>>(model, executor, threads, progress);
  return std::make_unique<Pbd<Executor, R>>(model, executor, threads, progress);
}

/// `threads`: number of threads of the executor.
template <class Executor>
std::unique_ptr<Solver> instantiate(const Model& model, const Executor& executor, int threads,
                                    const ShowProgress& progress) {
  if (model.scene.solver.precision == Precision::Double) return instantiate<double>(model, executor, threads, progress);
  return instantiate<float>(model, executor, threads, progress);
}

}  // namespace malha
