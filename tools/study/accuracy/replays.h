// SPDX-License-Identifier: Apache-2.0
// What of the study "accuracy" is worth watching.
#pragma once
#include "tools/study/accuracy/cases.h"
#include "tools/study/study.h"

namespace malha::study {

/// Of the small sheet: few substeps and many beside the truth. Of the free body: a corrector that diverges beside one
/// that does not. Of other cases none.
std::vector<Replay> accuracy_replays(const AccuracyCase& test_case);

}  // namespace malha::study
