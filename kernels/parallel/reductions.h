// SPDX-License-Identifier: Apache-2.0
// Sum of numbers, for reductions.
#pragma once
#include "kernels/parallel/compute.h"

namespace malha {

/// Sum in double, which is exact for counts.
struct Sum {
  double value = 0;
  KERNEL Sum& operator+=(const Sum& o) {
    value += o.value;
    return *this;
  }
};

}  // namespace malha
