// SPDX-License-Identifier: Apache-2.0
// What a feature adds to a scene: launches, bytes and time.
#pragma once
#include <vector>

#include "malha/scene.h"
#include "tools/study/cells.h"

namespace malha::study {

/// Of each scene {particles, ms_a_step, added_ms, passes_ms: {air: ...}, bytes: {particles: ...}, launches: [{kernel,
/// launches, items}]}, of a step on one thread. They run in turns, step by step, so that what else the machine does
/// hits them alike, through the same simulated time again and again: a cloth that has swung down is on its ball then.
/// Times are medians of processor time over the steps, passes their shares of that; bytes and launches those of the
/// last step. added_ms: the median of the differences to the scene before it in the same turn; 0 of the first.
Json parsimony_cell(const std::vector<Scene>& scenes, const Cells& cells);

}  // namespace malha::study
