// SPDX-License-Identifier: Apache-2.0
// The refusal of a filter whose system is singular to working precision.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Throws InputError at a particle (the solver's order) of which elimination left nothing but rounding. Where one
/// constraint is so much stiffer than the others that it took their digits, as those of flat triangles are, the message
/// names it; else the step is too long for all of them.
[[noreturn]] void refuse_singular(const Model& model, int particle);

}  // namespace malha
