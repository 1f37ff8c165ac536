// The solvers on a CUDA device (backend_cuda.cu), in builds that have it.
#pragma once
#include <memory>

#include "host/solver/solver.h"
#include "kernels/compute.h"

namespace malha {

/// `host`: for what the host computes.
std::unique_ptr<Solver> instantiate_on_cuda(const Model& model, const OpenMP& host, const ShowProgress& progress);

}  // namespace malha
