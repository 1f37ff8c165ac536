// SPDX-License-Identifier: Apache-2.0
// Whether the scenes of the tests run on the host, or where MALHA_TESTS_ON says (blocks_solvers.cpp).
#pragma once
#include "host/solver/test_executor_hook.h"

namespace malha {

/// Elsewhere passes are not timed, and a device's launches are others.
inline bool scenes_run_on_host() { return make_solver_hook == nullptr; }

}  // namespace malha
