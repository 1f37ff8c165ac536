// SPDX-License-Identifier: Apache-2.0
// Bodies at the start, and the one-sided sheets of the environment.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Says in model.notes which bodies start behind a one-sided sheet so that it matters: with particles that contact
/// would put before it in the first step, or that lie behind it by less than its thickness and stay so, or with edges
/// through it, whose ends contact would keep apart. What is behind it as a whole and away from it, and what is beside
/// its rim, may be there.
void note_starts_behind(Model& model);

}  // namespace malha
