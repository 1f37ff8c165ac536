// SPDX-License-Identifier: Apache-2.0
// Self-intersections of solids of the environment, where inside and outside are undefined.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Adds notes to model.notes on solids with edges that go through their own triangles: how many, and where.
void note_solid_crossings(Model& model);

}  // namespace malha
