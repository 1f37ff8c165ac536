// SPDX-License-Identifier: Apache-2.0
// The study "parsimony": no more than a scene needs, measured.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

/// Rows: a feature each, added to the least scene that can have it ("kind": "single"), and the rungs of a ladder
/// ("ladder"), with times, bytes and launches.
Findings run_parsimony(Cells& cells);

}  // namespace malha::study
