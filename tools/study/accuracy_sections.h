// What the study "accuracy" says about a case: charts, the cheapest methods, and sentences.
#pragma once
#include "tools/study/accuracy_cell.h"
#include "tools/study/study.h"

namespace malha::study {

/// `rows`: of all cases. Two sections: error over time spent, error over sweeps.
std::vector<Section> accuracy_sections(const AccuracyCase& of, const Truth& truth, const Json& rows);

}  // namespace malha::study
