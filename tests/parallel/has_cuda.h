// SPDX-License-Identifier: Apache-2.0
// Tells whether this build and this machine have a CUDA device.
#pragma once
#include "host/solver/solver.h"
#include "malha/error.h"

namespace malha {

inline bool has_cuda() {
  try {
    require_cuda();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace malha
