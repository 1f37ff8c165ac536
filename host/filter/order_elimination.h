// SPDX-License-Identifier: Apache-2.0
// The order in which the unknowns of a spring system are eliminated.
#pragma once
#include <vector>

#include "host/filter/system.h"

namespace malha {

/// The unknown that is eliminated first, second, ...: nested dissection within each block, the same every
/// time. METIS seeds the C library's rand().
std::vector<int> elimination_order(const SpringSystem& system);

}  // namespace malha
