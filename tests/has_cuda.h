// Whether this build and this machine have a CUDA device.
#pragma once
#include "host/error.h"
#include "host/solver/solver.h"

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
