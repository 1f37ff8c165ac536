// SPDX-License-Identifier: Apache-2.0
// What the study "accuracy" says about a case: its charts, each with sentences and a table.
#pragma once
#include "tools/study/accuracy/cell.h"
#include "tools/study/study.h"

namespace malha::study {

/// `rows`: of all cases. Error over time spent, error over sweeps, and where they were run the variants of Desbrun's
/// filter.
std::vector<Section> accuracy_sections(const AccuracyCase& test_case, const Truth& truth, const Json& rows);

}  // namespace malha::study
