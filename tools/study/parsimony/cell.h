// SPDX-License-Identifier: Apache-2.0
// A cell of the study "parsimony": launches, bytes and time that a feature adds to a scene.
#pragma once
#include <vector>

#include "malha/scene.h"
#include "tools/study/cells.h"

namespace malha::study {

/// For each scene {particles, ms_a_step, added_ms, passes_ms: {air: ...}, bytes: {particles: ...}, launches: [{kernel,
/// launches, items}]} of a step on one thread. The scenes run in turns, step by step, so that other load of the machine
/// affects them alike, and repeatedly through the same simulated period, in which the cloth has swung down onto its
/// ball. Times are medians of processor time over the steps, and passes their shares of it; bytes and launches are
/// those of the last step. added_ms: the median difference to the previous scene in the same turn; 0 for the first
/// scene.
Json parsimony_cell(const std::vector<Scene>& scenes, const Cells& cells);

}  // namespace malha::study
