// SPDX-License-Identifier: Apache-2.0
// Sections of the study "parsimony": time, memory and launches of each feature, and the ladder.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

std::vector<Section> parsimony_sections(const Json& rows);

}  // namespace malha::study
