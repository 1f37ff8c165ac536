// SPDX-License-Identifier: Apache-2.0
// The order in which the unknowns of a spring system are eliminated, on which the fill of its factor depends.
#pragma once
#include <vector>

#include "host/filter/system.h"

namespace malha {

/// Smaller systems are solved as fast by one dense supernode.
inline constexpr int kLeastOrdered = 64;

/// The unknown that is eliminated first, second, ...: by METIS's nested dissection, or, in a build without MALHA_METIS,
/// by minimum_degree_order(). Blocks come one after the other. The order is the same every time.
std::vector<int> elimination_order(const SpringSystem& system);

/// The same by approximate minimum degree (Amestoy, Davis, Duff 1996) as Eigen has it.
std::vector<int> minimum_degree_order(const SpringSystem& system);

}  // namespace malha
