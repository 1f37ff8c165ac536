// SPDX-License-Identifier: Apache-2.0
// Study "size": time, memory and set-up per particle, from small bodies to millions of particles.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

Findings run_size(Cells& cells);

}  // namespace malha::study
