// SPDX-License-Identifier: Apache-2.0
// Solids of the environment that cross themselves: there nothing tells inside from outside.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Says in model.notes which solids have edges that go through their own triangles: how many, and where.
void note_solid_crossings(Model& model);

}  // namespace malha
