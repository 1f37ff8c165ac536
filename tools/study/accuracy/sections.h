// SPDX-License-Identifier: Apache-2.0
// Sections of the study "accuracy" about a case: charts, each with sentences and a table.
#pragma once
#include "tools/study/accuracy/cell.h"
#include "tools/study/study.h"

namespace malha::study {

/// Error over time, error over sweeps, and variants of Desbrun's filter if they were run. `rows`: of all cases.
std::vector<Section> accuracy_sections(const AccuracyCase& test_case, const Truth& truth, const Json& rows);

}  // namespace malha::study
