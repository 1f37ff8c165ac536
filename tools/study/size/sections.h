// SPDX-License-Identifier: Apache-2.0
// Sections of the study "size": time, memory and set-up per particle.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

std::vector<Section> size_sections(const Json& rows);

}  // namespace malha::study
