// Study "scaling": how much faster more threads are, on the same body (strong) and on one that grows with them (weak).
#pragma once
#include "tools/study/study.h"

namespace malha::study {

Findings run_scaling(Cells& cells);

}  // namespace malha::study
