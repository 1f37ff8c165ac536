// SPDX-License-Identifier: Apache-2.0
// A model whose particles get other numbers.
#pragma once
#include <vector>

#include "host/model/model.h"

namespace malha {

/// Puts the particles in the given order (particle order[i] becomes i) and renames them in all that names them, but in
/// the patches and in what is kept of islands, whose particles have to stay together.
void renumber(Model& model, const std::vector<int>& order);

}  // namespace malha
