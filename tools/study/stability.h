// Study "stability": where each method fails, how, and what guards the user.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

Findings run_stability(Cells& cells);

}  // namespace malha::study
