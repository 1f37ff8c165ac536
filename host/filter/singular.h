// SPDX-License-Identifier: Apache-2.0
// The refusal of a filter whose system is singular to working precision.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Throws InputError at a particle (the solver's order) whose pivot is only rounding errors. If one constraint is so
/// much stiffer than the others that it costs them their digits, as those of flat triangles, the message names it;
/// otherwise the step is too long for all of them.
[[noreturn]] void refuse_singular(const Model& model, int particle);

}  // namespace malha
