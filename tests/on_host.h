// SPDX-License-Identifier: Apache-2.0
// Query of the backend on which tests run their scenes: the host, or that of MALHA_TESTS_ON (blocks_solvers.cpp).
#pragma once
#include "host/solver/test_executor_hook.h"

namespace malha {

/// Other backends do not time passes, and a device has different launches.
inline bool scenes_run_on_host() { return make_elsewhere == nullptr; }

}  // namespace malha
