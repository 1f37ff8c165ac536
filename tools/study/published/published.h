// SPDX-License-Identifier: Apache-2.0
// Study "published": published results, repeated with the parameters of the papers.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

Findings run_published(Cells& cells);

}  // namespace malha::study
