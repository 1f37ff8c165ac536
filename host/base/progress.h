// SPDX-License-Identifier: Apache-2.0
// Progress of a long set-up.
#pragma once
#include <functional>

namespace malha {

/// How much of a long set-up is done, in [0, 1]; called by one thread at a time.
using ShowProgress = std::function<void(const char* what, double part)>;

}  // namespace malha
