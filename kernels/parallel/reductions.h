// SPDX-License-Identifier: Apache-2.0
// The plain sum of a reduction.
#pragma once
#include "kernels/parallel/compute.h"

namespace malha {

/// In double: exact for counts.
struct Sum {
  double value = 0;
  KERNEL Sum& operator+=(const Sum& o) {
    value += o.value;
    return *this;
  }
};

}  // namespace malha
