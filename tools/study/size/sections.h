// SPDX-License-Identifier: Apache-2.0
// What the study "size" says: time, memory and set-up a particle.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

std::vector<Section> size_sections(const Json& rows);

}  // namespace malha::study
