// SPDX-License-Identifier: Apache-2.0
// Study "published": cases that papers print, repeated with their own parameters.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

Findings run_published(Cells& cells);

}  // namespace malha::study
