// SPDX-License-Identifier: Apache-2.0
// Tells whether the scenes of the tests run on the host or on the executor that MALHA_TESTS_ON names
// (blocks_solvers.cpp).
#pragma once
#include "host/solver/test_executor_hook.h"

namespace malha {

/// Other executors do not time their passes, and launch other kernels.
inline bool scenes_run_on_host() { return make_solver_hook == nullptr; }

}  // namespace malha
