// SPDX-License-Identifier: Apache-2.0
// Study "accuracy": work-precision diagrams. Each case is a body of springs or tetrahedra whose true motion is known in
// closed form or from a Runge-Kutta run with a converged step; each method runs it at several costs.
#pragma once
#include "tools/study/study.h"

namespace malha::study {

Findings run_accuracy(Cells& cells);

}  // namespace malha::study
