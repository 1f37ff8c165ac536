// SPDX-License-Identifier: Apache-2.0
// The solvers on a CUDA device (backend_cuda.cu), in builds that have it.
#pragma once
#include <memory>

#include "host/solver/solver.h"
#include "kernels/parallel/compute.h"

namespace malha {

/// `host`: executor of work on the host.
std::unique_ptr<Solver> instantiate_on_cuda(const Model& model, const OpenMP& host, const ShowProgress& progress,
                                            bool timed);

/// parallel_for_interleaved() for kernels that run on the host, on host memory, compiled by its compiler with packs.
template <class Kernel>
void deal_on_host(const OpenMP& host, int groups, const Kernel& kernel);

}  // namespace malha
