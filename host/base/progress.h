// SPDX-License-Identifier: Apache-2.0
// Progress of a long set-up.
#pragma once
#include <functional>

namespace malha {

/// Reports the share of a long set-up that is done, in [0, 1]; one thread at a time calls it.
using ShowProgress = std::function<void(const char* what, double part)>;

}  // namespace malha
