// SPDX-License-Identifier: Apache-2.0
// Study "parsimony": the costs that each feature adds to a scene.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// Rows with times, bytes and launches: one for each feature, added to the smallest scene that can have it ("kind":
/// "single"), and one for each rung of a ladder of features ("ladder").
Findings run_parsimony(Cells& cells);

}  // namespace malha::study
