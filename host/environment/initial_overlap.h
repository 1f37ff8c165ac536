// SPDX-License-Identifier: Apache-2.0
// Bodies that overlap the environment at the start: its solids, and its one-sided sheets.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Says in model.notes which bodies start behind a one-sided sheet so that it matters: with particles that contact
/// would put before it in the first step, or that lie behind it by less than its thickness and stay so, or with edges
/// through it, whose ends contact would keep apart. What is behind it as a whole and away from it, and what is beside
/// its rim, may be there.
void note_starts_behind(Model& model);

inline constexpr double kNegligibleDepth = 0.01;  // of the thickness: less deep inside or behind a surface, nobody sees it

/// Refuses a body of which a particle that may move starts deeper in a solid than the solid's thickness. Where the
/// solid says push_out, the whole body is moved out instead, as it is and without velocity, and model.notes says by how
/// much; a body that is held is refused there too, and one for which no way out is found, or that self-collision finds
/// crossing another where it came to. What is inside by less stays so, and model.notes says it.
void start_outside(Model& model);

}  // namespace malha
