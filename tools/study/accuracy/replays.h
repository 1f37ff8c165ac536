// SPDX-License-Identifier: Apache-2.0
// Replays of the study "accuracy".
#pragma once
#include "tools/study/accuracy/cases.h"
#include "tools/study/study.h"

namespace malha::study {

/// Replays of a case: of the small sheet few substeps and many beside the reference, of the free body a corrector that
/// diverges beside one that does not, and none of other cases.
std::vector<Replay> accuracy_replays(const AccuracyCase& test_case);

}  // namespace malha::study
