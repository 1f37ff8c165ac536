// SPDX-License-Identifier: Apache-2.0
// Check that a number of threads can be started.
#pragma once

namespace malha {

/// Throws OutOfMemory if so many threads cannot be started. OpenMP would end the program, with a misleading status.
void require_threads(int threads);

}  // namespace malha
