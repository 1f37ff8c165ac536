// SPDX-License-Identifier: Apache-2.0
// Takes the place of nested_dissection.cpp in a build without MALHA_METIS.
#include "host/filter/elimination_order.h"

namespace malha {

std::vector<int> elimination_order(const SpringSystem& system) { return minimum_degree_order(system); }

}  // namespace malha
