// SPDX-License-Identifier: Apache-2.0
// Reordering of the particles of a model.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Reorders the particles (particle order[i] becomes i) and updates all indices of particles, except in the patches and
/// the lists of components, whose ranges of particles must stay the same.
void renumber(Model& model, const std::vector<int>& order);

}  // namespace malha
