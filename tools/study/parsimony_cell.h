// What a feature adds to a scene: launches, bytes and time.
#pragma once
#include "tools/study/cells.h"
#include "tools/study/parsimony_scenes.h"

namespace malha::study {

/// {particles, without, with, added_ms, added_percent}. "without" and "with": {ms_a_step, passes_ms: {air: ...}, bytes:
/// {particles: ...}, launches: [{kernel, launches, items}]} of a step on one thread. Both run in turns, step by step,
/// so that what else the machine does hits them alike, through the same simulated time again and again: a cloth that
/// has swung down is on its ball then. Times are medians over the steps, passes their shares of that; bytes and
/// launches those of the last step. added_ms: the median of the differences between steps of the same turn.
Json parsimony_cell(const Demand& of, const Cells& cells);

}  // namespace malha::study
